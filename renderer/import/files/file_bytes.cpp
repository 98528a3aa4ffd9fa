// Parallel reading of files, and XXH64 by blocks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/file_bytes.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <vector>

namespace kindling::gltf {
namespace {

constexpr uint64_t kPrime1 = 0x9e3779b185ebca87ULL;
constexpr uint64_t kPrime2 = 0xc2b2ae3d27d4eb4fULL;
constexpr uint64_t kPrime3 = 0x165667b19e3779f9ULL;
constexpr uint64_t kPrime4 = 0x85ebca77c2b2ae63ULL;
constexpr uint64_t kPrime5 = 0x27d4eb2f165667c5ULL;

template <typename T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

uint64_t round_lane(uint64_t lane, uint64_t input) { return std::rotl(lane + input * kPrime2, 31) * kPrime1; }

uint64_t merge_lane(uint64_t hash, uint64_t lane) { return (hash ^ round_lane(0, lane)) * kPrime1 + kPrime4; }

class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (is_open()) ::close(descriptor_);
  }
  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }

  struct Got {
    size_t bytes = 0; // fewer than requested: the file ends there, or reading failed
    bool failed = false;
  };
  [[nodiscard]] Got read(std::span<std::byte> into, size_t offset) const {
    Got got;
    while (got.bytes < into.size()) {
      const ssize_t count = ::pread(descriptor_, into.data() + got.bytes, into.size() - got.bytes,
                                    static_cast<off_t>(offset + got.bytes));
      if (count < 0 && errno == EINTR) continue;
      got.failed = count < 0;
      if (count <= 0) break;
      got.bytes += static_cast<size_t>(count);
    }
    return got;
  }

 private:
  int descriptor_;
};

constexpr size_t kReadBlock = size_t{1} << 20;

} // namespace

Result<OwnedBytes> read_file(const std::filesystem::path& path, uint64_t max_bytes) {
  const auto wrong = [](std::string what) { return Error{ErrorKind::input_output, std::move(what)}; };
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (status.type() == std::filesystem::file_type::not_found) return wrong("no such file");
  if (code) return wrong(fmt::format("cannot be read: {}", code.message()));
  if (!std::filesystem::is_regular_file(status)) return wrong("is not a regular file");
  const uint64_t size = std::filesystem::file_size(path, code);
  if (code) return wrong(fmt::format("cannot be read: {}", code.message()));
  if (size > max_bytes) return wrong(fmt::format("has {} bytes, at most {} are accepted", size, max_bytes));

  const OpenFile file(path);
  if (!file.is_open()) return wrong(fmt::format("cannot be opened: {}", std::generic_category().message(errno)));
  OwnedBytes bytes(size);
  std::vector<OpenFile::Got> blocks((size + kReadBlock - 1) / kReadBlock);
  tbb::parallel_for(size_t{0}, blocks.size(), [&](size_t i) {
    const size_t begin = i * kReadBlock;
    blocks[i] = file.read({bytes.data() + begin, std::min(kReadBlock, size - begin)}, begin);
  });
  size_t got = 0;
  for (const OpenFile::Got& block : blocks) { // up to the first incomplete block
    if (block.failed) return wrong("cannot be read to its end");
    got += block.bytes;
    if (block.bytes < kReadBlock) break;
  }
  bytes.shrink(got);
  return bytes;
}

uint64_t hash_bytes(Bytes bytes, uint64_t seed) {
  const std::byte* at = bytes.data();
  size_t left = bytes.size();
  uint64_t hash = seed + kPrime5;
  if (left >= 32) {
    uint64_t lanes[4] = {seed + kPrime1 + kPrime2, seed + kPrime2, seed, seed - kPrime1};
    for (; left >= 32; at += 32, left -= 32) {
      for (int i = 0; i < 4; ++i) lanes[i] = round_lane(lanes[i], load<uint64_t>(at + 8 * i));
    }
    hash = std::rotl(lanes[0], 1) + std::rotl(lanes[1], 7) + std::rotl(lanes[2], 12) + std::rotl(lanes[3], 18);
    for (const uint64_t lane : lanes) hash = merge_lane(hash, lane);
  }
  hash += bytes.size();
  for (; left >= 8; at += 8, left -= 8) {
    hash = std::rotl(hash ^ round_lane(0, load<uint64_t>(at)), 27) * kPrime1 + kPrime4;
  }
  if (left >= 4) {
    hash = std::rotl(hash ^ (load<uint32_t>(at) * kPrime1), 23) * kPrime2 + kPrime3;
    at += 4;
    left -= 4;
  }
  for (; left > 0; ++at, --left) hash = std::rotl(hash ^ (std::to_integer<uint64_t>(*at) * kPrime5), 11) * kPrime1;
  hash = (hash ^ (hash >> 33)) * kPrime2;
  hash = (hash ^ (hash >> 29)) * kPrime3;
  return hash ^ (hash >> 32);
}

uint64_t hash_content(Bytes bytes, uint64_t seed) {
  if (bytes.size() <= kHashedBlock) return hash_bytes(bytes, seed);
  static_assert(std::endian::native == std::endian::little);
  std::vector<uint64_t> words((bytes.size() + kHashedBlock - 1) / kHashedBlock);
  tbb::parallel_for(size_t{0}, words.size(), [&](size_t i) {
    const size_t begin = i * kHashedBlock;
    words[i] = hash_bytes(bytes.subspan(begin, std::min(kHashedBlock, bytes.size() - begin)));
  });
  words.push_back(bytes.size());
  return hash_bytes(std::as_bytes(std::span(words)), seed);
}

} // namespace kindling::gltf
