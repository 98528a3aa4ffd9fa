// Checks of shapes and types; messages name the value given and what would be accepted.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/python/strided_array.h"

#include <algorithm>

namespace kindling::python {
namespace {

[[noreturn]] void raise_shape(const Array& array, const char* name, const std::string& accepted) {
  throw nb::value_error((std::string(name) + ": shape " + shape_text(array) + ", expected " + accepted).c_str());
}

[[noreturn]] void raise_type(const Array& array, const char* name, const char* accepted) {
  throw nb::type_error((std::string(name) + ": dtype " + dtype_text(array) + ", expected " + accepted).c_str());
}

} // namespace

std::string shape_text(const Array& array) {
  std::string text = "(";
  for (size_t k = 0; k < array.ndim(); ++k) text += (k > 0 ? ", " : "") + std::to_string(array.shape(k));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

std::string dtype_text(const Array& array) {
  const nb::dlpack::dtype type = array.dtype();
  const char* kind = "type";
  switch (static_cast<nb::dlpack::dtype_code>(type.code)) {
  case nb::dlpack::dtype_code::Int: kind = "int"; break;
  case nb::dlpack::dtype_code::UInt: kind = "uint"; break;
  case nb::dlpack::dtype_code::Float: kind = "float"; break;
  case nb::dlpack::dtype_code::Complex: kind = "complex"; break;
  case nb::dlpack::dtype_code::Bool: return "bool";
  default: break;
  }
  return kind + std::to_string(type.bits);
}

Floats::Floats(const Array& array, const char* name, size_t columns) : data_(array.data()) {
  const size_t own = columns == 0 ? 0 : 1;
  std::string accepted = columns == 0 ? "() or (n,)" : "(#,) or (n, #)";
  std::replace(accepted.begin(), accepted.end(), '#', static_cast<char>('0' + columns)); // 3 or 4
  if (array.ndim() != own && array.ndim() != own + 1) raise_shape(array, name, accepted);
  if (columns != 0 && array.shape(array.ndim() - 1) != columns) raise_shape(array, name, accepted);
  is_double_ = array.dtype() == nb::dtype<double>();
  if (!is_double_ && array.dtype() != nb::dtype<float>()) raise_type(array, name, "float32 or float64");
  if (array.ndim() == own + 1) {
    rows_ = array.shape(0);
    row_stride_ = array.stride(0);
  }
  if (columns != 0) column_stride_ = array.stride(array.ndim() - 1);
  static const float kNothing = 0.0f;
  if (data_ == nullptr) data_ = &kNothing; // an empty array, never read
}

Triples::Triples(const Array& array, const char* name) : data_(array.data()) {
  if (array.ndim() != 2 || array.shape(1) != 3) raise_shape(array, name, "(n, 3)");
  const bool is_uint = array.dtype() == nb::dtype<uint32_t>() || array.dtype() == nb::dtype<uint64_t>();
  is_wide_ = array.dtype() == nb::dtype<int64_t>() || array.dtype() == nb::dtype<uint64_t>();
  is_signed_ = !is_uint;
  if (!is_uint && !is_wide_ && array.dtype() != nb::dtype<int32_t>())
    raise_type(array, name, "int32, int64, uint32 or uint64");
  rows_ = array.shape(0);
  row_stride_ = array.stride(0);
  column_stride_ = array.stride(1);
}

int64_t Triples::at(size_t row, size_t column) const {
  const auto offset = static_cast<int64_t>(row) * row_stride_ + static_cast<int64_t>(column) * column_stride_;
  if (is_wide_) return static_cast<const int64_t*>(data_)[offset];
  return is_signed_ ? static_cast<const int32_t*>(data_)[offset] : static_cast<const uint32_t*>(data_)[offset];
}

} // namespace kindling::python
