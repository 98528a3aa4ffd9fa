// Search for a plane just off a flat wall, in a node that would be a leaf.
// Rays begin on surfaces: one that leaves a wall along an axis of the tree visits the wall's leaf
// if that reaches farther than the wall. Areas of cells do not tell this, and a greedy search does
// not see that the boxes on both sides of such a plane are smaller than the cells.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/build/split.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace kindling::accel::kd {
namespace {

// The thickest wall, in units of the largest coordinate M: twice the margin of a triangle
// (BuildMeshes::margin_of) with an extent of 2 M is at most 40 u, and corners may be rounded.
constexpr float kThin = 64.0f * 0x1p-24f;

// An end of the occupied space across an axis.
struct End {
  int axis;
  bool low;
  float position;
};

// The flat references at one end.
struct Wall {
  float face = 0.0f;    // position of the plane off the wall
  double covered = 0.0; // summed areas of their boxes; 0: there are none
};

Wall find_wall(std::span<const Reference> references, const End& end, float thin) {
  const int axis = end.axis, j = axis == 2 ? 0 : axis + 1, k = j == 2 ? 0 : j + 1;
  Wall wall{end.position, 0.0};
  for (const Reference& r : references) {
    const float farthest = end.low ? r.max[axis] - end.position : end.position - r.min[axis];
    if (r.max[axis] - r.min[axis] > thin || farthest > thin) continue;
    wall.face = end.low ? std::max(wall.face, r.max[axis]) : std::min(wall.face, r.min[axis]);
    wall.covered += static_cast<double>(r.max[j] - r.min[j]) * static_cast<double>(r.max[k] - r.min[k]);
  }
  return wall;
}

// The references on one side of a plane: their number, and the box of what they have there.
struct Content {
  size_t count = 0;
  Imath::Box3f box;

  void add(const Imath::V3f& min, const Imath::V3f& max) {
    ++count;
    box.min = {std::min(box.min.x, min.x), std::min(box.min.y, min.y), std::min(box.min.z, min.z)};
    box.max = {std::max(box.max.x, max.x), std::max(box.max.y, max.y), std::max(box.max.z, max.z)};
  }
};

// Sides are those of partition_in_place() for references in the plane with the wall.
std::array<Content, 2> divide(std::span<const Reference> references, const End& end, float plane) {
  std::array<Content, 2> sides; // below, above
  for (const Reference& r : references) {
    const bool in_plane = r.min[end.axis] == plane && r.max[end.axis] == plane;
    Imath::V3f below = r.max, above = r.min;
    below[end.axis] = std::min(below[end.axis], plane);
    above[end.axis] = std::max(above[end.axis], plane);
    if (r.min[end.axis] < plane || (in_plane && end.low)) sides[0].add(r.min, below);
    if (r.max[end.axis] > plane || (in_plane && !end.low)) sides[1].add(above, r.max);
  }
  return sides;
}

} // namespace

std::optional<Split> best_split_at_wall(const Config& config, const Imath::Box3f& box, const NodeReferences& node,
                                        double rays) {
  assert(node.run_count() == 1);
  const std::span<const Reference> references = node.run(0);
  if (references.size() < 2) return std::nullopt;
  const CostModel model(config, box);
  const double leaf = model.leaf_cost(references.size());
  if ((leaf - config.wall_step_cost) * model.area() * rays < config.wall_min_gain) return std::nullopt;
  const Imath::Box3f all = node.space().box();
  const double area = half_area(all);
  if (!(area > 0.0)) return std::nullopt;
  float largest = 0.0f;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::fabs(all.min[axis]), std::fabs(all.max[axis])});

  std::optional<Split> best;
  for (int i = 0; i < 6; ++i) {
    const int axis = i / 2;
    const bool low = i % 2 == 0;
    const End end{axis, low, low ? all.min[axis] : all.max[axis]};
    const Wall wall = find_wall(references, end, largest * kThin);
    if (wall.covered == 0.0 || !(wall.face > box.min[axis] && wall.face < box.max[axis])) continue;
    const std::array<Content, 2> sides = divide(references, end, wall.face);
    const Content &slab = sides[low ? 0 : 1], &rest = sides[low ? 1 : 0];
    if (rest.count == 0 || rest.count == references.size()) continue;
    const double face = half_area(slab.box), covered = std::min(1.0, wall.covered / face);
    const double seen = face * (1.0 - covered * (1.0 - config.wall_visits));
    const double cost = config.wall_step_cost +
                        (seen * model.leaf_cost(slab.count) + half_area(rest.box) * model.leaf_cost(rest.count)) / area;
    if ((leaf - cost) * area * rays < config.wall_min_gain || (best && best->cost <= cost)) continue;
    best = Split{cost, wall.face, axis, low};
  }
  return best;
}

} // namespace kindling::accel::kd
