// Plans of tiles: the texels that are in tiles, and look-ups that find each of them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/host_device.h"
#include "renderer/device/tile_pager.h"
#include "tests/device/textured_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

const ShadingMaterial& material_with(const World& world, AlphaMode mode) {
  return *std::ranges::find(world.materials, mode, &ShadingMaterial::alpha_mode);
}

TEST(TilePlan, LevelsThatRaysAndLightSamplesReadStayInMemory) {
  const std::unique_ptr<const World> world = textured_world();
  const TilePlan plan = plan_tiles(*world);
  const auto in_tiles = [&](const TextureBinding& binding, int level) {
    return plan.in_tiles(static_cast<size_t>(binding.texture), level);
  };
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    EXPECT_FALSE(in_tiles(material_with(*world, mode).base_color, 0));
    EXPECT_TRUE(in_tiles(material_with(*world, mode).base_color, 1));
  }
  size_t walls = 0;
  for (const ShadingMaterial& material : world->materials) {
    const bool is_floor = material.layers != kNone && !material.thin_wall;
    if (is_floor) {
      EXPECT_TRUE(in_tiles(material.base_color, 0));
      EXPECT_TRUE(in_tiles(material.metallic_roughness, 0));
    }
    if (!material.thin_wall) continue;
    ++walls;
    EXPECT_FALSE(in_tiles(material.base_color, 0));
    EXPECT_FALSE(in_tiles(material.metallic_roughness, 0));
    EXPECT_FALSE(in_tiles(world->layer_materials[static_cast<size_t>(material.layers)].transmission, 0));
  }
  EXPECT_EQ(walls, 1U);
  size_t lamps = 0;
  for (const Emission& emission : world->lights.emissions) {
    if (emission.texture == nullptr) continue;
    ++lamps;
    EXPECT_FALSE(plan.in_tiles(static_cast<size_t>(emission.texture - world->textures.data()), 0));
  }
  EXPECT_EQ(lamps, 1U);
}

// Both look-ups read level 0 of one image, with the levels of two kinds of content.
TEST(TilePlan, TheSameTexelsHaveTheSameTiles) {
  const auto image = noisy_image(256, 256, 3);
  Material both;
  both.base_color_texture.texture = both.metallic_roughness_texture.texture = both.specular_texture.texture = 0;
  Scene scene = make_scene({both}, {quad(V3f(0.0f), V3f(1, 0, 0), V3f(0, 1, 0), 0)});
  scene.textures.push_back({.image = image});
  const std::unique_ptr<const World> world = make_world(std::move(scene), accel::Kind::kdtree);
  const TilePlan plan = plan_tiles(*world);
  ASSERT_EQ(world->textures.size(), 2U); // as color and as data
  EXPECT_EQ(plan.textures[0].levels[0].first_tile, plan.textures[1].levels[0].first_tile);
  EXPECT_NE(plan.textures[0].levels[1].first_tile, plan.textures[1].levels[1].first_tile);
  // 256 x 256 texels are 4 x 4 tiles of 64 x 85, level 1 is 2 x 2, level 2 one, all others one.
  EXPECT_EQ(plan.tile_count(), 16U + 2U * (4 + 1));
  EXPECT_EQ(plan.textures[0].levels[3].first_tile, plan.textures[0].levels[8].first_tile);
  EXPECT_EQ(plan.tiles_of_surface, 12U); // three look-ups of four tiles
}

TEST(TilePlan, SmallTexturesHaveOneTileForAllLevels) {
  Material material;
  material.base_color_texture.texture = 0;
  Scene scene = make_scene({material}, {quad(V3f(0.0f), V3f(1, 0, 0), V3f(0, 1, 0), 0)});
  scene.textures.push_back({.image = noisy_image(60, 50, 4)});
  const TilePlan plan = plan_tiles(*make_world(std::move(scene), accel::Kind::kdtree));
  EXPECT_EQ(plan.tile_count(), 1U);
  EXPECT_EQ(plan.tiles_of_surface, 1U);
}

// A texture for each layout of texels, with all tiles loaded.
TEST(TilePlan, LookUpsHaveTheBitsOfTexelsInMemory) {
  std::mt19937 random(7);
  Material material;
  Scene scene;
  for (const PixelType type : {PixelType::u8, PixelType::u16, PixelType::f16, PixelType::f32})
    for (int channels = 1; channels <= 4; ++channels) {
      auto image = std::make_shared<Image>(*noisy_image(150 + channels, 211 - channels, channels, type));
      for (std::byte& byte : image->pixels) byte &= std::byte{0x3b}; // finite numbers
      material.base_color_texture.texture = static_cast<int>(scene.textures.size());
      const auto wrap = static_cast<TextureWrap>(channels % 3);
      scene.textures.push_back({.image = std::move(image),
                                .wrap_u = wrap,
                                .wrap_v = TextureWrap::repeat,
                                .filter = channels == 2 ? TextureFilter::nearest : TextureFilter::linear});
      scene.materials.push_back(material);
    }
  std::vector<Primitive> quads;
  for (size_t i = 0; i < scene.materials.size(); ++i)
    quads.push_back(quad(V3f(static_cast<float>(i)), V3f(1, 0, 0), V3f(0, 1, 0), static_cast<int>(i)));
  Scene shown = make_scene(scene.materials, std::move(quads));
  shown.textures = scene.textures;
  const std::unique_ptr<const World> world = make_world(std::move(shown), accel::Kind::kdtree);
  const TilePlan plan = plan_tiles(*world);
  const std::unique_ptr<Device> device = make_host_device(1);
  TilePager pager(*device, world->textures, plan, plan.tile_count(), 1);
  std::vector<uint32_t> all(plan.tile_count());
  WaveTiles wave;
  bool asked = false; // for every tile
  pager.run(
      wave, 1,
      [&](uint32_t /*count*/) {
        wave.pool->begin();
        for (uint32_t tile = 0; tile < plan.tile_count(); ++tile) static_cast<void>(wave.pool->find(tile));
        if (!asked) wave.waiting[(*wave.waiting_count)++] = 0;
        asked = true;
      },
      [] { return false; });
  ASSERT_EQ(pager.statistics().loaded, plan.tile_count());
  for (size_t t = 0; t < world->textures.size(); ++t) {
    const TextureView& in_memory = world->textures[t];
    TextureView in_tiles = in_memory;
    in_tiles.tiles = pager.tiles_on_device() + t;
    for (int level = 0; level < in_tiles.level_count; ++level)
      if (plan.in_tiles(t, level)) in_tiles.levels[static_cast<size_t>(level)].pixels = nullptr;
    for (int i = 0; i < 2000; ++i) {
      const auto coordinate = [&] { return static_cast<float>(random() % 40000) * 1e-4f - 2.0f; };
      const V2f uv(coordinate(), coordinate());
      const int level = i % in_memory.level_count, channel = i % 4;
      ASSERT_EQ(in_tiles.sample(uv, level), in_memory.sample(uv, level)) << "texture " << t << ", level " << level;
      ASSERT_EQ(in_tiles.sample_channel(uv, channel, level), in_memory.sample_channel(uv, channel, level));
    }
  }
}

} // namespace
} // namespace kindling::test
