// Whole files in memory, and their 64-bit hash.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace kindling::gltf {

using Bytes = std::span<const std::byte>;

[[nodiscard]] inline std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Memory that is not cleared first: it is about to be filled.
class OwnedBytes {
 public:
  OwnedBytes() = default;
  explicit OwnedBytes(size_t size) : data_(std::make_unique_for_overwrite<std::byte[]>(size)), size_(size) {}

  [[nodiscard]] std::byte* data() { return data_.get(); }
  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] Bytes span() const { return {data_.get(), size_}; }
  void shrink(size_t size) { size_ = size < size_ ? size : size_; }

 private:
  std::unique_ptr<std::byte[]> data_;
  size_t size_ = 0;
};

// A copy, not a mapping: what was validated cannot change under us, and a file cut short elsewhere cannot raise SIGBUS.
// Only regular files of at most `max_bytes`; of one that shrinks meanwhile, what is left. Large ones are read in parallel with TBB. The
// error says what is wrong but not the file's name.
[[nodiscard]] Result<OwnedBytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);

// XXH64 (Collet, xxHash specification 0.1.1): about 10 GB/s, the same on every machine.
[[nodiscard]] uint64_t hash_bytes(Bytes bytes, uint64_t seed = 0);

// Of whole files and images. Up to kHashedBlock bytes it is hash_bytes(); of more it is hash_bytes(words, seed) of 64-bit words, the lowest
// byte first: hash_bytes() with seed 0 of each kHashedBlock bytes (of the rest that is left at the end), and last the number of
// all bytes. So blocks are hashed in parallel with TBB, and the number does not depend on the threads.
inline constexpr size_t kHashedBlock = size_t{1} << 20;
[[nodiscard]] uint64_t hash_content(Bytes bytes, uint64_t seed = 0);

} // namespace kindling::gltf
