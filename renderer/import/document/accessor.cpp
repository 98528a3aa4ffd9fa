// Bounds and formats of accessors, and conversion of their bytes to numbers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/document/accessor.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace kindling::gltf {
namespace {

constexpr size_t kElementGrain = 1U << 14;

int component_count(int type) {
  switch (type) {
  case TINYGLTF_TYPE_SCALAR: return 1;
  case TINYGLTF_TYPE_VEC2: return 2;
  case TINYGLTF_TYPE_VEC3: return 3;
  case TINYGLTF_TYPE_VEC4:
  case TINYGLTF_TYPE_MAT2: return 4;
  case TINYGLTF_TYPE_MAT3: return 9;
  default: return 16;
  }
}

// Matrix columns start at multiples of four bytes (glTF 2.0, section 3.6.2.4).
size_t element_bytes(int type, int component_type) {
  const size_t component = component_bytes(component_type);
  if (type == TINYGLTF_TYPE_MAT2 && component == 1) return 6;
  if (type == TINYGLTF_TYPE_MAT3 && component <= 2) return component == 1 ? 11 : 22;
  return component * static_cast<size_t>(component_count(type));
}

uint32_t load_index(const std::byte* from, int component_type) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return std::to_integer<uint32_t>(*from);
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
    uint16_t value;
    std::memcpy(&value, from, sizeof(value));
    return value;
  }
  uint32_t value;
  std::memcpy(&value, from, sizeof(value));
  return value;
}

// Checks that `count` elements of `size` bytes, `stride` apart from `offset` on, lie within a
// bufferView.
void check_fit(const Document& document, int view_index, uint64_t offset, uint64_t stride, uint64_t size,
               uint64_t count, std::string_view pointer) {
  const ViewBytes& view = document.views[static_cast<size_t>(view_index)];
  const uint64_t length = view.length;
  if (count == 0) return;                  // nothing is read
  if (count > length || offset > length) { // also prevents overflow of the sum below
    fail(pointer,
         fmt::format("{} elements at byte {} do not fit the {} bytes of bufferView {}", count, offset, length,
                     view_index),
         "ACCESSOR_TOO_LONG");
  }
  const uint64_t end = offset + (count - 1) * stride + size;
  if (end > length) {
    fail(pointer, fmt::format("reads {} bytes past bufferView {} (length {})", end - length, view_index, length),
         "ACCESSOR_TOO_LONG");
  }
}

void check_sparse(const Document& document, const tinygltf::Accessor& accessor, size_t size,
                  const std::string& pointer) {
  const auto& sparse = accessor.sparse;
  const auto count = static_cast<uint64_t>(sparse.count);
  if (count > accessor.count) {
    fail(pointer + "/sparse/count", fmt::format("{}, the accessor has only {} elements", count, accessor.count),
         "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE");
  }
  const size_t index_bytes = component_bytes(sparse.indices.componentType);
  check_fit(document, sparse.indices.bufferView, static_cast<uint64_t>(sparse.indices.byteOffset), index_bytes,
            index_bytes, count, pointer + "/sparse/indices");
  check_fit(document, sparse.values.bufferView, static_cast<uint64_t>(sparse.values.byteOffset), size, size, count,
            pointer + "/sparse/values");
  if (count == 0 || !document.views[static_cast<size_t>(sparse.indices.bufferView)].has_data())
    return; // an error at its first use
  const std::byte* indices =
      document.views[static_cast<size_t>(sparse.indices.bufferView)].bytes.data() + sparse.indices.byteOffset;
  uint64_t lowest = 0;
  for (uint64_t i = 0; i < count; ++i) {
    const uint32_t index = load_index(indices + i * index_bytes, sparse.indices.componentType);
    if (index < lowest) {
      fail(pointer + "/sparse/indices", fmt::format("index {} at {} is not above the one before", index, i),
           "ACCESSOR_SPARSE_INDICES_NON_INCREASING");
    }
    if (index >= accessor.count) {
      fail(pointer + "/sparse/indices",
           fmt::format("index {} at {}, the accessor has {} elements", index, i, accessor.count),
           "ACCESSOR_SPARSE_INDEX_OOB");
    }
    lowest = static_cast<uint64_t>(index) + 1;
  }
}

void check_bounds(const Document& document, const tinygltf::Accessor& accessor, const std::string& pointer) {
  const size_t size = element_bytes(accessor.type, accessor.componentType);
  if (accessor.bufferView >= 0) {
    const size_t given = document.views[static_cast<size_t>(accessor.bufferView)].stride;
    if (given != 0 && given < size) {
      fail(pointer,
           fmt::format("elements of {} bytes in bufferView {} with a byteStride of {}", size, accessor.bufferView,
                       given),
           "ACCESSOR_SMALL_BYTESTRIDE");
    }
    check_fit(document, accessor.bufferView, accessor.byteOffset, given != 0 ? given : size, size, accessor.count,
              pointer);
  }
  if (accessor.sparse.isSparse) check_sparse(document, accessor, size, pointer);
  if (accessor.count > std::numeric_limits<uint32_t>::max() - 1) {
    fail(pointer + "/count", fmt::format("{}, at most 2^32 - 2 are accepted", accessor.count));
  }
}

// Calls f(T()) for the component's C++ type.
template <typename F>
void with_component_type(int component_type, F&& f) {
  switch (component_type) {
  case TINYGLTF_COMPONENT_TYPE_BYTE: f(int8_t()); break;
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: f(uint8_t()); break;
  case TINYGLTF_COMPONENT_TYPE_SHORT: f(int16_t()); break;
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: f(uint16_t()); break;
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: f(uint32_t()); break;
  default: f(float()); break;
  }
}

template <typename T>
float to_float(T value, bool normalized) {
  const auto real = static_cast<float>(value);
  if constexpr (std::is_integral_v<T>) {
    if (normalized) {
      return std::max(static_cast<float>(static_cast<double>(value) / std::numeric_limits<T>::max()), -1.0f);
    }
  }
  return real;
}

template <typename T>
void read_element(const std::byte* from, int components, bool normalized, float* out) {
  for (int c = 0; c < components; ++c) {
    T value;
    std::memcpy(&value, from + sizeof(T) * static_cast<size_t>(c), sizeof(T));
    out[c] = to_float(value, normalized);
  }
}

} // namespace

size_t component_bytes(int component_type) {
  switch (component_type) {
  case TINYGLTF_COMPONENT_TYPE_BYTE:
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
  case TINYGLTF_COMPONENT_TYPE_SHORT:
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
  default: return 4;
  }
}

void check_accessors(Document& document, Warnings& warnings) {
  for (size_t i = 0; i < document.core.accessors.size(); ++i) {
    tinygltf::Accessor& accessor = document.core.accessors[i];
    const std::string pointer = fmt::format("/accessors/{}", i);
    if (accessor.normalized && component_bytes(accessor.componentType) == 4) {
      warnings.repair("normalized", pointer + "/normalized",
                      "true for 32-bit components, expected 8-bit or 16-bit components", "ACCESSOR_NORMALIZED_INVALID",
                      "it is ignored");
      accessor.normalized = false;
    }
    try {
      check_bounds(document, accessor, pointer);
    } catch (const ImportFailure& fault) {
      warnings.repair("accessor", fault, "the accessor is not read");
      document.faulty_accessors.emplace(static_cast<int>(i), fault);
    }
  }
}

AccessorView view_accessor(const Document& document, int index, std::string_view pointer) {
  const auto fault = document.faulty_accessors.find(index);
  if (fault != document.faulty_accessors.end()) throw fault->second;
  const tinygltf::Accessor& accessor = document.core.accessors[static_cast<size_t>(index)];
  const auto require_data = [&](int buffer_view) {
    if (document.views[static_cast<size_t>(buffer_view)].has_data()) return;
    fail(pointer, fmt::format("accessor {} reads bufferView {}, whose buffer has no data", index, buffer_view),
         "BUFFER_MISSING_GLB_DATA");
  };
  AccessorView view;
  const size_t size = element_bytes(accessor.type, accessor.componentType);
  view.count = accessor.count;
  view.component_type = accessor.componentType;
  view.components = component_count(accessor.type);
  view.normalized = accessor.normalized;
  view.stride = size;
  if (view.count == 0) return view; // reads nothing
  if (accessor.bufferView >= 0) {
    require_data(accessor.bufferView);
    const ViewBytes& bytes = document.views[static_cast<size_t>(accessor.bufferView)];
    view.data = bytes.bytes.data() + accessor.byteOffset;
    if (bytes.stride != 0) view.stride = bytes.stride;
  }
  if (accessor.sparse.isSparse) {
    const auto& sparse = accessor.sparse;
    require_data(sparse.indices.bufferView);
    require_data(sparse.values.bufferView);
    if (sparse.count == 0) return view;
    view.sparse_count = static_cast<size_t>(sparse.count);
    view.sparse_index_type = sparse.indices.componentType;
    view.sparse_indices =
        document.views[static_cast<size_t>(sparse.indices.bufferView)].bytes.data() + sparse.indices.byteOffset;
    view.sparse_values =
        document.views[static_cast<size_t>(sparse.values.bufferView)].bytes.data() + sparse.values.byteOffset;
  }
  return view;
}

void require_format(const AccessorView& view, const AccessorFormat& format, std::string_view pointer,
                    std::string_view semantic, std::string_view code) {
  const bool integer = component_bytes(view.component_type) <= 2;
  const bool is_unsigned = view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           view.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  const bool fits_type =
      (format.is_float && view.component_type == TINYGLTF_COMPONENT_TYPE_FLOAT) ||
      (integer && view.normalized && (format.normalized_int || (format.normalized_unsigned && is_unsigned))) ||
      (integer && !view.normalized && format.plain_int);
  const bool fits_count =
      view.components == format.components || (format.components_or != 0 && view.components == format.components_or);
  if (fits_type && fits_count) return;
  const auto name = [](int components) {
    return components == 1    ? "SCALAR"
           : components == 2  ? "VEC2"
           : components == 3  ? "VEC3"
           : components == 4  ? "VEC4"
           : components == 16 ? "MAT4"
                              : "MAT3";
  };
  std::string types;
  if (format.is_float) types += "FLOAT";
  if (format.normalized_int) types += types.empty() ? "normalized BYTE or SHORT" : ", normalized BYTE or SHORT";
  if (format.normalized_unsigned) types += ", normalized UNSIGNED_BYTE or UNSIGNED_SHORT";
  if (format.plain_int) types += ", BYTE or SHORT";
  const char* found = "UNSIGNED_INT";
  switch (view.component_type) {
  case TINYGLTF_COMPONENT_TYPE_BYTE: found = "BYTE"; break;
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: found = "UNSIGNED_BYTE"; break;
  case TINYGLTF_COMPONENT_TYPE_SHORT: found = "SHORT"; break;
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: found = "UNSIGNED_SHORT"; break;
  case TINYGLTF_COMPONENT_TYPE_FLOAT: found = "FLOAT"; break;
  default: break;
  }
  fail(pointer,
       fmt::format("{} of {}{}, {} must be {}{}{} of {}", name(view.components), view.normalized ? "normalized " : "",
                   found, semantic, name(format.components), format.components_or != 0 ? " or " : "",
                   format.components_or != 0 ? name(format.components_or) : "", types),
       code);
}

void read_floats(const AccessorView& view, std::span<const uint32_t> gather, float* out, int width, float fill) {
  if (view.sparse_count > 0 && !gather.empty()) {
    std::vector<float> dense(view.count * static_cast<size_t>(width));
    read_floats(view, {}, dense.data(), width, fill);
    for (size_t i = 0; i < gather.size(); ++i) {
      std::copy_n(dense.data() + static_cast<size_t>(gather[i]) * static_cast<size_t>(width), width,
                  out + i * static_cast<size_t>(width));
    }
    return;
  }
  const size_t count = gather.empty() ? view.count : gather.size();
  const int components = std::min(view.components, width);
  const auto stride = static_cast<size_t>(width);
  with_component_type(view.component_type, [&](auto zero) {
    using T = decltype(zero);
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, count, kElementGrain), [&](const tbb::blocked_range<size_t>& range) {
          if (view.data == nullptr) {
            for (size_t i = range.begin(); i < range.end(); ++i) std::fill_n(out + i * stride, components, 0.0f);
          } else if (std::is_same_v<T, float> && gather.empty() && components == width &&
                     view.stride == sizeof(float) * stride) {
            std::memcpy(out + range.begin() * stride, view.data + range.begin() * view.stride,
                        range.size() * view.stride);
          } else {
            for (size_t i = range.begin(); i < range.end(); ++i) {
              const size_t element = gather.empty() ? i : gather[i];
              read_element<T>(view.data + element * view.stride, components, view.normalized, out + i * stride);
            }
          }
          if (components < width) {
            for (size_t i = range.begin(); i < range.end(); ++i)
              std::fill(out + i * stride + components, out + (i + 1) * stride, fill);
          }
        });
    const size_t packed = sizeof(T) * static_cast<size_t>(view.components);
    for (size_t i = 0; i < view.sparse_count; ++i) {
      const size_t element =
          load_index(view.sparse_indices + i * component_bytes(view.sparse_index_type), view.sparse_index_type);
      read_element<T>(view.sparse_values + i * packed, components, view.normalized, out + element * stride);
    }
  });
}

void read_unsigned(const AccessorView& view, std::span<const uint32_t> gather, uint32_t* out) {
  const size_t count = gather.empty() ? view.count : gather.size();
  const auto width = static_cast<size_t>(view.components);
  const size_t bytes = component_bytes(view.component_type);
  const auto read = [&](const std::byte* from, uint32_t* to) {
    for (size_t c = 0; c < width; ++c) to[c] = load_index(from + c * bytes, view.component_type);
  };
  if (view.sparse_count > 0 && !gather.empty()) {
    std::vector<uint32_t> dense(view.count * width);
    read_unsigned(view, {}, dense.data());
    for (size_t i = 0; i < count; ++i) std::copy_n(dense.data() + gather[i] * width, width, out + i * width);
    return;
  }
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kElementGrain), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i < range.end(); ++i) {
      if (view.data == nullptr) {
        std::fill_n(out + i * width, width, 0U);
      } else {
        read(view.data + (gather.empty() ? i : gather[i]) * view.stride, out + i * width);
      }
    }
  });
  for (size_t i = 0; i < view.sparse_count; ++i) {
    const size_t element =
        load_index(view.sparse_indices + i * component_bytes(view.sparse_index_type), view.sparse_index_type);
    read(view.sparse_values + i * bytes * width, out + element * width);
  }
}

bool all_finite(std::span<const float> values) {
  std::atomic<bool> finite{true};
  tbb::parallel_for(tbb::blocked_range<size_t>(0, values.size(), kElementGrain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      bool fine = true;
                      for (size_t i = range.begin(); i < range.end(); ++i) fine &= std::isfinite(values[i]);
                      if (!fine) finite.store(false, std::memory_order_relaxed);
                    });
  return finite.load();
}

ElementBudget::ElementBudget(Document& document)
    : document_(document), limit_(std::min(document.limits.max_total_elements,
                                           std::max(document.limits.max_elements_of_small_file,
                                                    document.bytes_read * document.limits.elements_per_byte))) {}

void ElementBudget::charge(uint64_t elements, std::string_view pointer) {
  if (elements > limit_ - std::min(limit_, document_.elements_used)) {
    throw BudgetFailure{
        {{ErrorKind::scene_invalid,
          place_message(pointer,
                        fmt::format("{} elements more than the {} already read, at most {} are accepted for a file of "
                                    "this size",
                                    elements, document_.elements_used, limit_),
                        "")}}};
  }
  document_.elements_used += elements;
}

} // namespace kindling::gltf
