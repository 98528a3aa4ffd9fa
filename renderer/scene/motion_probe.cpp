// Finds objects that may move and picks representative points.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/motion_probe.h"

#include "renderer/base/frame.h"
#include "renderer/scene/deform.h"

#include <algorithm>
#include <map>

namespace kindling {
namespace {

constexpr size_t kSpreadVertices = 1024; // per mesh, besides the extremes below

// Returns vertices spread over the primitive, the one that each target moves farthest, and the one
// with the largest weight of each joint.
std::vector<size_t> choose_vertices(const Primitive& primitive, size_t spread) {
  const size_t count = primitive.positions.size();
  std::vector<size_t> chosen;
  const size_t step = std::max<size_t>(1, count / std::max<size_t>(1, spread));
  for (size_t v = 0; v < count; v += step) chosen.push_back(v);
  for (const MorphTarget& target : primitive.targets) {
    const auto farthest = std::max_element(target.positions.begin(), target.positions.end(),
                                           [](const V3f& a, const V3f& b) { return a.length2() < b.length2(); });
    if (farthest != target.positions.end()) chosen.push_back(static_cast<size_t>(farthest - target.positions.begin()));
  }
  if (primitive.joints.size() == primitive.weights.size()) {
    std::map<uint16_t, std::pair<float, size_t>> held; // joint to (weight, vertex)
    for (size_t i = 0; i < primitive.joints.size(); ++i) {
      for (size_t k = 0; k < 4; ++k) {
        const float weight = primitive.weights[i][static_cast<int>(k)];
        auto& [max_weight, vertex] = held[primitive.joints[i][k]];
        if (weight > max_weight) max_weight = weight, vertex = i % count;
      }
    }
    for (const auto& [joint, entry] : held) chosen.push_back(entry.second);
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

// Returns a copy of the primitive that holds only these vertices.
Primitive pick(const Primitive& primitive, const std::vector<size_t>& vertices) {
  Primitive picked;
  const auto copy = [&vertices](const auto& from, auto& to, size_t offset) {
    for (const size_t v : vertices) to.push_back(from[offset + v]);
  };
  const size_t count = primitive.positions.size();
  copy(primitive.positions, picked.positions, 0);
  if (primitive.joints.size() == primitive.weights.size()) {
    for (size_t offset = 0; offset < primitive.joints.size(); offset += count) {
      copy(primitive.joints, picked.joints, offset);
      copy(primitive.weights, picked.weights, offset);
    }
  }
  for (const MorphTarget& target : primitive.targets) {
    picked.targets.emplace_back();
    if (!target.positions.empty()) copy(target.positions, picked.targets.back().positions, 0);
  }
  return picked;
}

std::vector<Primitive> pick_vertices(const Mesh& mesh) {
  size_t count = 0;
  for (const Primitive& primitive : mesh.primitives) count += primitive.positions.size();
  std::vector<Primitive> picked;
  for (const Primitive& primitive : mesh.primitives) {
    const size_t size = primitive.positions.size();
    const size_t spread = count <= kSpreadVertices ? size : size * kSpreadVertices / count;
    picked.push_back(pick(primitive, choose_vertices(primitive, spread)));
  }
  return picked;
}

Box3f box_of(const Mesh& mesh, const std::vector<PosedMesh::Deformed>& deformed) {
  Box3f box;
  for (size_t p = 0; p < mesh.primitives.size(); ++p) {
    for (const V3f& position : deformed.empty() ? mesh.primitives[p].positions : deformed[p].positions)
      if (is_finite(position)) box.extendBy(position);
  }
  return box;
}

} // namespace

void MotionProbe::points(const Scene& scene, const AnimatedNodes& nodes, std::vector<V3f>& points) const {
  points.clear();
  const M44f& to_world = nodes.to_world(node);
  if (is_frame()) {
    const M44f frame = without_scale(to_world);
    for (const int row : {3, 0, 1, 2}) points.emplace_back(frame[row][0], frame[row][1], frame[row][2]);
  } else if (kind == Kind::deforming) {
    const auto joints =
        skin == kNone ? std::vector<M44f>() : nodes.joint_matrices(scene.skins[static_cast<size_t>(skin)]);
    for (const Primitive& primitive : *vertices) {
      PosedMesh::Deformed deformed = deform_primitive(primitive, nodes.morph_weights(node), joints, to_world);
      if (skin == kNone) move_to_world(instance * to_world, deformed);
      points.insert(points.end(), deformed.positions.begin(), deformed.positions.end());
    }
  } else if (!box.isEmpty()) {
    const M44f matrix = instance * to_world;
    for (int i = 0; i < 8; ++i)
      points.push_back(transform_point(
          matrix, {(i & 1) ? box.max.x : box.min.x, (i & 2) ? box.max.y : box.min.y, (i & 4) ? box.max.z : box.min.z}));
  }
}

std::vector<MotionProbe> find_motion_probes(const Scene& scene, const AnimatedNodes& nodes, const PosedScene& posed,
                                            GpuInstances gpu_instances) {
  std::vector<MotionProbe> probes;
  std::map<int, Box3f> box_of_mesh;
  std::map<int, std::shared_ptr<const std::vector<Primitive>>> vertices_of_mesh;
  for (size_t i = 0; i < posed.meshes.size(); ++i) {
    const PosedMesh& mesh = posed.meshes[i];
    const Node& node = scene.nodes[static_cast<size_t>(mesh.node)];
    MotionProbe probe{.index = i, .node = mesh.node, .skin = node.skin};
    if (gpu_instances[i] != kNone)
      probe.instance = to_matrix(node.gpu_instances[static_cast<size_t>(gpu_instances[i])]);
    bool deforming = nodes.has_animated_weights(mesh.node);
    if (node.skin != kNone) {
      deforming |= nodes.moves(mesh.node); // primitives without joints follow the node
      for (const int joint : scene.skins[static_cast<size_t>(node.skin)].joints) deforming |= nodes.moves(joint);
    }
    const Mesh& rest = scene.meshes[static_cast<size_t>(mesh.mesh)];
    if (deforming) {
      probe.kind = MotionProbe::Kind::deforming;
      auto& vertices = vertices_of_mesh[mesh.mesh];
      if (!vertices) vertices = std::make_shared<const std::vector<Primitive>>(pick_vertices(rest));
      probe.vertices = vertices;
    } else if (node.skin == kNone && nodes.moves(mesh.node)) {
      if (mesh.deformed.empty()) {
        const auto [entry, inserted] = box_of_mesh.try_emplace(mesh.mesh);
        if (inserted) entry->second = box_of(rest, {});
        probe.box = entry->second;
      } else {
        probe.box = box_of(rest, mesh.deformed);
      }
    } else {
      continue;
    }
    probes.push_back(std::move(probe));
  }
  for (size_t i = 0; i < posed.cameras.size(); ++i)
    if (nodes.moves(posed.cameras[i].node))
      probes.push_back({.kind = MotionProbe::Kind::camera, .index = i, .node = posed.cameras[i].node});
  for (size_t i = 0; i < posed.lights.size(); ++i)
    if (nodes.moves(posed.lights[i].node))
      probes.push_back({.kind = MotionProbe::Kind::light, .index = i, .node = posed.lights[i].node});
  return probes;
}

M44f without_scale(const M44f& m) {
  const V3f rows[3] = {V3f(m[0][0], m[0][1], m[0][2]).normalized(), V3f(m[1][0], m[1][1], m[1][2]).normalized(),
                       V3f(m[2][0], m[2][1], m[2][2]).normalized()};
  const V3f z = rows[2].length() > 0.0f ? rows[2] : V3f(0.0f, 0.0f, 1.0f);
  // If zero scale leaves no y, the remaining axes determine the frame.
  V3f x = rows[1].cross(z);
  if (x.length() < 1e-6f) x = rows[0] - z * z.dot(rows[0]);
  if (x.length() < 1e-6f) x = Frame::around(z).tangent;
  x.normalize();
  const V3f y = z.cross(x);
  return {x.x, x.y, x.z, 0.0f, y.x, y.y, y.z, 0.0f, z.x, z.y, z.z, 0.0f, m[3][0], m[3][1], m[3][2], 1.0f};
}

} // namespace kindling
