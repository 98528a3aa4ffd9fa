// Places a scene and all of its arrays in one block of a device's memory.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/scene_on_device.h"

#include "accel/kdtree/kdtree_accelerator.h"
#include "accel/kdtree/view_tables.h"
#include "renderer/device/arena.h"

#include <array>
#include <cassert>
#include <memory>
#include <vector>

namespace kindling {
namespace {

// The texels of textures whose pages a cache loads, all in memory.
class LoadedPages {
 public:
  // Returns the textures with their texels in memory.
  explicit LoadedPages(std::span<const TextureView> textures) : textures_(textures.begin(), textures.end()) {
    for (TextureView& texture : textures_)
      if (texture.pages != nullptr) load(texture);
  }
  [[nodiscard]] const std::vector<TextureView>& textures() const { return textures_; }

 private:
  void load(TextureView& texture) {
    for (int number = 0; number < texture.level_count; ++number) {
      TextureView::Level& level = texture.levels[static_cast<size_t>(number)];
      const size_t row_bytes = static_cast<size_t>(level.width) * texture.pixel_bytes;
      std::vector<std::byte>& texels = levels_.emplace_back(row_bytes * static_cast<size_t>(level.height));
      std::array<std::byte, 4 * 16> square; // of four texels
      for (int y = 0; y < level.height; y += 2)
        for (int x = 0; x < level.width; x += 2) {
          const std::array<int, 2> columns{x, std::min(x + 1, level.width - 1)};
          const std::array<int, 2> rows{y, std::min(y + 1, level.height - 1)};
          texture.fetch(number, columns, rows, square.data());
          for (size_t i = 0; i < 4; ++i)
            std::copy_n(square.begin() + static_cast<ptrdiff_t>(i * texture.pixel_bytes), texture.pixel_bytes,
                        texels.begin() +
                            static_cast<ptrdiff_t>(static_cast<size_t>(rows[i / 2]) * row_bytes +
                                                   static_cast<size_t>(columns[i % 2]) * texture.pixel_bytes));
        }
      level.pixels = texels.data();
    }
    texture.pages = nullptr;
  }

  std::vector<TextureView> textures_;
  std::vector<std::vector<std::byte>> levels_;
};

// Returns where a member of `whole` is, from its beginning.
template <typename Member>
size_t offset_of(const DeviceScene& whole, const Member& member) {
  return static_cast<size_t>(reinterpret_cast<const std::byte*>(&member) - reinterpret_cast<const std::byte*>(&whole));
}

void place(const DeviceSceneInput& input, Arena& arena) {
  const size_t offset = arena.reserve(sizeof(DeviceScene));
  const auto tables = accel::view_of(*input.world.probed);
  assert(tables != nullptr && offset == 0);
  const PathStages& stages = input.stages;
  DeviceScene scene{.tree = tables->view(),
                    .world = input.world,
                    .camera = input.camera,
                    .patches = stages.patches != nullptr ? *stages.patches : BrightPatches{},
                    .light_probabilities =
                        stages.light_probabilities != nullptr ? *stages.light_probabilities : LightSelectionTreeView{},
                    .stages = stages,
                    .shader = input.shader,
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

  scene.first_hit.world = on_device(scene.world);
  scene.first_hit.camera = on_device(scene.camera);

  scene.shader.world = on_device(scene.world);
  scene.shader.camera = on_device(scene.camera);
  scene.shader.lights.lights = on_device(scene.world.lights);
  scene.shader.cache = nullptr;

  const LoadedPages pages(input.world.textures);
  scene.world.textures = pages.textures();
  arena.place(scene.world.textures);
  std::vector<Emission> emissions(input.world.lights.emissions.begin(), input.world.lights.emissions.end());
  for (Emission& emission : emissions)
    if (emission.texture != nullptr)
      emission.texture = scene.world.textures.data() + (emission.texture - input.world.textures.data());
  scene.world.lights.emissions = emissions;
  arena.place(scene.world.lights.emissions);
  const std::span<const TextureView> textures = scene.world.textures;
  const std::span<const Emission> placed_emissions = scene.world.lights.emissions;
  scene.world.procedurals.images = {};
  scene.world.textures = {};
  scene.world.lights.emissions = {};
  arena.place_arrays(scene.world);
  scene.world.textures = scene.world.procedurals.images = textures;
  scene.world.lights.emissions = placed_emissions;
  arena.place_arrays(scene.tree);
  arena.place_arrays(scene.camera);
  arena.place_arrays(scene.light_probabilities);
  arena.place_arrays(scene.shader.lights);
  arena.write(offset, std::as_bytes(std::span(&scene, 1)));
}

size_t device_bytes(const DeviceSceneInput& input) {
  Arena counter;
  place(input, counter);
  return counter.bytes();
}

} // namespace

Result<void> check_device_scene(const World& world) {
  if (accel::view_of(*world.probed) == nullptr)
    return usage_error("a device renders with the kd-tree alone; use --accel kdtree");
  return {};
}

SceneOnDevice::SceneOnDevice(Device& device, const DeviceSceneInput& input) : memory_(device, device_bytes(input)) {
  Arena arena(device, memory_.data());
  place(input, arena);
  assert(arena.bytes() == memory_.size());
}

} // namespace kindling
