// Tangents of triangle corners, as MikkTSpace defines them; tangents.h splits vertices by them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// A triangle list of borrowed arrays. Positions, normals (unit) and texcoords have one entry per
// vertex; indices has three valid vertices per triangle.
struct TangentInput {
  std::span<const V3f> positions;
  std::span<const V3f> normals;
  std::span<const V2f> texcoords;
  std::span<const uint32_t> indices;
};

// Returns one tangent per index. xyz is unit, orthogonal to the corner's normal, and along
// increasing u; w is the sign for bitangent = cross(normal, tangent) * w, which points along
// decreasing v. glTF's images have v downwards, so w is MikkTSpace's sign negated.
//
// Follows Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", section 2 and appendix.
// Corners with equal position, normal and texture coordinate are one vertex. Around it, triangles
// that are joined by edges and have the same uv orientation form a group. The group's tangent is
// the mean of its triangles' tangents, projected to the normal's plane and weighted by the corner's
// angle. Triangles without uv area join any group and add nothing; triangles with two equal
// positions copy the tangent of another corner of the same vertex. As with the reference's default
// threshold of 180 degrees, the angle between tangents never splits a group. Departure: a corner
// without any tangent gets a unit vector orthogonal to its normal, where the reference gives (1, 0,
// 0).
[[nodiscard]] std::vector<V4f> corner_tangents(const TangentInput& input);

} // namespace kindling
