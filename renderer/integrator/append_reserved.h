// Appending to vectors whose memory is there already.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <vector>

namespace kindling {

// push_back() to a vector that has room for the value. The compiler may leave out growth, which
// would make a call of what is otherwise a few instructions, and inlines the rest.
template <typename T>
[[gnu::flatten]] void append_reserved(std::vector<T>& vector, const T& value) {
  assert(vector.size() < vector.capacity());
  if (vector.size() == vector.capacity()) __builtin_unreachable();
  vector.push_back(value);
}

} // namespace kindling
