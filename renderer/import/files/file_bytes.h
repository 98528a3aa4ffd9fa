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

// An owned array of bytes, uninitialized after construction.
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

// Returns a copy of a regular file of at most `max_bytes`. The file is not mapped: validated bytes
// cannot change later, and a truncated file cannot raise SIGBUS. A file that shrinks while it is
// read gives the bytes that are left. Large files are read in parallel with TBB. The error lacks
// the file's name.
[[nodiscard]] Result<OwnedBytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);

// Returns the XXH64 hash (Collet, xxHash specification 0.1.1): about 10 GB/s, the same on every
// machine.
[[nodiscard]] uint64_t hash_bytes(Bytes bytes, uint64_t seed = 0);

// Returns the hash of a whole file or image. Up to kHashedBlock bytes it is hash_bytes(). For more
// bytes it is hash_bytes(words, seed) over 64-bit little-endian words: hash_bytes() with seed 0 of
// each block of kHashedBlock bytes (the last block may be shorter), then the number of all bytes.
// Blocks are hashed in parallel with TBB; the result does not depend on the number of threads.
inline constexpr size_t kHashedBlock = size_t{1} << 20;
[[nodiscard]] uint64_t hash_content(Bytes bytes, uint64_t seed = 0);

} // namespace kindling::gltf
