// Loads numbers of eight structs into lanes, and makes rays of lanes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/base/lanes.h"
#include "renderer/bsdf/gltf_bsdf.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace kindling {

// Returns four consecutive floats of each object, from the one that is `offset` bytes behind its
// start.
template <typename T>
[[nodiscard]] std::array<Lanes, 4> columns_at(const std::array<T*, Lanes::kCount>& objects, size_t offset) {
  assert(offset % sizeof(float) == 0 && offset + 4 * sizeof(float) <= sizeof(T));
  std::array<const float*, Lanes::kCount> rows;
  for (size_t i = 0; i < Lanes::kCount; ++i)
    rows[i] = reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(objects[i]) + offset);
  return load_columns(rows);
}

[[nodiscard]] inline Imath::Vec3<Lanes> vector_of(const std::array<Lanes, 4>& columns) {
  return {columns[0], columns[1], columns[2]};
}

// Returns the BSDF parameters of each object, by their offset.
template <typename T>
[[nodiscard]] BsdfParametersOf<Lanes> bsdf_parameters_at(const std::array<T*, Lanes::kCount>& objects, size_t offset) {
  const auto base = columns_at(objects, offset + offsetof(BsdfParameters, base_color));
  static_assert(offsetof(BsdfParameters, metallic) == offsetof(BsdfParameters, base_color) + 3 * sizeof(float));
  const auto others = columns_at(objects, offset + offsetof(BsdfParameters, roughness));
  static_assert(offsetof(BsdfParameters, ior) == offsetof(BsdfParameters, roughness) + sizeof(float));
  const auto tint = columns_at(objects, offset + offsetof(BsdfParameters, specular));
  static_assert(offsetof(BsdfParameters, specular_color) == offsetof(BsdfParameters, specular) + sizeof(float));
  return {vector_of(base), base[3], others[0], others[1], tint[0], {tint[1], tint[2], tint[3]}};
}

// Returns the first eight floats of rays that start at t = 0.
[[nodiscard]] inline LaneRows first_halves(const Imath::Vec3<Lanes>& origin, const Imath::Vec3<Lanes>& direction,
                                           const Lanes& length) {
  Lanes columns[Lanes::kCount] = {origin.x, origin.y, origin.z, 0.0f, direction.x, direction.y, direction.z, length};
  LaneRows rows;
  rows.store_columns(columns);
  return rows;
}
// Completes one of them.
[[nodiscard]] inline accel::Ray ray_of(const float* half, uint32_t key, float time, uint32_t index, uint32_t flags) {
  return {.origin = {half[0], half[1], half[2]},
          .t_min = half[3],
          .direction = {half[4], half[5], half[6]},
          .t_max = half[7],
          .key = key,
          .time = time,
          .index = index,
          .flags = flags};
}

} // namespace kindling
