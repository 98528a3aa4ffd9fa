// Rows of three numbers and single numbers out of NumPy arrays of any strides.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ImathMatrix.h>
#include <ImathVec.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace kindling::python {

namespace nb = nanobind;

// A read-only array of numbers on the CPU.
using Array = nb::ndarray<nb::ro, nb::device::cpu>;

// Returns e.g. "(4, 3)".
[[nodiscard]] std::string shape_text(const Array& array);
// Returns e.g. "float64".
[[nodiscard]] std::string dtype_text(const Array& array);

// Floating-point numbers of an array, rounded to float. Borrows the array. One row or number may
// stand for all rays.
class Floats {
 public:
  // `name` begins the messages. Raises ValueError unless the array has shape (columns,) or (n,
  // columns); columns 0 stands for () or (n,). Raises TypeError unless it holds float32 or float64.
  Floats(const Array& array, const char* name, size_t columns);
  // One number for all rays.
  explicit Floats(float constant) : constant_(constant) {}

  // Returns the number of rows; kAny if one stands for all.
  static constexpr size_t kAny = static_cast<size_t>(-1);
  [[nodiscard]] size_t rows() const { return rows_; }

  // Calls put(i, x, y, z) with the rows from `first` on, i from 0 to count - 1.
  template <class Put>
  void for_rows3(size_t first, size_t count, const Put& put) const {
    const auto from = [&](const auto* numbers) {
      numbers += static_cast<int64_t>(first) * row_stride_;
      for (size_t i = 0; i < count; ++i, numbers += row_stride_)
        put(i, static_cast<float>(numbers[0]), static_cast<float>(numbers[column_stride_]),
            static_cast<float>(numbers[2 * column_stride_]));
    };
    if (is_double_)
      from(static_cast<const double*>(data_));
    else
      from(static_cast<const float*>(data_));
  }
  // Calls put(i, x) with single numbers, likewise.
  template <class Put>
  void for_numbers(size_t first, size_t count, const Put& put) const {
    const bool any = rows_ == kAny;
    const float constant = any ? number(0) : 0.0f;
    for (size_t i = 0; i < count; ++i) put(i, any ? constant : number(first + i));
  }
  [[nodiscard]] Imath::V3f row3(size_t row) const { return {at(row, 0), at(row, 1), at(row, 2)}; }
  // Returns the transpose of four rows of four: a matrix for row vectors.
  [[nodiscard]] Imath::M44f matrix() const {
    Imath::M44f m;
    for (size_t row = 0; row < 4; ++row)
      for (size_t column = 0; column < 4; ++column)
        m[static_cast<int>(column)][static_cast<int>(row)] = at(row, column);
    return m;
  }

 private:
  [[nodiscard]] float number(size_t row) const { return data_ == nullptr ? constant_ : at(row, 0); }
  [[nodiscard]] float at(size_t row, size_t column) const {
    const auto offset = static_cast<int64_t>(row) * row_stride_ + static_cast<int64_t>(column) * column_stride_;
    return is_double_ ? static_cast<float>(static_cast<const double*>(data_)[offset])
                      : static_cast<const float*>(data_)[offset];
  }

  const void* data_ = nullptr;
  bool is_double_ = false;
  size_t rows_ = kAny;
  int64_t row_stride_ = 0, column_stride_ = 0; // in elements
  float constant_ = 0.0f;
};

// Integers of an array of shape (n, 3): int32, int64, uint32 or uint64. Borrows the array.
class Triples {
 public:
  Triples(const Array& array, const char* name);
  [[nodiscard]] size_t rows() const { return rows_; }
  // Indices of uint64 beyond the range of int64 come out negative.
  [[nodiscard]] int64_t at(size_t row, size_t column) const;

 private:
  const void* data_ = nullptr;
  bool is_wide_ = false, is_signed_ = false;
  size_t rows_ = 0;
  int64_t row_stride_ = 0, column_stride_ = 0;
};

} // namespace kindling::python
