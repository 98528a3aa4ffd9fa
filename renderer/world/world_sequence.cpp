// Compares moments and reuses parts of the previous World.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/world_sequence.h"

#include "renderer/scene/animated_members.h"
#include "renderer/world/scene_changes.h"
#include "renderer/world/world_changes.h"
#include "renderer/world/world_parts.h"

#include <algorithm>
#include <utility>

namespace kindling {
namespace {

bool deforms(const PosedMesh& mesh) { return !mesh.deformed.empty() || !mesh.later_deformed.empty(); }

bool same(const PosedMesh& a, const PosedMesh& b) {
  return a.node == b.node && a.mesh == b.mesh && a.mesh_to_world == b.mesh_to_world &&
         a.later_transforms == b.later_transforms;
}
bool same(const PosedLight& a, const PosedLight& b) {
  return a.node == b.node && a.light == b.light && a.light_to_world == b.light_to_world &&
         a.later_transforms == b.later_transforms;
}

template <typename T>
bool all_same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const T& x, const T& y) { return same(x, y); });
}

// Returns the values that animations have set in materials, lights and meshes.
std::vector<float> animated_numbers(Scene& scene) {
  std::vector<float> numbers;
  for (const Animation& animation : scene.animations)
    for (const AnimationChannel& channel : animation.channels) {
      if (channel.property != AnimatedProperty::member || channel.member.owner == AnimatedMember::Owner::camera)
        continue;
      const std::span<float> values = animated_values(scene, channel.member);
      numbers.insert(numbers.end(), values.begin(), values.end());
    }
  return numbers;
}

} // namespace

std::vector<uint8_t> find_static_meshes(const Scene& scene) {
  const SceneChanges changes(scene);
  std::vector<uint8_t> is_static(scene.meshes.size());
  for (size_t mesh = 0; mesh < is_static.size(); ++mesh) is_static[mesh] = changes.meshes[mesh] == 0 ? 1 : 0;
  std::vector<uint32_t> uses(scene.meshes.size(), 0);
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (node.mesh == kNone) continue;
    const auto mesh = static_cast<size_t>(node.mesh);
    if (++uses[mesh] > 1 || changes.nodes[i] != 0 || node.skin != kNone || !node.gpu_instances.empty())
      is_static[mesh] = 0;
  }
  for (size_t mesh = 0; mesh < scene.meshes.size(); ++mesh)
    for (const Primitive& primitive : scene.meshes[mesh].primitives)
      if (!primitive.targets.empty() ||
          (primitive.material != kNone && changes.materials[static_cast<size_t>(primitive.material)] != 0))
        is_static[mesh] = 0;
  return is_static;
}

WorldSequence::WorldSequence() : parts_(std::make_unique<WorldParts>()) {}
WorldSequence::~WorldSequence() = default;

bool WorldSequence::is_shown(const PosedScene& posed, const std::vector<float>& members) const {
  return world_ && shown_ && std::none_of(posed.meshes.begin(), posed.meshes.end(), deforms) &&
         all_same(posed.meshes, shown_->meshes) && all_same(posed.lights, shown_->lights) && members == shown_->members;
}

Result<void> WorldSequence::hide_backs(const WorldOptions& options, const CancelToken* cancel,
                                       ProgressListener* listener) {
  return WorldChanges::hide_backs(*world_, options, cancel, listener);
}

void WorldSequence::light_by_studio(bool studio) { WorldChanges::light_by_studio(*world_, studio); }

Result<const World*> WorldSequence::next(Scene& scene, PosedScene posed, const WorldOptions& options, bool more,
                                         const CancelToken* cancel, ProgressListener* listener) {
  const std::vector<float> members = animated_numbers(scene);
  if (is_shown(posed, members)) {
    if (listener) listener->on_info("only the camera has changed: the previous frame's world is reused");
    return world_.get();
  }
  shown_.reset();
  if (world_) take_parts(std::move(world_), *parts_);
  if (more && std::none_of(posed.meshes.begin(), posed.meshes.end(), deforms))
    shown_ = {posed.meshes, posed.lights, members};
  parts_->keep_scene = more;
  if (more && parts_->static_meshes.empty()) parts_->static_meshes = find_static_meshes(scene);
  Scene last; // freed with its nodes once the World exists
  if (!more) last = std::move(scene);
  Result<std::unique_ptr<World>> world =
      // NOLINTNEXTLINE(bugprone-use-after-move): `scene` is used only if it was not moved from
      build_world_of_parts(more ? scene : last, std::move(posed), options, *parts_, cancel, listener);
  if (!world.ok()) return world.error();
  world_ = std::move(world).value();
  return world_.get();
}

} // namespace kindling
