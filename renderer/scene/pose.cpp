// Poses a Scene: applies the animations, walks the node tree, and lists and deforms what it finds.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/pose.h"

#include "renderer/base/frame.h"
#include "renderer/scene/animation.h"
#include "renderer/scene/deform.h"

#include <tbb/parallel_for.h>

#include <cassert>
#include <unordered_map>

namespace kindling {
namespace {

// Deformed vertices are stored once for each mesh in the world; beyond this a scene is refused rather than run out of
// memory.
constexpr uint64_t kMaxDeformedVertices = 1ULL << 30;

// The parts of the nodes that animations can change, at one time.
struct AnimatedNodes {
  std::vector<Transform> local;
  std::vector<uint8_t> visible;
  std::unordered_map<int, std::vector<float>> weights; // only nodes whose weights are animated
};

// Morph weights in force for a node: animated, else the node's, else the mesh's.
const std::vector<float>& morph_weights(const Scene& scene, const AnimatedNodes& nodes, int node) {
  const auto animated = nodes.weights.find(node);
  if (animated != nodes.weights.end()) return animated->second;
  const Node& n = scene.nodes[static_cast<size_t>(node)];
  return n.weights.empty() ? scene.meshes[static_cast<size_t>(n.mesh)].weights : n.weights;
}

// The whole list, with one weight of it replaced.
std::vector<float> with_weight(const Scene& scene, const AnimatedNodes& nodes, const AnimationChannel& channel,
                               float value) {
  std::vector<float> weights = morph_weights(scene, nodes, channel.node);
  const auto index = static_cast<size_t>(channel.weight);
  if (weights.size() <= index) weights.resize(index + 1, 0.0f);
  weights[index] = value;
  return weights;
}

void apply_channel(const Scene& scene, const AnimationChannel& channel, double time_s, AnimatedNodes& nodes) {
  if (channel.node == kNone || channel.times_s.empty() || channel.components <= 0) return;
  const auto node = static_cast<size_t>(channel.node);
  assert(node < nodes.local.size());
  std::vector<float> value(static_cast<size_t>(channel.components));
  sample_channel(channel, time_s, value);
  switch (channel.property) {
  case AnimatedProperty::translation: nodes.local[node].translation = {value[0], value[1], value[2]}; break;
  case AnimatedProperty::rotation: nodes.local[node].rotation = Quatf(value[3], value[0], value[1], value[2]); break;
  case AnimatedProperty::scale: nodes.local[node].scale = {value[0], value[1], value[2]}; break;
  case AnimatedProperty::weights:
    nodes.weights[channel.node] =
        channel.weight == kNone ? std::move(value) : with_weight(scene, nodes, channel, value[0]);
    break;
  case AnimatedProperty::visible: nodes.visible[node] = value[0] != 0.0f; break;
  case AnimatedProperty::member: break; // of no node: animate_members()
  }
}

AnimatedNodes animate(const Scene& scene, const std::optional<double>& time_s) {
  AnimatedNodes nodes;
  nodes.local.reserve(scene.nodes.size());
  nodes.visible.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) {
    nodes.local.push_back(node.local);
    nodes.visible.push_back(node.visible ? 1 : 0);
  }
  if (time_s) {
    for (const Animation& animation : scene.animations) {
      for (const AnimationChannel& channel : animation.channels) apply_channel(scene, channel, *time_s, nodes);
    }
  }
  return nodes;
}

// Calls visit(node, parent) for the roots and all below them, parents first, siblings in order; without recursion,
// since trees may be deep. A node is visited once, even where a broken file names it twice.
template <typename Visit>
void walk(const Scene& scene, const std::vector<int>& roots, const Visit& visit) {
  struct Entry {
    int node;
    int parent;
  };
  std::vector<Entry> stack;
  std::vector<uint8_t> seen(scene.nodes.size(), 0);
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, kNone});
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    const auto index = static_cast<size_t>(entry.node);
    assert(index < scene.nodes.size());
    if (seen[index]) continue;
    seen[index] = 1;
    visit(entry.node, entry.parent);
    const std::vector<int>& children = scene.nodes[index].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) stack.push_back({*child, entry.node});
  }
}

std::vector<int> parentless_nodes(const Scene& scene) {
  std::vector<uint8_t> has_parent(scene.nodes.size(), 0);
  for (const Node& node : scene.nodes) {
    for (const int child : node.children) has_parent[static_cast<size_t>(child)] = 1;
  }
  std::vector<int> roots;
  for (size_t i = 0; i < has_parent.size(); ++i) {
    if (!has_parent[i]) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

// Of every node, whichever scene it is in: joints of a skin may lie outside the scene that shows it.
std::vector<M44f> node_to_world(const Scene& scene, const std::vector<int>& roots, const AnimatedNodes& nodes) {
  std::vector<M44f> matrices(scene.nodes.size());
  walk(scene, roots, [&](int node, int parent) {
    const auto i = static_cast<size_t>(node);
    const M44f local = scene.nodes[i].matrix ? *scene.nodes[i].matrix : to_matrix(nodes.local[i]);
    matrices[i] = parent == kNone ? local : local * matrices[static_cast<size_t>(parent)];
  });
  return matrices;
}

// Keeps position, viewing axis (z) and the side that is up (y); x follows as their cross product. So scale and shear
// are gone and the frame is right-handed: under a mirrored parent a camera looks where it is put and its picture is not
// flipped.
M44f without_scale(const M44f& m) {
  const V3f rows[3] = {V3f(m[0][0], m[0][1], m[0][2]).normalized(), V3f(m[1][0], m[1][1], m[1][2]).normalized(),
                       V3f(m[2][0], m[2][1], m[2][2]).normalized()};
  const V3f z = rows[2].length() > 0.0f ? rows[2] : V3f(0.0f, 0.0f, 1.0f);
  // Where scales of zero leave no y, what is left of the frame decides.
  V3f x = rows[1].cross(z);
  if (x.length() < 1e-6f) x = rows[0] - z * z.dot(rows[0]);
  if (x.length() < 1e-6f) x = Frame::around(z).tangent;
  x.normalize();
  const V3f y = z.cross(x);
  return {x.x, x.y, x.z, 0.0f, y.x, y.y, y.z, 0.0f, z.x, z.y, z.z, 0.0f, m[3][0], m[3][1], m[3][2], 1.0f};
}

bool is_morphed(const Mesh& mesh, const std::vector<float>& weights) {
  size_t targets = 0;
  for (const Primitive& primitive : mesh.primitives) targets = std::max(targets, primitive.targets.size());
  const auto end = weights.begin() + static_cast<std::ptrdiff_t>(std::min(targets, weights.size()));
  return std::any_of(weights.begin(), end, [](float w) { return w != 0.0f; });
}

std::vector<M44f> joint_matrices(const Skin& skin, const std::vector<M44f>& to_world) {
  std::vector<M44f> matrices;
  matrices.reserve(skin.joints.size());
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    const M44f& joint_to_world = to_world[static_cast<size_t>(skin.joints[j])];
    matrices.push_back(j < skin.inverse_bind_matrices.size() ? skin.inverse_bind_matrices[j] * joint_to_world
                                                             : joint_to_world);
  }
  return matrices;
}

void list_meshes(const Scene& scene, int node, const M44f& to_world, PosedScene& posed) {
  const Node& n = scene.nodes[static_cast<size_t>(node)];
  if (n.skin != kNone) {
    posed.meshes.push_back({node, n.mesh, M44f(), {}}); // skinned vertices are in the world already
  } else if (n.gpu_instances.empty()) {
    posed.meshes.push_back({node, n.mesh, to_world, {}});
  } else {
    for (const Transform& instance : n.gpu_instances) {
      posed.meshes.push_back({node, n.mesh, to_matrix(instance) * to_world, {}});
    }
  }
}

// Fills PosedMesh::deformed where a skin or morph targets move vertices. False: too many vertices.
bool deform_meshes(const Scene& scene, const AnimatedNodes& nodes, const std::vector<M44f>& to_world,
                   PosedScene& posed) {
  std::vector<PosedMesh*> jobs;
  uint64_t vertices = 0;
  for (PosedMesh& posed_mesh : posed.meshes) {
    const Mesh& mesh = scene.meshes[static_cast<size_t>(posed_mesh.mesh)];
    const bool skinned = scene.nodes[static_cast<size_t>(posed_mesh.node)].skin != kNone;
    if (!skinned && !is_morphed(mesh, morph_weights(scene, nodes, posed_mesh.node))) continue;
    for (const Primitive& primitive : mesh.primitives) vertices += primitive.positions.size();
    jobs.push_back(&posed_mesh);
  }
  if (vertices > kMaxDeformedVertices) return false;

  tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t i) {
    PosedMesh& job = *jobs[i];
    const int skin = scene.nodes[static_cast<size_t>(job.node)].skin;
    const auto joints =
        skin == kNone ? std::vector<M44f>() : joint_matrices(scene.skins[static_cast<size_t>(skin)], to_world);
    const std::vector<float>& weights = morph_weights(scene, nodes, job.node);
    for (const Primitive& primitive : scene.meshes[static_cast<size_t>(job.mesh)].primitives) {
      job.deformed.push_back(deform_primitive(primitive, weights, joints, to_world[static_cast<size_t>(job.node)]));
    }
  });
  return true;
}

Error no_such_scene(const Scene& scene, int asked) {
  std::string message = scene.source + ": scene " + std::to_string(asked) + " does not exist; ";
  if (scene.scenes.empty()) return {ErrorKind::usage, message + "the file has none"};
  message += "use";
  for (size_t i = 0; i < scene.scenes.size(); ++i) {
    message += i == 0 ? " " : i + 1 == scene.scenes.size() ? " or " : ", ";
    message += std::to_string(i);
    if (!scene.scenes[i].name.empty()) message += " '" + scene.scenes[i].name + "'";
  }
  return {ErrorKind::usage, message};
}

} // namespace

M44f to_matrix(const Transform& transform) {
  M44f m = transform.rotation.toMatrix44();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[row][column] *= transform.scale[row];
  }
  for (int column = 0; column < 3; ++column) m[3][column] = transform.translation[column];
  return m;
}

Result<PosedScene> pose_scene(const Scene& scene, const PoseOptions& options) {
  // Which roots are shown: the scene asked for, else the file's default, else the first, else (no scenes at all)
  // everything.
  const auto scene_count = static_cast<int>(scene.scenes.size());
  int shown = options.scene != kNone ? options.scene : scene.default_scene;
  if (shown == kNone && scene_count > 0) shown = 0;
  if (shown != kNone && (shown < 0 || shown >= scene_count)) return no_such_scene(scene, shown);
  const std::vector<int> all_roots = parentless_nodes(scene);
  const std::vector<int>& roots = shown == kNone ? all_roots : scene.scenes[static_cast<size_t>(shown)].nodes;

  const AnimatedNodes nodes = animate(scene, options.time_s);
  const std::vector<M44f> to_world = node_to_world(scene, all_roots, nodes);

  PosedScene posed;
  if (shown != kNone) posed.image_light = scene.scenes[static_cast<size_t>(shown)].image_light;
  std::vector<uint8_t> visible(scene.nodes.size(), 0);
  walk(scene, roots, [&](int node, int parent) {
    const auto i = static_cast<size_t>(node);
    const Node& n = scene.nodes[i];
    visible[i] = nodes.visible[i] && (parent == kNone || visible[static_cast<size_t>(parent)]);
    if (n.camera != kNone) posed.cameras.push_back({node, n.camera, without_scale(to_world[i])}); // hidden ones too
    if (!visible[i]) return;
    if (n.light != kNone) posed.lights.push_back({node, n.light, without_scale(to_world[i])});
    if (n.photometric_light != kNone) posed.lights.push_back({node, n.photometric_light, without_scale(to_world[i])});
    if (n.mesh != kNone) list_meshes(scene, node, to_world[i], posed);
  });

  if (!deform_meshes(scene, nodes, to_world, posed)) {
    return Error{ErrorKind::scene_invalid, scene.source + ": skins and morph targets deform more than " +
                                               std::to_string(kMaxDeformedVertices) +
                                               " vertices, counting each mesh in the world; use fewer instances"};
  }
  return posed;
}

} // namespace kindling
