// Vectors that leave new elements uninitialized, for arrays that many threads fill.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace kindling {

// Like std::allocator, but elements without an initial value are default-initialized: numbers have
// indeterminate values until they are written.
template <typename T>
struct UninitializedAllocator : std::allocator<T> {
  UninitializedAllocator() = default;
  template <typename U>
  UninitializedAllocator(const UninitializedAllocator<U>& /*other*/) noexcept {} // NOLINT: as allocators convert
  template <typename U>
  struct rebind {
    using other = UninitializedAllocator<U>;
  };
  template <typename U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
  template <typename U, typename... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
};

// resize() leaves numbers uninitialized, so the pages of a large vector are first touched by the
// threads that write them.
template <typename T>
using UninitializedVector = std::vector<T, UninitializedAllocator<T>>;

} // namespace kindling
