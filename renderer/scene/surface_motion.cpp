// Poses the nodes at both times, and deforms meshes at the other one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/surface_motion.h"

#include "renderer/scene/animated_nodes.h"
#include "renderer/scene/deform.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling {
namespace {

V3f transformed(const M44d& m, const V3f& point) {
  const V3d p(point);
  return V3f(V3d(p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
                 p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
                 p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]));
}

// Returns nothing for a node without an extent, of which nothing is seen.
std::optional<M44d> from_to(const M44f& now, const M44f& then) {
  const M44d start(now);
  const double determinant = start.determinant();
  if (determinant == 0.0 || !std::isfinite(determinant)) return std::nullopt;
  return start.inverse() * M44d(then);
}

bool may_deform(const Scene& scene, const Node& node, const AnimatedNodes& nodes) {
  if (node.mesh == kNone) return false;
  if (node.skin != kNone) {
    const std::vector<int>& joints = scene.skins[static_cast<size_t>(node.skin)].joints;
    if (std::any_of(joints.begin(), joints.end(), [&](int joint) { return nodes.moves(joint); })) return true;
  }
  const std::vector<Primitive>& primitives = scene.meshes[static_cast<size_t>(node.mesh)].primitives;
  return std::any_of(primitives.begin(), primitives.end(),
                     [](const Primitive& primitive) { return !primitive.targets.empty(); });
}

} // namespace

SurfaceMotion::SurfaceMotion(const Scene& scene, double now_s, double then_s) {
  AnimatedNodes nodes(scene, now_s);
  std::vector<M44f> now;
  for (size_t i = 0; i < scene.nodes.size(); ++i) now.push_back(nodes.to_world(static_cast<int>(i)));
  nodes.set_time(then_s);
  from_now_.resize(scene.nodes.size());
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    const M44f& then = nodes.to_world(static_cast<int>(i));
    // A skinned mesh follows its joints alone.
    if (then != now[i] && node.skin == kNone) from_now_[i] = from_to(now[i], then);
    if (!may_deform(scene, node, nodes)) continue;
    const auto joints =
        node.skin == kNone ? std::vector<M44f>() : nodes.joint_matrices(scene.skins[static_cast<size_t>(node.skin)]);
    Deformed& deformed = deformed_[static_cast<int>(i)];
    deformed.in_world = node.skin != kNone;
    for (const Primitive& primitive : scene.meshes[static_cast<size_t>(node.mesh)].primitives)
      if (!primitive.indices.empty())
        deformed.vertices.push_back(
            deform_primitive(primitive, nodes.morph_weights(static_cast<int>(i)), joints, then).positions);
  }
}

V3f SurfaceMotion::move(const Place& place, const V3f& now) const {
  const auto node = static_cast<size_t>(place.node);
  if (node >= from_now_.size()) return now;
  const std::optional<M44d>& from_now = from_now_[node];
  const auto deforms = deformed_.find(place.node);
  if (deforms == deformed_.end()) return from_now ? transformed(*from_now, now) : now;
  const Deformed& deformed = deforms->second;
  assert(!deformed.vertices.empty()); // a surface of it was hit
  const std::vector<V3f>& vertices = deformed.vertices[place.primitive % deformed.vertices.size()];
  V3f point(0.0f);
  for (size_t c = 0; c < 3; ++c) point += vertices[place.vertices[c]] * place.barycentric[static_cast<int>(c)];
  if (deformed.in_world) return point;
  point = transform_point(place.local_to_world, point);
  return from_now ? transformed(*from_now, point) : point;
}

} // namespace kindling
