// The memory behind a view: finished arrays and their owner.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace kindling {

// A view is a struct of numbers and of spans of trivially copyable elements, with the functions
// that rendering calls. It can be copied like a number, to another device too, once its spans point
// to copies of the arrays there. Its owner derives from it, builds the arrays and keeps them here.
// Copies of an owner share the arrays.
class OwnedArrays {
 public:
  // Takes the elements of a vector; returns them at their final place.
  template <typename Vector>
  [[nodiscard]] std::span<const typename Vector::value_type> keep(Vector elements) {
    if (elements.empty()) return {};
    const auto stored = std::make_shared<const Vector>(std::move(elements));
    bytes_ += stored->size() * sizeof(typename Vector::value_type);
    arrays_.push_back(stored);
    return *stored;
  }
  // Keeps an array that has other owners, too; its bytes are not counted.
  void share(std::shared_ptr<const void> array) { arrays_.push_back(std::move(array)); }

  // Returns the size of all elements in this object's own arrays.
  [[nodiscard]] size_t bytes() const { return bytes_; }

 private:
  std::vector<std::shared_ptr<const void>> arrays_;
  size_t bytes_ = 0;
};

} // namespace kindling
