// Accessors: bounds are checked once, then elements are read as floats or indices.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/import/document/document.h"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace kindling::gltf {

// The location and format of elements, from view_accessor() or the Draco decoder.
struct AccessorView {
  const std::byte* data = nullptr; // null: all zero before the sparse values
  size_t stride = 0;               // bytes from one element to the next
  size_t count = 0;
  int component_type = 5126; // glTF's code; 5126: float
  int components = 1;
  bool normalized = false;

  size_t sparse_count = 0;
  const std::byte* sparse_indices = nullptr; // strictly increasing, below count
  int sparse_index_type = 5125;
  const std::byte* sparse_values = nullptr; // tightly packed
};

[[nodiscard]] size_t component_bytes(int component_type);

// Checks that every accessor fits its bufferView and that sparse indices increase. Others become
// Document::faulty_accessors, or throw ImportFailure if `warnings` is strict.
void check_accessors(Document& document, Warnings& warnings);

// `pointer` is the place of the reference. Throws ImportFailure if the bufferView has no data, or
// the fault of the accessor.
[[nodiscard]] AccessorView view_accessor(const Document& document, int accessor, std::string_view pointer);

// The formats that one use of an accessor permits.
struct AccessorFormat {
  int components = 1;
  int components_or = 0; // another permitted number; 0: none
  bool is_float = true;
  bool normalized_int = false;      // BYTE, SHORT and their unsigned types, normalized
  bool normalized_unsigned = false; // only the unsigned types
  bool plain_int = false;           // BYTE, SHORT and their unsigned types, not normalized
};
// `semantic` names the use in the error, `code` is the validator's. Throws ImportFailure.
void require_format(const AccessorView& view, const AccessorFormat& format, std::string_view pointer,
                    std::string_view semantic, std::string_view code);

// Reads the elements `gather` (all if empty) into `out`, `width` floats each; components that the
// accessor lacks are set to `fill`. Normalized integers become [0, 1] or [-1, 1] (glTF 2.0, section
// 3.6.2.2). Runs in parallel with TBB.
void read_floats(const AccessorView& view, std::span<const uint32_t> gather, float* out, int width, float fill = 0.0f);

// Returns elements as floats or vectors: V is float, V2f, V3f or V4f.
template <typename V>
[[nodiscard]] std::vector<V> read_vectors(const AccessorView& view, std::span<const uint32_t> gather = {},
                                          float fill = 0.0f) {
  static_assert(sizeof(V) % sizeof(float) == 0);
  std::vector<V> values(gather.empty() ? view.count : gather.size());
  read_floats(view, gather, reinterpret_cast<float*>(values.data()), static_cast<int>(sizeof(V) / sizeof(float)), fill);
  return values;
}

// Reads unsigned integers, 1 (indices) or 4 (joints) per element. The format must have been
// checked.
void read_unsigned(const AccessorView& view, std::span<const uint32_t> gather, uint32_t* out);

[[nodiscard]] bool all_finite(std::span<const float> values);
template <typename V>
[[nodiscard]] std::span<const float> as_floats(const std::vector<V>& values) {
  return {reinterpret_cast<const float*>(values.data()), values.size() * (sizeof(V) / sizeof(float))};
}

// Counts the elements that all parts of a file need, against ImportLimits.
class ElementBudget {
 public:
  explicit ElementBudget(Document& document);
  void charge(uint64_t elements, std::string_view pointer); // throws BudgetFailure
 private:
  Document& document_;
  uint64_t limit_;
};

} // namespace kindling::gltf
