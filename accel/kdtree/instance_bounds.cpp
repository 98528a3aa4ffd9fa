// World bounds of instances, from vertices or the uppermost boxes of a tree; transform errors.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/instance_bounds.h"

#include "accel/affine.h"
#include "accel/motion.h"
#include "accel/triangle.h"

#include <algorithm>
#include <cmath>

namespace kindling::accel::kd {
namespace {

struct TreePart {
  Imath::Box3f box;
  ChildWord child;
};

std::vector<TreePart> children_of(const BoxNode& node) {
  std::vector<TreePart> children;
  for (size_t lane = 0; lane < kWideLanes; ++lane) {
    if (std::isnan(node.low[0][lane])) continue;
    children.push_back({{{node.low[0][lane], node.low[1][lane], node.low[2][lane]},
                         {node.high[0][lane], node.high[1][lane], node.high[2][lane]}},
                        node.child[lane]});
  }
  return children;
}

// Returns boxes around the vertices that triangles of a tree use, larger than the margins of
// triangles; nothing if there are more than `limit`.
std::vector<Imath::Box3f> vertices_of(const Tree& tree, size_t limit) {
  std::vector<Imath::Box3f> boxes;
  float extent = 0.0f, largest = 0.0f;
  for (int k = 0; k < 3; ++k) {
    extent = std::max(extent, tree.bounds.max[k] - tree.bounds.min[k]);
    largest = std::max({largest, std::fabs(tree.bounds.min[k]), std::fabs(tree.bounds.max[k])});
  }
  const Imath::V3f margin(4.0f * (kExtentTolerance * extent + 0x1p-22f * largest));
  for (const Geometry& geometry : tree.geometries.all()) {
    const TriangleMesh& mesh = geometry.mesh;
    if (mesh.indices.size() > 6 * limit) return {}; // a vertex of a closed mesh has six triangles
    std::vector<uint32_t> used(mesh.indices.begin(), mesh.indices.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const uint32_t i : used) {
      const Imath::V3f& p = mesh.positions[i];
      if (tree.bounds.intersects(p)) boxes.push_back({p - margin, p + margin}); // others are of no triangle that is hit
    }
    if (boxes.size() > limit) return {};
  }
  return boxes;
}

} // namespace

std::vector<Imath::Box3f> parts_of(const Tree& tree, size_t limit) {
  std::vector<Imath::Box3f> boxes = vertices_of(tree, limit);
  if (!boxes.empty()) return boxes;
  std::vector<TreePart> parts = {{tree.bounds, tree.root}};
  for (size_t next = 0; next < parts.size(); ++next) {
    const auto [box, child] = parts[next];
    if (child == kEmptyChild || (child & kLeafBit) != 0 ||
        boxes.size() + parts.size() - next - 1 + kWideLanes > limit) {
      boxes.push_back(box);
      continue;
    }
    const std::vector<TreePart> children = children_of(tree.nodes[child]);
    parts.insert(parts.end(), children.begin(), children.end());
  }
  return boxes;
}

size_t parts_for(size_t instances) {
  constexpr size_t kBoxes = size_t{1} << 23; // a fraction of a second
  return std::clamp<size_t>(kBoxes / std::max<size_t>(1, instances), 1, 512);
}

Imath::Box3f transform_bounds(std::span<const Imath::M44f> keys, const std::vector<Imath::Box3f>& boxes) {
  Imath::Box3f out;
  for (const Imath::Box3f& box : boxes) out.extendBy(accel::transform_bounds(keys, box));
  return out;
}

float growth_of(std::span<const Imath::M44f> keys) {
  float growth = 1.0f;
  const auto add = [&](const Imath::M44f& m) {
    RayToObject inverse;
    growth = std::max(growth, inverse.set_inverse_of(m) ? 2.0f * rounding_growth(m, inverse) : 1e6f);
  };
  for (size_t k = 0; k < keys.size(); ++k) {
    add(keys[k]);
    if (k + 1 < keys.size()) add(between(keys[k], keys[k + 1], 0.5f));
  }
  return growth;
}

} // namespace kindling::accel::kd
