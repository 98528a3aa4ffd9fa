// Receiving and reading of messages, after tev's documentation of its protocol.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/tev_viewer.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

namespace kindling::test {

namespace {

class Reader {
 public:
  explicit Reader(const std::vector<std::byte>& bytes) : bytes_(bytes) {}
  template <typename Value>
  Value take() {
    Value value;
    if (bytes_.size() - next_ < sizeof value) throw std::runtime_error("a message is too short");
    std::memcpy(&value, &bytes_[next_], sizeof value);
    next_ += sizeof value;
    return value;
  }
  std::string take_text() {
    std::string text;
    while (const char c = take<char>()) text += c;
    return text;
  }
  [[nodiscard]] size_t left() const { return bytes_.size() - next_; }

 private:
  const std::vector<std::byte>& bytes_;
  size_t next_ = sizeof(uint32_t); // behind the length
};

} // namespace

TevViewer::TevViewer(size_t bytes_taken) : listening_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(listen(listening_, 1), 0);
  EXPECT_EQ(getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &size), 0);
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this, bytes_taken] { receive(bytes_taken); });
}

TevViewer::~TevViewer() {
  shutdown(listening_, SHUT_RDWR); // no sender may have connected
  if (thread_.joinable()) thread_.join();
  close(listening_);
}

std::string TevViewer::address() const { return "127.0.0.1:" + std::to_string(port_); }

const std::map<std::string, TevViewer::Image>& TevViewer::finish() {
  if (thread_.joinable()) thread_.join();
  return images_;
}

void TevViewer::receive(size_t bytes_taken) {
  const int connection = accept(listening_, nullptr, nullptr);
  if (connection < 0) return;
  std::vector<std::byte> bytes;
  std::array<std::byte, 65536> chunk;
  for (size_t taken = 0; taken < bytes_taken;) {
    const ssize_t size = recv(connection, chunk.data(), chunk.size(), 0);
    if (size <= 0) break;
    taken += static_cast<size_t>(size);
    bytes.insert(bytes.end(), chunk.begin(), chunk.begin() + size);
  }
  close(connection);
  if (bytes_taken != SIZE_MAX) return; // cut off on purpose
  try {
    for (size_t next = 0; next < bytes.size();) {
      uint32_t length = 0;
      if (bytes.size() - next >= sizeof length) std::memcpy(&length, &bytes[next], sizeof length);
      if (length <= sizeof length || length > bytes.size() - next) throw std::runtime_error("a length is wrong");
      const auto first = bytes.begin() + static_cast<ptrdiff_t>(next);
      take_message({first, first + length});
      next += length;
    }
  } catch (const std::exception& error) {
    errors_.emplace_back(error.what());
  }
}

void TevViewer::take_message(const std::vector<std::byte>& bytes) {
  Reader reader(bytes);
  const auto type = reader.take<uint8_t>();
  reader.take<uint8_t>(); // whether to show the image
  const std::string name = reader.take_text();
  const auto take_channels = [&reader] {
    std::vector<std::string> channels(static_cast<size_t>(reader.take<int32_t>()));
    for (std::string& channel : channels) channel = reader.take_text();
    return channels;
  };
  if (type == 4) {
    Image& image = images_[name];
    image.width = reader.take<int32_t>();
    image.height = reader.take<int32_t>();
    image.channels = take_channels();
    image.values.assign(static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * image.channels.size(),
                        0);
  } else if (type == 6) {
    if (!images_.contains(name)) throw std::runtime_error("an image is updated before it is made");
    Image& image = images_[name];
    if (take_channels() != image.channels) throw std::runtime_error("channels differ");
    const auto x = reader.take<int32_t>(), y = reader.take<int32_t>();
    const auto width = reader.take<int32_t>(), height = reader.take<int32_t>();
    if (x < 0 || y < 0 || width < 1 || height < 1 || x + width > image.width || y + height > image.height)
      throw std::runtime_error("a rectangle is outside of the image");
    const size_t count = image.channels.size();
    std::vector<int64_t> offsets(count), strides(count);
    for (int64_t& offset : offsets) offset = reader.take<int64_t>();
    for (int64_t& stride : strides) stride = reader.take<int64_t>();
    std::vector<float> values(reader.left() / sizeof(float));
    for (float& value : values) value = reader.take<float>();
    for (int64_t pixel = 0; pixel < int64_t{width} * height; ++pixel)
      for (size_t c = 0; c < count; ++c) {
        const int64_t to = (y + pixel / width) * image.width + x + pixel % width;
        image.values[static_cast<size_t>(to) * count + c] =
            values.at(static_cast<size_t>(offsets[c] + pixel * strides[c]));
      }
    ++image.updates;
  } else {
    throw std::runtime_error("an unknown message");
  }
  if (reader.left() > 0) throw std::runtime_error("a message is too long");
}

} // namespace kindling::test
