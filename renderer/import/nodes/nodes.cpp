// Reads nodes, instances and scenes, and checks the tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/nodes/nodes.h"

#include "renderer/import/document/accessor.h"
#include "renderer/import/json/extensions.h"
#include "renderer/import/json/kindling_extras.h"
#include "renderer/import/meshes/meshes.h"
#include "renderer/import/meshes/vertex_repair.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <utility>

namespace kindling::gltf {
namespace {

using nlohmann::json;

std::string node_pointer(size_t node) { return fmt::format("/nodes/{}", node); }

V3f to_v3f(const std::vector<double>& values) {
  return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])};
}

void read_transform(const tinygltf::Node& core, const json& object, const std::string& pointer, Node& node,
                    Warnings& warnings) {
  if (!core.matrix.empty()) {
    if (object.contains("translation") || object.contains("rotation") || object.contains("scale")) {
      warnings.repair("matrix", pointer + "/matrix",
                      "a matrix beside translation, rotation or scale, expected one or the other", "NODE_MATRIX_TRS",
                      "the matrix is used");
    }
    M44f matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = static_cast<float>(core.matrix[static_cast<size_t>(i)]);
    for (int row = 0; row < 4; ++row) {
      const float wanted = row == 3 ? 1.0f : 0.0f;
      if (std::abs(matrix[row][3] - wanted) > 1e-5f) {
        warnings.repair(
            "affine", pointer + "/matrix",
            fmt::format("element {} is {}, expected an affine matrix with {}", row * 4 + 3, matrix[row][3], wanted),
            "NODE_MATRIX_NON_TRS", fmt::format("{} is used", wanted));
      }
      matrix[row][3] = wanted;
    }
    node.matrix = matrix;
    return;
  }
  if (!core.translation.empty()) node.local.translation = to_v3f(core.translation);
  if (!core.scale.empty()) node.local.scale = to_v3f(core.scale);
  if (!core.rotation.empty()) {
    const std::vector<double>& q = core.rotation;
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-6)) {
      warnings.repair("rotation", pointer + "/rotation", "a quaternion of length 0, expected length 1",
                      "ROTATION_NON_UNIT", "the node is not rotated");
      return;
    }
    node.local.rotation = {static_cast<float>(q[3] / length), static_cast<float>(q[0] / length),
                           static_cast<float>(q[1] / length), static_cast<float>(q[2] / length)};
  }
}

// Reads EXT_mesh_gpu_instancing.
void read_instances(const Document& document, const json& extension, const std::string& pointer, ElementBudget& budget,
                    uint64_t& total, Node& node) {
  const std::string place = pointer + "/extensions/EXT_mesh_gpu_instancing/attributes";
  size_t count = 0;
  bool counted = false;
  for (const auto& [name, accessor] : extension["attributes"].items()) {
    const size_t here = document.core.accessors[accessor.get<size_t>()].count;
    if (counted && here != count)
      fail(fmt::format("{}/{}", place, name), fmt::format("{} elements, another attribute has {}", here, count),
           "ACCESSOR_COUNT_MISMATCH");
    count = here;
    counted = true;
  }
  if (!counted) fail(place, "no attributes, expected at least one");
  total += count;
  if (total > document.limits.max_gpu_instances) {
    fail(place, fmt::format("more than {} instances in the file", document.limits.max_gpu_instances));
  }
  budget.charge(count * 3, place);

  node.gpu_instances.resize(count);
  const auto read = [&](const char* name, const AccessorFormat& format, auto assign) {
    const auto found = extension["attributes"].find(name);
    if (found == extension["attributes"].end()) return;
    const std::string at = fmt::format("{}/{}", place, name);
    const AccessorView view = view_accessor(document, static_cast<int>(found->get<int64_t>()), at);
    require_format(view, format, at, name, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT");
    const auto width = static_cast<size_t>(format.components);
    std::vector<float> values(count * width);
    read_floats(view, {}, values.data(), format.components);
    if (!all_finite(values)) fail(at, "a value that is not finite", "ACCESSOR_INVALID_FLOAT");
    for (size_t i = 0; i < count; ++i) assign(node.gpu_instances[i], values.data() + i * width);
  };
  read("TRANSLATION", {.components = 3}, [](Transform& t, const float* v) { t.translation = {v[0], v[1], v[2]}; });
  read("SCALE", {.components = 3}, [](Transform& t, const float* v) { t.scale = {v[0], v[1], v[2]}; });
  read("ROTATION", {.components = 4, .normalized_int = true}, [](Transform& t, const float* v) {
    const Quatf q(v[3], v[0], v[1], v[2]);
    const float length = q.length();
    t.rotation =
        length > 1e-6f && std::isfinite(length) ? Quatf(q.r / length, q.v / length) : Quatf(1.0f, 0.0f, 0.0f, 0.0f);
  });
}

void read_node_extensions(const Document& document, const Scene& scene, const json& object, const std::string& pointer,
                          ElementBudget& budget, uint64_t& instances, Node& node, Warnings& warnings) {
  if (const json* light = find_extension(object, "KHR_lights_punctual")) {
    const auto index = (*light)["light"].get<uint64_t>();
    if (index < scene.lights.size()) {
      node.light = static_cast<int>(index);
    } else {
      warnings.repair("node light", pointer + "/extensions/KHR_lights_punctual/light",
                      fmt::format("{}, the file has {} lights", index, scene.lights.size()), "UNRESOLVED_REFERENCE",
                      "the node has no light");
    }
  }
  if (const json* visibility = find_extension(object, "KHR_node_visibility"))
    node.visible = visibility->value("visible", true);
  if (const json* instancing = find_extension(object, "EXT_mesh_gpu_instancing")) {
    if (node.mesh != kNone) read_instances(document, *instancing, pointer, budget, instances, node);
  }
}

// Checks that the skin has every joint that a vertex refers to. The vertices lose other joints,
// also those of other nodes with this mesh.
void check_skin(Scene& scene, std::vector<int>& highest_joint, const std::string& pointer, Node& node,
                Warnings& warnings) {
  if (node.skin == kNone) return;
  const int highest = node.mesh == kNone ? kNone : highest_joint[static_cast<size_t>(node.mesh)];
  if (highest == kNone) {
    node.skin = kNone; // nothing to deform
    return;
  }
  const size_t joints = scene.skins[static_cast<size_t>(node.skin)].joints.size();
  if (static_cast<size_t>(highest) >= joints) {
    warnings.repair(
        "skin joint", pointer + "/skin",
        fmt::format("a vertex of mesh {} uses joint {}, skin {} has {}", node.mesh, highest, node.skin, joints),
        "ACCESSOR_JOINTS_INDEX_OOB", "its weight is ignored");
    for (Primitive& primitive : scene.meshes[static_cast<size_t>(node.mesh)].primitives) {
      ignore_joints_from(primitive, joints);
    }
    highest_joint[static_cast<size_t>(node.mesh)] = static_cast<int>(joints) - 1;
  }
}

std::vector<int> highest_joints(const Scene& scene) {
  std::vector<int> highest(scene.meshes.size(), kNone);
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    for (const Primitive& primitive : scene.meshes[m].primitives) {
      for (const auto& joints : primitive.joints) {
        highest[m] = std::max(highest[m], static_cast<int>(*std::max_element(joints.begin(), joints.end())));
      }
    }
  }
  return highest;
}

bool is_zero(const MorphTarget& target) {
  return target.positions.empty() && target.normals.empty() && target.tangents.empty();
}

// Returns the elements that posing a node without any animation takes, as memory and as work: its
// own copy of the vertices, and each morph target in use once more. 0 for a mesh that is shared.
uint64_t count_deformed(const Scene& scene, const Node& node) {
  if (node.mesh == kNone) return 0;
  const Mesh& mesh = scene.meshes[static_cast<size_t>(node.mesh)];
  const std::vector<float>& weights = node.weights.empty() ? mesh.weights : node.weights;
  if (node.skin == kNone && std::all_of(weights.begin(), weights.end(), [](float w) { return w == 0.0f; })) return 0;
  uint64_t elements = 0;
  for (const Primitive& primitive : mesh.primitives) {
    elements += primitive.positions.size() + primitive.normals.size() + primitive.tangents.size();
    for (size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t)
      if (weights[t] != 0.0f && !is_zero(primitive.targets[t])) elements += primitive.positions.size();
  }
  return elements;
}

void remove_child(std::vector<Node>& nodes, int parent, int child) {
  std::vector<int>& children = nodes[static_cast<size_t>(parent)].children;
  children.erase(std::remove(children.begin(), children.end(), child), children.end());
}

// Returns the parent of each node. Of several parents of a node the last one stays, as in three.js.
std::vector<int> find_parents(std::vector<Node>& nodes, Warnings& warnings) {
  std::vector<int> parent(nodes.size(), kNone);
  std::vector<std::pair<int, int>> removed; // former parents, and children
  std::vector<int> repeated;
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (size_t c = 0; c < nodes[i].children.size(); ++c) {
      const int child = nodes[i].children[c];
      int& known = parent[static_cast<size_t>(child)];
      if (known != kNone) {
        const bool same = known == static_cast<int>(i);
        warnings.repair("parents", fmt::format("/nodes/{}/children/{}", i, c),
                        fmt::format("node {} is a child of node {} already", child, known), "NODE_PARENT_OVERRIDE",
                        same ? "it is listed once" : "it is moved to this one");
        if (same) repeated.push_back(static_cast<int>(i));
        if (!same) removed.emplace_back(known, child);
      }
      known = static_cast<int>(i);
    }
  }
  for (const auto& [former, child] : removed) remove_child(nodes, former, child);
  for (const int node : repeated) {
    std::vector<int>& children = nodes[static_cast<size_t>(node)].children;
    std::vector<int> once;
    std::set<int> seen;
    for (const int child : children)
      if (seen.insert(child).second) once.push_back(child);
    children = std::move(once);
  }
  return parent;
}

// Throws for a loop, or too many levels. `parent` is that of find_parents().
void check_tree(const Document& document, const std::vector<Node>& nodes, const std::vector<int>& parent) {
  // Breadth first from the roots. Each node has one parent, so a node that is not reached is in a
  // loop.
  std::vector<int> level;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (parent[i] == kNone) level.push_back(static_cast<int>(i));
  }
  std::vector<bool> reached(nodes.size(), false);
  for (uint32_t depth = 0; !level.empty(); ++depth) {
    if (depth >= document.limits.max_node_depth) {
      fail(node_pointer(static_cast<size_t>(level.front())),
           fmt::format("more than {} levels of nodes", document.limits.max_node_depth));
    }
    std::vector<int> next;
    for (const int node : level) {
      reached[static_cast<size_t>(node)] = true;
      const std::vector<int>& children = nodes[static_cast<size_t>(node)].children;
      next.insert(next.end(), children.begin(), children.end());
    }
    level = std::move(next);
  }
  const auto lost = std::find(reached.begin(), reached.end(), false);
  if (lost != reached.end()) {
    fail(node_pointer(static_cast<size_t>(lost - reached.begin())), "the node is part of a loop, or below one",
         "NODE_LOOP");
  }
}

// A child that a scene lists becomes a root: it leaves its parent, whose transform is not applied.
void import_scenes(const Document& document, std::vector<int>& parent, Scene& scene, Warnings& warnings) {
  std::vector<int> listed_by(scene.nodes.size(), kNone);
  for (size_t i = 0; i < document.core.scenes.size(); ++i) {
    const tinygltf::Scene& core = document.core.scenes[i];
    SceneRoot root{core.name, {}};
    for (size_t n = 0; n < core.nodes.size(); ++n) {
      const auto node = static_cast<size_t>(core.nodes[n]);
      const std::string pointer = fmt::format("/scenes/{}/nodes/{}", i, n);
      if (parent[node] != kNone) {
        warnings.repair("scene root", pointer,
                        fmt::format("node {} is a child of node {}, expected a root node", node, parent[node]),
                        "SCENE_NON_ROOT_NODE", "it becomes a root, without the transform of its parent");
        remove_child(scene.nodes, parent[node], core.nodes[n]);
        parent[node] = kNone;
      }
      if (listed_by[node] == static_cast<int>(i)) {
        warnings.repair("scene node", pointer, fmt::format("node {} is listed twice", node), "DUPLICATE_ELEMENTS",
                        "it is shown once");
        continue;
      }
      listed_by[node] = static_cast<int>(i);
      root.nodes.push_back(core.nodes[n]);
    }
    scene.scenes.push_back(std::move(root));
  }
  scene.default_scene = document.core.defaultScene >= 0 ? document.core.defaultScene : kNone;
  if (scene.scenes.empty() && !scene.nodes.empty()) {
    SceneRoot all;
    for (size_t i = 0; i < parent.size(); ++i) {
      if (parent[i] == kNone) all.nodes.push_back(static_cast<int>(i));
    }
    scene.scenes.push_back(std::move(all));
  }
}

} // namespace

void import_nodes(Document& document, Scene& scene, Warnings& warnings) {
  ElementBudget budget(document);
  uint64_t instances = 0;
  std::vector<int> highest_joint = highest_joints(scene);
  for (size_t i = 0; i < document.core.nodes.size(); ++i) {
    const tinygltf::Node& core = document.core.nodes[i];
    const json& object = (*document.json)["nodes"][i];
    const std::string pointer = node_pointer(i);
    Node node;
    node.name = core.name;
    node.children = core.children;
    KindlingExtras extras(object, pointer, warnings);
    node.light_group = extras.text("lightGroup").value_or("");
    node.shadow_catcher = extras.flag("shadowCatcher").value_or(false);
    extras.finish();
    node.mesh = core.mesh;
    node.skin = core.skin;
    node.camera = core.camera;
    for (const double weight : core.weights) node.weights.push_back(static_cast<float>(weight));
    const size_t targets = node.mesh == kNone ? 0 : morph_target_count(document, static_cast<size_t>(node.mesh));
    if (!node.weights.empty() && node.weights.size() != targets) {
      warnings.repair("node weights", pointer + "/weights",
                      fmt::format("{} weights, the mesh has {} morph targets", node.weights.size(), targets),
                      "NODE_WEIGHTS_INVALID", "missing ones are 0, others are ignored");
      node.weights.resize(targets, 0.0f);
    }
    read_transform(core, object, pointer, node, warnings);
    read_node_extensions(document, scene, object, pointer, budget, instances, node, warnings);
    if (node.skin != kNone && (node.mesh == kNone || highest_joint[static_cast<size_t>(node.mesh)] == kNone)) {
      warnings.add("skin", pointer + "/skin", "a skin on a node whose mesh has no joints has no effect",
                   "NODE_SKIN_WITH_NON_SKINNED_MESH");
    }
    check_skin(scene, highest_joint, pointer, node, warnings);
    budget.charge(count_deformed(scene, node), pointer);
    scene.nodes.push_back(std::move(node));
  }
  std::vector<int> parents = find_parents(scene.nodes, warnings);
  check_tree(document, scene.nodes, parents);
  import_scenes(document, parents, scene, warnings);
}

} // namespace kindling::gltf
