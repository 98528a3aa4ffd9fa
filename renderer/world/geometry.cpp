// Packs vertex attributes into records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/geometry.h"

#include "renderer/base/uninitialized_vector.h"
#include "renderer/scene/material_slots.h"
#include "renderer/scene/tangents.h"

#include <tbb/parallel_for.h>

#include <utility>
#include <vector>

namespace kindling {
namespace {

constexpr size_t kPadding = 2; // positions that the accelerator's quadword loads may read
constexpr size_t kRecordGrain = 1U << 14;

// Returns the texture coordinate sets that the material reads, as a bit mask. Set 0 is always
// included for the uv debug view.
uint32_t used_texcoord_sets(const Material& material) {
  uint32_t used = 1;
  for (const TextureSlot* slot : texture_slots(material)) used |= slot->texcoord_sets();
  return used;
}

V3f normalized_or(const V3f& v, const V3f& fallback) {
  const float length = v.length();
  return length > 0.0f && std::isfinite(length) ? v / length : fallback;
}

// Swaps the last two corners of each triangle.
void reverse_winding(std::vector<uint32_t>& indices) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, indices.size() / 3, kRecordGrain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t t = range.begin(); t != range.end(); ++t)
                        std::swap(indices[3 * t + 1], indices[3 * t + 2]);
                    });
}

// Returns the normals and tangents that the records of `layout` have.
UninitializedVector<float> frames_of(const PosedMesh::Deformed& key, const GeometryView& layout) {
  const size_t floats = layout.frame_floats(), count = layout.positions.size();
  UninitializedVector<float> frames(count * floats);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kRecordGrain), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t v = range.begin(); v != range.end(); ++v) {
      float* frame = frames.data() + v * floats;
      if (layout.normal_offset != GeometryView::kAbsent)
        for (int c = 0; c < 3; ++c) *frame++ = key.normals[v][c];
      if (layout.tangent_offset != GeometryView::kAbsent)
        for (int c = 0; c < 3; ++c) *frame++ = key.tangents[v][c];
    }
  });
  return frames;
}

void add_keys(Geometry& geometry, std::vector<PosedMesh::Deformed> keys) {
  const size_t before = geometry.arrays.bytes(), count = geometry.positions.size();
  std::vector<std::span<const V3f>> positions;
  std::vector<std::span<const float>> frames;
  for (PosedMesh::Deformed& key : keys) {
    frames.push_back(geometry.arrays.keep(frames_of(key, geometry)));
    key.positions.resize(count + kPadding, V3f(0.0f));
    positions.push_back(geometry.arrays.keep(std::move(key.positions)).first(count));
  }
  geometry.later_positions = geometry.arrays.keep(std::move(positions));
  geometry.later_frames = geometry.arrays.keep(std::move(frames));
  geometry.key_bytes = geometry.arrays.bytes() - before;
}

} // namespace

Geometry make_geometry(GeometrySource&& source, const Material& material) {
  Primitive& primitive = source.primitive;
  Geometry geometry;
  geometry.material = source.material;
  geometry.stroke = primitive.stroke;
  const size_t count = primitive.positions.size();
  // Imath's constructor leaves elements uninitialized, so the writing thread touches each page
  // first. The size is exact.
  std::vector<V3f> positions(count + kPadding);
  std::fill_n(positions.begin() + static_cast<std::ptrdiff_t>(count), kPadding, V3f(0.0f));

  const M44f& bake = source.bake;
  const bool identity = bake == M44f();
  // If the transform flattens the mesh, only face normals remain.
  if (bake.determinant() == 0.0f) primitive.normals.clear();
  const M44f inverse = identity ? M44f() : bake.inverse();
  geometry.to_object = inverse;
  const bool mirrored = bake.determinant() < 0.0f;

  uint8_t stride = 0;
  const auto place = [&](uint8_t& offset, bool present, uint8_t floats) {
    if (!present) return;
    offset = stride;
    stride = static_cast<uint8_t>(stride + floats);
  };
  const uint32_t used_sets = used_texcoord_sets(material);
  place(geometry.normal_offset, !primitive.normals.empty(), 3);
  for (size_t set = 0; set < primitive.texcoords.size() && set < geometry.texcoord_offset.size(); ++set)
    place(geometry.texcoord_offset[set], !primitive.texcoords[set].empty() && ((used_sets >> set) & 1U) != 0, 2);
  place(geometry.tangent_offset, !primitive.tangents.empty() && tangent_texcoord_set(material).has_value(), 4);
  place(geometry.color_offset, !primitive.colors.empty(), 4);
  geometry.stride = stride;
  UninitializedVector<float> attributes(count * stride);

  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kRecordGrain), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t v = range.begin(); v != range.end(); ++v) {
      float* record = attributes.data() + v * stride;
      if (geometry.normal_offset != Geometry::kAbsent) {
        V3f n = primitive.normals[v];
        if (!identity) n = normalized_or(transform_normal(inverse, n), n);
        record[geometry.normal_offset + 0] = n.x;
        record[geometry.normal_offset + 1] = n.y;
        record[geometry.normal_offset + 2] = n.z;
      }
      for (size_t set = 0; set < geometry.texcoord_offset.size(); ++set) {
        const uint8_t offset = geometry.texcoord_offset[set];
        if (offset == Geometry::kAbsent) continue;
        record[offset + 0] = primitive.texcoords[set][v].x;
        record[offset + 1] = primitive.texcoords[set][v].y;
      }
      if (geometry.tangent_offset != Geometry::kAbsent) {
        const V4f t = primitive.tangents[v];
        const V3f axis(t.x, t.y, t.z);
        const V3f baked = identity ? axis : normalized_or(transform_vector(bake, axis), axis);
        record[geometry.tangent_offset + 0] = baked.x;
        record[geometry.tangent_offset + 1] = baked.y;
        record[geometry.tangent_offset + 2] = baked.z;
        record[geometry.tangent_offset + 3] = mirrored ? -t.w : t.w;
      }
      if (geometry.color_offset != Geometry::kAbsent)
        for (int c = 0; c < 4; ++c) record[geometry.color_offset + c] = primitive.colors[v][c];
      const V3f& p = primitive.positions[v];
      positions[v] = identity ? p : transform_point(bake, p);
    }
  });

  // A mirroring transform makes front faces clockwise (glTF 2.0, section 3.7.4): restores the
  // winding.
  if (mirrored != source.clockwise) reverse_winding(primitive.indices);
  geometry.indices = geometry.arrays.keep(std::move(primitive.indices));
  geometry.positions = geometry.arrays.keep(std::move(positions)).first(count);
  geometry.attributes = geometry.arrays.keep(std::move(attributes));
  if (!source.later_keys.empty()) add_keys(geometry, std::move(source.later_keys));
  return geometry;
}

} // namespace kindling
