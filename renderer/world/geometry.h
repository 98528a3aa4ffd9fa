// Vertices of one accelerator mesh in the layout that shading reads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/math.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"

#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Positions are separate, for the accelerator. The other attributes of a vertex are adjacent in one
// record of floats, so that a hit touches one or two cache lines per vertex. Offsets are in floats
// from the start of a record.
struct GeometryView {
  static constexpr uint8_t kAbsent = 0xff;
  static constexpr int kMaxTexcoordSets = 8;

  std::span<const V3f> positions; // followed by padding that the accelerator may read
  std::span<const uint32_t> indices;
  std::span<const float> attributes;
  uint8_t stride = 0;
  uint8_t normal_offset = kAbsent;                       // 3 floats
  uint8_t tangent_offset = kAbsent;                      // 4 floats
  uint8_t color_offset = kAbsent;                        // 4 floats
  std::array<uint8_t, kMaxTexcoordSets> texcoord_offset; // 2 floats each
  uint32_t material = 0;
  Stroke stroke = Stroke::none;
  // Keys of a mesh that deforms over the shutter, after the first (accel/accelerator.h); empty: it
  // does not deform. Positions are padded likewise. Frames are the normals and tangents that the
  // records have: 3 floats each for every vertex.
  std::span<const std::span<const V3f>> later_positions;
  std::span<const std::span<const float>> later_frames;
  M44f to_object; // from the space of positions to that of the file's mesh; inverts baking

  GeometryView() { texcoord_offset.fill(kAbsent); }

  [[nodiscard]] size_t frame_floats() const {
    return (normal_offset == kAbsent ? 0U : 3U) + (tangent_offset == kAbsent ? 0U : 3U);
  }
  [[nodiscard]] const float* record(uint32_t vertex) const {
    assert(vertex < positions.size());
    return attributes.data() + size_t{vertex} * stride;
  }

  // Interpolate attributes; the offset must be present.
  [[nodiscard]] V2f interpolate2(const std::array<const float*, 3>& records, uint8_t offset,
                                 const V3f& barycentric) const {
    const float *a = records[0] + offset, *b = records[1] + offset, *c = records[2] + offset;
    return {a[0] * barycentric.x + b[0] * barycentric.y + c[0] * barycentric.z,
            a[1] * barycentric.x + b[1] * barycentric.y + c[1] * barycentric.z};
  }
  [[nodiscard]] V3f interpolate3(const std::array<const float*, 3>& records, uint8_t offset,
                                 const V3f& barycentric) const {
    const float *a = records[0] + offset, *b = records[1] + offset, *c = records[2] + offset;
    return {a[0] * barycentric.x + b[0] * barycentric.y + c[0] * barycentric.z,
            a[1] * barycentric.x + b[1] * barycentric.y + c[1] * barycentric.z,
            a[2] * barycentric.x + b[2] * barycentric.y + c[2] * barycentric.z};
  }
  [[nodiscard]] V4f interpolate4(const std::array<const float*, 3>& records, uint8_t offset,
                                 const V3f& barycentric) const {
    const V3f xyz = interpolate3(records, offset, barycentric);
    return {xyz.x, xyz.y, xyz.z,
            records[0][offset + 3] * barycentric.x + records[1][offset + 3] * barycentric.y +
                records[2][offset + 3] * barycentric.z};
  }
};

struct Geometry : GeometryView {
  uint64_t number = 0; // unique within one WorldParts and constant as long as the geometry is reused; 0: it deforms
  OwnedArrays arrays;
  size_t key_bytes = 0; // of the memory of the keys alone

  [[nodiscard]] size_t memory_bytes() const { return arrays.bytes(); }
};

// An accelerator's instance with the data of shading. The instance of all baked geometry is an
// identity. Moving ones are stored at the opening of the shutter; `motion` is an index into World's
// motions, absent if only meshes deform.
struct WorldInstance : accel::Instance {
  uint32_t first_mesh = 0;     // first accelerator mesh of its group
  uint32_t emissive_begin = 0; // into World's table of first emissive triangles, one entry per mesh of the group
  bool identity = true;        // never for moving instances
  bool moving = false;         // it moves or its meshes deform: use move_hit()
  bool mirrored = false;       // negative determinant: front faces are clockwise in world space
  bool emissive = false;       // false: no entries in the table
};

// Makes a Geometry of a primitive and (if deformed) its posed vertices, with the attributes that
// `material` and the debug views need. `bake` is applied to positions, normals and tangents:
// identity for instanced geometry. Consumes the primitive's arrays. Parallel with TBB; independent
// of the number of threads.
struct GeometrySource {
  Primitive primitive;
  M44f bake;
  uint32_t material = 0;
  bool clockwise = false; // reverses the winding of all triangles
  // Keys after the first, in the space of the primitive; then `bake` is an identity.
  std::vector<PosedMesh::Deformed> later_keys;
};
[[nodiscard]] Geometry make_geometry(GeometrySource&& source, const Material& material);

} // namespace kindling
