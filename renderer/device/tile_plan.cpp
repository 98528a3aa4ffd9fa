// Finds the levels that stay in memory, and numbers the tiles of the others.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/tile_plan.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

namespace kindling {
namespace {

// Names the texels of a level: their address, or their pages and the level.
using LevelKey = std::pair<const void*, int>;

LevelKey key_of(const TextureView& texture, int level) {
  const std::byte* const pixels = texture.levels[static_cast<size_t>(level)].pixels;
  return pixels != nullptr ? LevelKey{pixels, -1} : LevelKey{texture.pages, level};
}

size_t level_bytes(const TextureView& texture, int level) {
  const TextureView::Level& of = texture.levels[static_cast<size_t>(level)];
  return static_cast<size_t>(of.width) * static_cast<size_t>(of.height) * texture.pixel_bytes;
}

// Calls f(binding) for all images that a material reads.
template <typename F>
void for_each_image(const WorldView& world, const ShadingMaterial& material, const F& f) {
  const auto visit = [&](const TextureBinding& binding) {
    if (binding.present() && !binding.is_procedural()) f(static_cast<size_t>(binding.texture));
  };
  for (const TextureBinding* binding : {&material.base_color, &material.metallic_roughness, &material.normal,
                                        &material.emission, &material.specular, &material.specular_color})
    visit(*binding);
  if (material.layers == kNone) return;
  const LayerMaterial& layers = world.layer_materials[static_cast<size_t>(material.layers)];
  for (const TextureBinding* binding :
       {&layers.clearcoat, &layers.clearcoat_roughness, &layers.clearcoat_normal, &layers.sheen_color,
        &layers.sheen_roughness, &layers.anisotropy, &layers.iridescence, &layers.iridescence_thickness,
        &layers.transmission, &layers.diffuse_transmission, &layers.diffuse_transmission_color})
    visit(*binding);
}

// Returns the levels that rays and light samples read on their way.
std::set<LevelKey> levels_in_memory(const WorldView& world) {
  std::set<LevelKey> levels;
  const auto keep_finest = [&](size_t texture) { levels.insert(key_of(world.textures[texture], 0)); };
  for (const ShadingMaterial& material : world.materials) {
    if (material.alpha_mode != AlphaMode::opaque && material.base_color.present() &&
        !material.base_color.is_procedural())
      keep_finest(static_cast<size_t>(material.base_color.texture));
    if (material.thin_wall) for_each_image(world, material, keep_finest);
  }
  for (const Emission& emission : world.lights.emissions)
    if (emission.texture != nullptr) keep_finest(static_cast<size_t>(emission.texture - world.textures.data()));
  for (const ProceduralTextureView& procedural : world.procedurals.textures)
    for (const ProceduralInstruction& instruction : procedural.program.instructions) {
      if (instruction.op != ProceduralOp::image) continue;
      const TextureView& texture = world.textures[static_cast<size_t>(instruction.i[0])];
      for (int level = 0; level < texture.level_count; ++level) levels.insert(key_of(texture, level));
    }
  return levels;
}

// Numbers the tiles of one texture after the other.
class Tiler {
 public:
  explicit Tiler(const WorldView& world) : world_(world), in_memory_(levels_in_memory(world)) {}

  TilePlan plan() {
    for (size_t i = 0; i < world_.textures.size(); ++i) plan_.textures.push_back(tiles_of(i));
    for (const ShadingMaterial& material : world_.materials) {
      uint32_t tiles = 0;
      for_each_image(world_, material, [&](size_t texture) { tiles += std::min(tiles_at_once_[texture], 4U); });
      plan_.tiles_of_surface = std::max(plan_.tiles_of_surface, tiles);
    }
    return std::move(plan_);
  }

 private:
  // Returns the first of the levels that share a tile, which are all from it on.
  int first_shared(const TextureView& texture) const {
    size_t bytes = 0;
    int first = texture.level_count;
    while (first > 0 && !in_memory_.contains(key_of(texture, first - 1))) {
      bytes += level_bytes(texture, first - 1);
      if (bytes > kTileBytes) break;
      --first;
    }
    return first;
  }

  TextureTiles tiles_of(size_t number) {
    const TextureView& texture = world_.textures[number];
    TextureTiles tiles;
    tiles.rows = tile_rows(texture.pixel_bytes);
    tiles_at_once_.push_back(0);
    const int shared = first_shared(texture);
    for (int level = 0; level < shared; ++level)
      if (!in_memory_.contains(key_of(texture, level))) add_level(number, level, tiles);
    if (shared < texture.level_count) add_shared(number, shared, tiles);
    return tiles;
  }

  void add_level(size_t number, int level, TextureTiles& tiles) {
    const TextureView& texture = world_.textures[number];
    const TextureView::Level& of = texture.levels[static_cast<size_t>(level)];
    const int width = static_cast<int>(kTileWidth), height = static_cast<int>(tiles.rows);
    const auto columns = static_cast<uint32_t>((of.width + width - 1) / width);
    const auto rows = static_cast<uint32_t>((of.height + height - 1) / height);
    const auto [known, is_new] = first_tiles_.try_emplace({key_of(texture, level)}, plan_.tile_count());
    tiles.levels[static_cast<size_t>(level)] = {
        .first_tile = known->second, .width = static_cast<uint32_t>(of.width), .columns = columns};
    tiles_at_once_[number] = std::max(tiles_at_once_[number], columns * rows);
    if (!is_new) return;
    for (int y = 0; y < of.height; y += height)
      for (int x = 0; x < of.width; x += width)
        plan_.sources.push_back({static_cast<uint32_t>(number), static_cast<uint16_t>(level), false, x, y});
  }

  void add_shared(size_t number, int first, TextureTiles& tiles) {
    const TextureView& texture = world_.textures[number];
    std::vector<LevelKey> keys;
    for (int level = first; level < texture.level_count; ++level) keys.push_back(key_of(texture, level));
    const auto [known, is_new] = first_tiles_.try_emplace(std::move(keys), plan_.tile_count());
    uint32_t offset = 0;
    for (int level = first; level < texture.level_count; ++level) {
      tiles.levels[static_cast<size_t>(level)] = {
          .first_tile = known->second,
          .width = static_cast<uint32_t>(texture.levels[static_cast<size_t>(level)].width),
          .offset = offset};
      offset += static_cast<uint32_t>(level_bytes(texture, level));
    }
    tiles_at_once_[number] = std::max(tiles_at_once_[number], 1U);
    if (is_new) plan_.sources.push_back({static_cast<uint32_t>(number), static_cast<uint16_t>(first), true, 0, 0});
  }

  const WorldView& world_;
  std::set<LevelKey> in_memory_;
  std::map<std::vector<LevelKey>, uint32_t> first_tiles_;
  std::vector<uint32_t> tiles_at_once_; // by texture: tiles of the level that has most
  TilePlan plan_;
};

} // namespace

TilePlan plan_tiles(const WorldView& world) { return Tiler(world).plan(); }

} // namespace kindling
