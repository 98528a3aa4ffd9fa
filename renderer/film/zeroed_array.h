// Arrays that start with zero bits, taken from zeroed pages of the system.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace kindling {

// An array of records whose initial value is all zero bits. The system zeroes the pages of a large
// array when they are first touched, so that work is distributed to the threads that write them,
// and untouched pages take no memory.
template <typename T>
class ZeroedArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T> &&
                alignof(T) <= alignof(std::max_align_t));

 public:
  using value_type = T;

  ZeroedArray() = default;
  explicit ZeroedArray(size_t size) : size_(size) { // throws std::bad_alloc
    if (size == 0) return;
    if (size > std::numeric_limits<size_t>::max() / sizeof(T)) throw std::bad_alloc();
    records_.reset(static_cast<T*>(std::calloc(size, sizeof(T))));
    if (!records_) throw std::bad_alloc();
  }
  ZeroedArray(const ZeroedArray& other) : ZeroedArray(other.size_) { std::copy(other.begin(), other.end(), begin()); }
  ZeroedArray(ZeroedArray&& other) noexcept
      : records_(std::move(other.records_)), size_(std::exchange(other.size_, 0)) {}
  ZeroedArray& operator=(ZeroedArray other) noexcept {
    records_ = std::move(other.records_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }
  ~ZeroedArray() = default;

  [[nodiscard]] size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* data() { return records_.get(); }
  [[nodiscard]] const T* data() const { return records_.get(); }
  [[nodiscard]] T* begin() { return records_.get(); }
  [[nodiscard]] const T* begin() const { return records_.get(); }
  [[nodiscard]] T* end() { return records_.get() + size_; }
  [[nodiscard]] const T* end() const { return records_.get() + size_; }
  [[nodiscard]] T& operator[](size_t index) {
    assert(index < size_);
    return records_.get()[index];
  }
  [[nodiscard]] const T& operator[](size_t index) const {
    assert(index < size_);
    return records_.get()[index];
  }

 private:
  struct Free {
    void operator()(T* records) const { std::free(records); }
  };
  std::unique_ptr<T[], Free> records_;
  size_t size_ = 0;
};

} // namespace kindling
