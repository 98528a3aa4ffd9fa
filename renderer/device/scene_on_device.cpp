// Places a scene and all of its arrays in one block of a device's memory.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/scene_on_device.h"

#include "accel/kdtree/kdtree_accelerator.h"
#include "accel/kdtree/view_tables.h"
#include "renderer/device/arena.h"
#include "renderer/device/copy_texels.h"

#include <cassert>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace kindling {
namespace {

// The textures of a scene as a device has them, except that texels are still the processor's: those
// of pages are loaded, and levels in tiles have none.
class PlacedTextures {
 public:
  // `tiles` may be null. With `counts` nothing is loaded: texels of pages have addresses without a
  // meaning.
  PlacedTextures(std::span<const TextureView> textures, const TilePlan* tiles, bool counts)
      : textures_(textures.begin(), textures.end()), counts_(counts) {
    for (size_t i = 0; i < textures_.size(); ++i) {
      TextureView& texture = textures_[i];
      for (int level = 0; level < texture.level_count; ++level) {
        const std::byte*& pixels = texture.levels[static_cast<size_t>(level)].pixels;
        if (tiles != nullptr && tiles->in_tiles(i, level))
          pixels = nullptr;
        else if (pixels == nullptr)
          pixels = loaded(textures[i], level);
      }
      texture.pages = nullptr;
    }
  }
  // Sets the addresses of the tiles.
  void refer_to(const TextureTiles* tiles_on_device) {
    for (size_t i = 0; i < textures_.size(); ++i) textures_[i].tiles = tiles_on_device + i;
  }
  [[nodiscard]] const std::vector<TextureView>& textures() const { return textures_; }

 private:
  const std::byte* loaded(const TextureView& texture, int number) {
    std::vector<std::byte>& texels = levels_[{texture.pages, number}];
    if (counts_) texels.resize(1);
    if (!texels.empty()) return texels.data();
    const TextureView::Level& level = texture.levels[static_cast<size_t>(number)];
    const size_t row_bytes = static_cast<size_t>(level.width) * texture.pixel_bytes;
    texels.resize(row_bytes * static_cast<size_t>(level.height));
    copy_texels(texture, {number, 0, 0, level.width, level.height}, texels.data(), row_bytes);
    return texels.data();
  }

  std::vector<TextureView> textures_;
  bool counts_;
  std::map<std::pair<const TiledImage*, int>, std::vector<std::byte>> levels_; // of pages
};

// Returns where a member of `whole` is, from its beginning.
template <typename Member>
size_t offset_of(const DeviceScene& whole, const Member& member) {
  return static_cast<size_t>(reinterpret_cast<const std::byte*>(&member) - reinterpret_cast<const std::byte*>(&whole));
}

void place(const DeviceSceneInput& input, const PlacedTextures& textures, Arena& arena) {
  const size_t offset = arena.reserve(sizeof(DeviceScene));
  const auto tables = accel::view_of(*input.world.probed);
  assert(tables != nullptr && offset == 0);
  const PathStages& stages = input.stages;
  DeviceScene scene{.tree = tables->view(),
                    .world = static_cast<const WorldView&>(input.world),
                    .camera = input.camera,
                    .patches = stages.patches != nullptr ? *stages.patches : BrightPatches{},
                    .light_probabilities =
                        stages.light_probabilities != nullptr ? *stages.light_probabilities : LightSelectionTreeView{},
                    .volumes = stages.volumes != nullptr ? *stages.volumes : VolumeGuideView{},
                    .to_environment =
                        stages.to_environment != nullptr ? *stages.to_environment : EnvironmentGuideView{},
                    .caustics = stages.caustics != nullptr ? *stages.caustics : CausticGuideView{},
                    .presampled = stages.presampled != nullptr ? *stages.presampled : PresampledEnvironmentView{},
                    .manifolds = stages.manifolds != nullptr ? *stages.manifolds : ManifoldView{},
                    .light_paths = input.light_paths != nullptr ? *input.light_paths : LightPathStages{},
                    .stages = stages,
                    .shader = input.shader,
                    .groups = input.groups,
                    .first_hit = input.first_hit,
                    .sampler = input.sampler,
                    .filter = input.filter};
  const auto on_device = [&](const auto& member) {
    return reinterpret_cast<std::remove_reference_t<decltype(member)>*>(arena.address(offset_of(scene, member)));
  };

  scene.world.traced = scene.world.probed = nullptr;
  scene.world.tree = on_device(scene.tree);
  scene.stages.world = on_device(scene.world);
  scene.stages.camera = on_device(scene.camera);
  if (stages.patches != nullptr) scene.stages.patches = on_device(scene.patches);
  if (stages.light_probabilities != nullptr) scene.stages.light_probabilities = on_device(scene.light_probabilities);
  if (stages.volumes != nullptr) scene.stages.volumes = on_device(scene.volumes);
  if (stages.to_environment != nullptr) scene.stages.to_environment = on_device(scene.to_environment);
  if (stages.caustics != nullptr) scene.stages.caustics = on_device(scene.caustics);
  if (stages.presampled != nullptr) scene.stages.presampled = on_device(scene.presampled);
  if (stages.manifolds != nullptr) scene.stages.manifolds = on_device(scene.manifolds);

  assert((input.light_paths != nullptr) == (stages.light_paths != nullptr));
  if (input.light_paths != nullptr) {
    scene.stages.light_paths = on_device(scene.light_paths);
    scene.light_paths.emission.lights = on_device(scene.world.lights);
    scene.light_paths.world = on_device(scene.world);
    scene.light_paths.camera = on_device(scene.camera);
  }

  scene.first_hit.world = on_device(scene.world);
  scene.first_hit.camera = on_device(scene.camera);

  scene.shader.world = on_device(scene.world);
  scene.shader.camera = on_device(scene.camera);
  scene.shader.lights.lights = on_device(scene.world.lights);
  scene.shader.cache = nullptr;

  scene.world.textures = textures.textures();
  arena.place(scene.world.textures);
  std::vector<Emission> emissions(input.world.lights.emissions.begin(), input.world.lights.emissions.end());
  for (Emission& emission : emissions)
    if (emission.texture != nullptr)
      emission.texture = scene.world.textures.data() + (emission.texture - input.world.textures.data());
  scene.world.lights.emissions = emissions;
  arena.place(scene.world.lights.emissions);
  const std::span<const TextureView> placed_textures = scene.world.textures;
  const std::span<const Emission> placed_emissions = scene.world.lights.emissions;
  scene.world.procedurals.images = {};
  scene.world.textures = {};
  scene.world.lights.emissions = {};
  arena.place_arrays(scene.world);
  scene.world.textures = scene.world.procedurals.images = placed_textures;
  scene.world.lights.emissions = placed_emissions;
  arena.place_arrays(scene.tree);
  arena.place_arrays(scene.camera);
  arena.place_arrays(scene.light_probabilities);
  arena.place_arrays(scene.volumes);
  arena.place_arrays(scene.to_environment);
  arena.place_arrays(scene.caustics);
  arena.place_arrays(scene.presampled);
  arena.place_arrays(scene.manifolds);
  arena.place_arrays(scene.light_paths);
  arena.place_arrays(scene.shader.lights);
  arena.place_arrays(scene.groups);
  arena.write(offset, std::as_bytes(std::span(&scene, 1)));
}

} // namespace

Result<void> check_device_scene(const World& world) {
  if (accel::view_of(*world.probed) == nullptr)
    return usage_error("a device renders with the kd-tree alone; use --accel kdtree");
  return {};
}

uint64_t scene_on_device_bytes(const DeviceSceneInput& input, const TilePlan* tiles) {
  Arena counter;
  place(input, PlacedTextures(input.world.textures, tiles, true), counter);
  return counter.bytes();
}

SceneOnDevice::SceneOnDevice(Device& device, const DeviceSceneInput& input, const TilePager* pager)
    : memory_(device, scene_on_device_bytes(input, pager != nullptr ? &pager->plan() : nullptr)) {
  PlacedTextures textures(input.world.textures, pager != nullptr ? &pager->plan() : nullptr, false);
  if (pager != nullptr) textures.refer_to(pager->tiles_on_device());
  Arena arena(device, memory_.data());
  place(input, textures, arena);
  assert(arena.bytes() == memory_.size());
}

} // namespace kindling
