// Serialization of messages to tev.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/tev/tev_packets.h"

#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <cstring>

namespace kindling::app {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::array<std::string_view, 4> kChannels{"R", "G", "B", "A"};
constexpr auto kChannelCount = static_cast<int32_t>(kChannels.size());

enum class MessageType : uint8_t { create_image = 4, update_image = 6 }; // the second with offsets and strides

class Message {
 public:
  explicit Message(MessageType type) : bytes_(sizeof(uint32_t)) { add(type); }

  template <typename Value>
  void add(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    append(&value, sizeof value);
  }
  void add_flag(bool value) { add(static_cast<uint8_t>(value)); }
  void add_text(std::string_view text) {
    append(text.data(), text.size());
    add(char{0});
  }
  void add_channels() {
    for (const std::string_view channel : kChannels) add_text(channel);
  }
  void append(const void* data, size_t size) {
    const auto* const bytes = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), bytes, bytes + size);
  }

  [[nodiscard]] std::vector<std::byte> finish() && {
    const auto length = static_cast<uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof length);
    return std::move(bytes_);
  }

 private:
  std::vector<std::byte> bytes_; // the length first
};

} // namespace

std::vector<std::byte> tev_create_image(std::string_view name, const V2i& size_px) {
  Message message(MessageType::create_image);
  message.add_flag(true); // shows the image
  message.add_text(name);
  message.add(static_cast<int32_t>(size_px.x));
  message.add(static_cast<int32_t>(size_px.y));
  message.add(kChannelCount);
  message.add_channels();
  return std::move(message).finish();
}

std::vector<std::byte> tev_update_image(std::string_view name, const PixelRect& rect, std::span<const float> rgba) {
  assert(rgba.size() == static_cast<size_t>(rect.pixel_count()) * kChannels.size());
  Message message(MessageType::update_image);
  message.add_flag(false);
  message.add_text(name);
  message.add(kChannelCount);
  message.add_channels();
  for (const int value : {rect.min.x, rect.min.y, rect.width(), rect.height()}) message.add(int32_t{value});
  for (int64_t channel = 0; channel < kChannelCount; ++channel) message.add(channel); // offsets, in floats
  for (int64_t channel = 0; channel < kChannelCount; ++channel) message.add(int64_t{kChannelCount}); // strides
  message.append(rgba.data(), rgba.size_bytes());
  return std::move(message).finish();
}

} // namespace kindling::app
