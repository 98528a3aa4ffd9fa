// Poses a Scene: applies the animations, walks the node tree, lists objects and deforms meshes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/pose.h"

#include "renderer/scene/animated_nodes.h"
#include "renderer/scene/deform.h"
#include "renderer/scene/pose_motion.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>

namespace kindling {
namespace {

// Deformed vertices are stored once for each mesh in the world; scenes beyond this limit are
// refused before they exhaust memory.
constexpr uint64_t kMaxDeformedVertices = 1ULL << 30;

bool is_morphed(const Mesh& mesh, const std::vector<float>& weights) {
  size_t targets = 0;
  for (const Primitive& primitive : mesh.primitives) targets = std::max(targets, primitive.targets.size());
  const auto end = weights.begin() + static_cast<std::ptrdiff_t>(std::min(targets, weights.size()));
  return std::any_of(weights.begin(), end, [](float w) { return w != 0.0f; });
}

// `instance_of` gets one entry for each mesh (GpuInstances).
void list_meshes(const Scene& scene, int node, const M44f& to_world, PosedScene& posed, std::vector<int>& instance_of) {
  const Node& n = scene.nodes[static_cast<size_t>(node)];
  if (n.skin != kNone) {
    posed.meshes.push_back({node, n.mesh, M44f(), {}}); // skinned vertices are in world space already
  } else if (n.gpu_instances.empty()) {
    posed.meshes.push_back({node, n.mesh, to_world, {}});
  } else {
    const size_t first = posed.meshes.size();
    posed.meshes.resize(first + n.gpu_instances.size());
    tbb::parallel_for(size_t{0}, n.gpu_instances.size(), [&](size_t i) {
      PosedMesh& mesh = posed.meshes[first + i];
      mesh.node = node;
      mesh.mesh = n.mesh;
      mesh.mesh_to_world = to_matrix(n.gpu_instances[i]) * to_world;
    });
    instance_of.resize(posed.meshes.size());
    std::iota(instance_of.begin() + static_cast<std::ptrdiff_t>(first), instance_of.end(), 0);
  }
  instance_of.resize(posed.meshes.size(), kNone);
}

// Fills PosedMesh::deformed for skinned and morphed meshes. Returns false if there are too many
// vertices.
bool deform_meshes(const Scene& scene, const AnimatedNodes& nodes, PosedScene& posed) {
  std::vector<PosedMesh*> jobs;
  uint64_t vertices = 0;
  for (PosedMesh& posed_mesh : posed.meshes) {
    const Mesh& mesh = scene.meshes[static_cast<size_t>(posed_mesh.mesh)];
    const bool skinned = scene.nodes[static_cast<size_t>(posed_mesh.node)].skin != kNone;
    if (!skinned && !is_morphed(mesh, nodes.morph_weights(posed_mesh.node))) continue;
    for (const Primitive& primitive : mesh.primitives) vertices += primitive.positions.size();
    jobs.push_back(&posed_mesh);
  }
  if (vertices > kMaxDeformedVertices) return false;

  tbb::parallel_for(size_t{0}, jobs.size(), [&](size_t i) {
    PosedMesh& job = *jobs[i];
    const int skin = scene.nodes[static_cast<size_t>(job.node)].skin;
    const auto joints =
        skin == kNone ? std::vector<M44f>() : nodes.joint_matrices(scene.skins[static_cast<size_t>(skin)]);
    const std::vector<float>& weights = nodes.morph_weights(job.node);
    for (const Primitive& primitive : scene.meshes[static_cast<size_t>(job.mesh)].primitives) {
      job.deformed.push_back(deform_primitive(primitive, weights, joints, nodes.to_world(job.node)));
    }
  });
  return true;
}

// Returns the first matrix out of reach of an object's keys; null if there is none.
const M44f* find_beyond_reach(const M44f& first, const std::vector<M44f>& later) {
  if (!is_within_reach(first)) return &first;
  const auto found = std::find_if_not(later.begin(), later.end(), is_within_reach);
  return found == later.end() ? nullptr : &*found;
}

// Refuses transforms that overflow only as the product of a node's and its parents', at any key.
Result<void> check_transforms(const Scene& scene, const PosedScene& posed) {
  const auto fault = [&](int node, const M44f& matrix) {
    std::array<char, 32> number{};
    for (int row = 3; row >= 0; --row)
      for (int column = 2; column >= 0; --column)
        if (!(std::abs(matrix[row][column]) <= kMaxTransform))
          std::snprintf(number.data(), number.size(), "%g", static_cast<double>(matrix[row][column]));
    return Error{ErrorKind::scene_invalid, scene.source + ": /nodes/" + std::to_string(node) +
                                               ": with those of its parents, its transform has " + "the number " +
                                               number.data() + ", expected numbers from -1e+18 to 1e+18"};
  };
  std::atomic<size_t> first{posed.meshes.size()}; // the first mesh out of reach
  tbb::parallel_for(tbb::blocked_range<size_t>(0, posed.meshes.size(), 4096), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      if (find_beyond_reach(posed.meshes[i].mesh_to_world, posed.meshes[i].later_transforms) == nullptr) continue;
      for (size_t known = first; i < known && !first.compare_exchange_weak(known, i);) {
      }
      return;
    }
  });
  if (first < posed.meshes.size()) {
    const PosedMesh& mesh = posed.meshes[first];
    return fault(mesh.node, *find_beyond_reach(mesh.mesh_to_world, mesh.later_transforms));
  }
  for (const PosedLight& light : posed.lights) {
    const M44f* matrix = find_beyond_reach(light.light_to_world, light.later_transforms);
    if (matrix != nullptr) return fault(light.node, *matrix);
  }
  return {};
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

bool is_within_reach(const M44f& matrix) {
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 3; ++column)
      if (!(std::abs(matrix[row][column]) <= kMaxTransform)) return false;
  return true;
}

Result<PosedScene> pose_scene(const Scene& scene, const PoseOptions& options) {
  // Shows the requested scene, else the file's default, else the first, else (no scenes at all) all
  // root nodes.
  const auto scene_count = static_cast<int>(scene.scenes.size());
  int shown = options.scene != kNone ? options.scene : scene.default_scene;
  if (shown == kNone && scene_count > 0) shown = 0;
  if (shown != kNone && (shown < 0 || shown >= scene_count)) return no_such_scene(scene, shown);
  const std::vector<int> all_roots = parentless_nodes(scene);
  const std::vector<int>& roots = shown == kNone ? all_roots : scene.scenes[static_cast<size_t>(shown)].nodes;

  std::optional<double> time_s = options.time_s;
  if (options.shutter) time_s = 0.5 * (options.shutter->open_s + options.shutter->close_s); // for visibility
  AnimatedNodes nodes(scene, time_s);
  std::vector<uint8_t> visible(scene.nodes.size(), 0);
  walk_nodes(scene, roots, [&](int node, int parent) {
    visible[static_cast<size_t>(node)] =
        nodes.visible(node) && (parent == kNone || visible[static_cast<size_t>(parent)]);
  });
  if (options.shutter) nodes.set_time(options.shutter->open_s);

  PosedScene posed;
  posed.animated = time_s.has_value();
  if (shown != kNone) posed.image_light = scene.scenes[static_cast<size_t>(shown)].image_light;
  std::vector<int> gpu_instances;
  size_t mesh_count = 0;
  for (size_t i = 0; i < scene.nodes.size(); ++i)
    if (visible[i] && scene.nodes[i].mesh != kNone)
      mesh_count += std::max<size_t>(1, scene.nodes[i].gpu_instances.size());
  posed.meshes.reserve(mesh_count);
  gpu_instances.reserve(mesh_count);
  walk_nodes(scene, roots, [&](int node, int /*parent*/) {
    const auto i = static_cast<size_t>(node);
    const Node& n = scene.nodes[i];
    const M44f& to_world = nodes.to_world(node);
    if (n.camera != kNone) posed.cameras.push_back({node, n.camera, without_scale(to_world)}); // including hidden ones
    if (!visible[i]) return;
    if (n.light != kNone) posed.lights.push_back({node, n.light, without_scale(to_world)});
    if (n.photometric_light != kNone) posed.lights.push_back({node, n.photometric_light, without_scale(to_world)});
    if (n.mesh != kNone) list_meshes(scene, node, to_world, posed, gpu_instances);
  });

  if (Result<void> checked = check_transforms(scene, posed); !checked.ok()) return checked.error();
  if (!deform_meshes(scene, nodes, posed) ||
      (options.shutter && !add_motion(scene, *options.shutter, gpu_instances, kMaxDeformedVertices, nodes, posed))) {
    return Error{ErrorKind::scene_invalid,
                 scene.source + ": skins and morph targets deform more than " + std::to_string(kMaxDeformedVertices) +
                     " vertices, counting each mesh in the world" +
                     (options.shutter ? " at each key of its motion" : "") + "; use fewer instances" +
                     (options.shutter ? " or a shorter shutter" : "")};
  }
  if (options.shutter) {
    if (Result<void> checked = check_transforms(scene, posed); !checked.ok()) return checked.error();
  }
  return posed;
}

} // namespace kindling
