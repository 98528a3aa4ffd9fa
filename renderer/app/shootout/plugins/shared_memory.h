// Memory that two processes share, and arrays laid out in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace kindling::app {

// Descriptors below this one are overwritten in the process of a plugin.
inline constexpr int kLowestDescriptor = 100;

// A mapped file without a name (memfd_create). Movable; unmapped and closed by the destructor.
class SharedMemory {
 public:
  // New memory of zeros, for reading and writing. Fails (render_failed) without memory.
  [[nodiscard]] static Result<SharedMemory> create(size_t bytes);
  // Maps the memory behind an inherited descriptor, which it owns from then on; all of it is
  // resident at once, so that no measurement has its page faults. Fails
  // (render_failed) if there is none.
  [[nodiscard]] static Result<SharedMemory> open(int descriptor, bool writable);

  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&& other) noexcept;
  ~SharedMemory();

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] std::byte* data() { return data_; }
  [[nodiscard]] const std::byte* data() const { return data_; }

  // The array of `count` elements at an offset; nullopt if it leaves the memory or is misaligned.
  template <typename T>
  [[nodiscard]] std::optional<std::span<T>> array(uint64_t offset, uint64_t count) {
    if (offset % alignof(T) != 0 || offset > size_ || count > (size_ - offset) / sizeof(T)) return std::nullopt;
    return std::span<T>(reinterpret_cast<T*>(data_ + offset), count);
  }

 private:
  SharedMemory(int descriptor, std::byte* data, size_t size) : descriptor_(descriptor), data_(data), size_(size) {}

  int descriptor_ = -1;
  std::byte* data_ = nullptr;
  size_t size_ = 0;
};

} // namespace kindling::app
