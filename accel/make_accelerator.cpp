// The table of accelerator names and the factory that builds an accelerator by kind.
// SPDX-License-Identifier: Apache-2.0
#include "accel/make_accelerator.h"

#include "accel/brute_force.h"
#include "accel/embree/embree_accelerator.h"
#include "accel/kdtree/kdtree_accelerator.h"

#include <array>
#include <cassert>
#include <utility>

namespace kindling::accel {
namespace {

struct KindName {
  Kind kind;
  std::string_view name;
};
constexpr std::array kKindNames = {KindName{Kind::brute_force, "brute-force"}, KindName{Kind::embree, "embree"},
                                   KindName{Kind::kdtree, "kdtree"}};

// Returns true if all indices, counts and motion keys of the input are in range; vertex indices are
// not checked.
[[maybe_unused]] bool is_consistent(const BuildInput& input) {
  for (const MeshGroup& group : input.groups)
    if (uint64_t{group.first_mesh} + group.mesh_count > input.meshes.size()) return false;
  for (const TriangleMesh& mesh : input.meshes) {
    if (mesh.indices.size() % 3 != 0 || mesh.later_positions.size() >= kMaxMotionKeys) return false;
    for (const std::span<const Imath::V3f> later : mesh.later_positions)
      if (later.size() != mesh.positions.size()) return false;
  }
  for (const std::span<const Imath::M44f> keys : input.motions)
    if (keys.size() < 2 || keys.size() > kMaxMotionKeys) return false;
  for (size_t i = 0; i < input.instances.size(); ++i) {
    const Instance& instance = input.instances[i];
    if (instance.group >= input.groups.size()) return false;
    if (instance.motion != kNoId && instance.motion >= input.motions.size()) return false;
  }
  return true;
}

} // namespace

std::unique_ptr<Accelerator> make_accelerator(Kind kind, const BuildInput& input, const BuildOptions& options,
                                              std::unique_ptr<PersistentStructures> previous) {
  assert(is_consistent(input));
  switch (kind) {
  case Kind::brute_force: return make_brute_force(input, options);
  case Kind::embree: return make_embree(input, options, std::move(previous));
  case Kind::kdtree: return make_kdtree(input, options, std::move(previous));
  }
  return nullptr;
}

std::string_view kind_name(Kind kind) {
  for (const KindName& entry : kKindNames)
    if (entry.kind == kind) return entry.name;
  return {};
}

std::optional<Kind> kind_from_name(std::string_view name) {
  for (const KindName& entry : kKindNames)
    if (entry.name == name) return entry.kind;
  return std::nullopt;
}

std::string_view kind_description(Kind kind) {
  switch (kind) {
  case Kind::brute_force: return "brute force";
  case Kind::embree: return embree_description();
  case Kind::kdtree: return "Kindling kd-tree";
  }
  return {};
}

std::string_view quality_name(Quality quality) {
  switch (quality) {
  case Quality::fast: return "fast";
  case Quality::balanced: return "balanced";
  case Quality::best: return "best";
  }
  return "balanced";
}

std::optional<Quality> quality_from_name(std::string_view name) {
  for (const Quality quality : {Quality::fast, Quality::balanced, Quality::best})
    if (name == quality_name(quality)) return quality;
  return std::nullopt;
}

} // namespace kindling::accel
