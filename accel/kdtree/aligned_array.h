// A fixed-size aligned array, on huge pages if it is large and the system supports them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace kindling::accel::kd {

// Elements are not initialized, and T must be trivial.
template <class T>
class AlignedArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  AlignedArray() = default;
  explicit AlignedArray(size_t size) : size_(size) {
    if (size == 0) return;
    const size_t wanted = size * sizeof(T);
#if defined(__linux__)
    if (wanted >= kHugePage) {
      map(wanted);
      return;
    }
#endif
    data_ = {static_cast<T*>(std::aligned_alloc(64, (wanted + 63) / 64 * 64)), Free{0}};
    if (data_ == nullptr) throw std::bad_alloc();
  }

  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] T& operator[](size_t i) {
    assert(i < size_);
    return data_.get()[i];
  }
  [[nodiscard]] const T& operator[](size_t i) const {
    assert(i < size_);
    return data_.get()[i];
  }

 private:
  static constexpr size_t kHugePage = size_t{2} << 20;

  struct Free {
    size_t mapped_bytes = 0; // 0 if allocated on the heap
    void operator()(T* data) const {
#if defined(__linux__)
      if (mapped_bytes != 0) {
        munmap(data, mapped_bytes);
        return;
      }
#endif
      std::free(data);
    }
  };

#if defined(__linux__)
  // Maps fresh pages directly from the system: the heap would return used pages, which stay small
  // whatever is advised.
  void map(size_t wanted) {
    const size_t bytes = (wanted + kHugePage - 1) / kHugePage * kHugePage, with_margin = bytes + kHugePage;
    void* mapping = mmap(nullptr, with_margin, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapping == MAP_FAILED) throw std::bad_alloc();
    auto* first = static_cast<std::byte*>(mapping);
    const size_t before = (kHugePage - reinterpret_cast<uintptr_t>(first) % kHugePage) % kHugePage;
    if (before != 0) munmap(first, before);
    if (before != kHugePage) munmap(first + before + bytes, kHugePage - before);
    first += before;
    madvise(first, bytes, MADV_HUGEPAGE); // a hint; failure is harmless
    data_ = {reinterpret_cast<T*>(first), Free{bytes}};
  }
#endif

  std::unique_ptr<T, Free> data_;
  size_t size_ = 0;
};

} // namespace kindling::accel::kd
