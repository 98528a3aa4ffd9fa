// The tangent of every triangle corner, as MikkTSpace defines it; splitting vertices by them is tangents.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// A triangle list. Arrays are borrowed; positions, normals (unit) and texcoords have one entry per vertex, indices
// three per triangle, each a valid vertex.
struct TangentInput {
  std::span<const V3f> positions;
  std::span<const V3f> normals;
  std::span<const V2f> texcoords;
  std::span<const uint32_t> indices;
};

// One entry per index: xyz the unit tangent, orthogonal to the corner's normal and along increasing u; w the sign for
// bitangent = cross(normal, tangent) * w, which is along decreasing v (glTF's images have v downwards, so this is
// MikkTSpace's sign negated).
//
// Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", section 2 and appendix: corners with equal position,
// normal and texture coordinate are one vertex; around it, triangles joined by edges and of the same uv orientation are
// one group; a group's tangent is the mean of its triangles' tangents, projected to the normal's plane and weighted by
// the corner's angle. Triangles whose uv area vanishes join any group and add nothing; triangles with two equal
// positions take part only by copying the tangent of another corner of the same vertex. As with the reference's default
// threshold of 180 degrees, no group is cut by the angle between tangents. Departure: a corner without any tangent gets
// a unit vector orthogonal to its normal, where the reference gives (1, 0, 0).
[[nodiscard]] std::vector<V4f> corner_tangents(const TangentInput& input);

} // namespace kindling
