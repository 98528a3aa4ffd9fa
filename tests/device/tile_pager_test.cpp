// A pool of texture tiles: every path has its effect once, with any pool that has room for one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/host_device.h"
#include "renderer/device/kernels/wave_kernels.h"
#include "renderer/device/tile_pager.h"
#include "tests/device/textured_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

namespace kindling::test {
namespace {

// Paths that read tiles of a large texture, in a chain: which tile is next depends on the texels of
// the one before, and texels of absent tiles are zeros.
class ChainsOfTiles : public testing::Test {
 protected:
  static constexpr uint32_t kPaths = 700, kLookUps = 6;

  ChainsOfTiles() {
    Material material;
    material.base_color_texture.texture = 0;
    Scene scene = make_scene({material}, {quad(V3f(0.0f), V3f(1, 0, 0), V3f(0, 1, 0), 0)});
    scene.textures.push_back({.image = noisy_image(1024, 1024, 4)});
    world_ = make_world(std::move(scene), accel::Kind::kdtree);
    plan_ = plan_tiles(*world_);
    plan_.tiles_of_surface = kLookUps;
  }

  // Returns the sum of the texels that a path reads.
  static uint64_t follow(const TilePool& pool, uint32_t path) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < kLookUps; ++i) {
      const uint32_t key = hash_u32(path * kLookUps + i + static_cast<uint32_t>(sum));
      const std::byte* const texels = pool.find(key % 256);
      if (texels != nullptr) sum += static_cast<uint64_t>(texels[key % kTileBytes]) + 1;
    }
    return sum;
  }

  // Follows all paths with a pool; returns their sums.
  std::vector<uint64_t> follow_all(uint32_t slots, TileStatistics& statistics) {
    TilePager pager(*device_, world_->textures, plan_, slots, kPaths);
    std::vector<uint64_t> sums(kPaths, 0);
    std::vector<int> effects(kPaths, 0);
    WaveTiles wave;
    const auto launch = [&](uint32_t count) {
      std::vector<uint32_t> order(count); // as a device does
      std::iota(order.begin(), order.end(), 0U);
      std::ranges::shuffle(order, random_);
      for (const uint32_t i : order) {
        const uint32_t path = kernels::number_of(wave, i);
        kernels::begin_look_ups(wave);
        const uint64_t sum = follow(*wave.pool, path);
        if (kernels::waits_for_tiles(wave, path)) continue;
        sums[path] = sum;
        ++effects[path];
      }
    };
    for (int wave_number = 1; wave_number <= 2; ++wave_number) { // the second one finds some tiles
      pager.run(wave, kPaths, launch, [] { return false; });
      EXPECT_EQ(std::ranges::count(effects, wave_number), kPaths);
    }
    statistics = pager.statistics();
    return sums;
  }

  std::unique_ptr<const World> world_;
  TilePlan plan_;
  std::unique_ptr<Device> device_ = make_host_device(1);
  std::mt19937 random_{3};
};

TEST_F(ChainsOfTiles, AnyPoolGivesTheSameSums) {
  TileStatistics whole;
  const std::vector<uint64_t> expected = follow_all(plan_.tile_count(), whole);
  EXPECT_EQ(whole.evicted, 0U);
  EXPECT_GT(whole.loaded, 200U);
  EXPECT_LE(whole.loaded, plan_.tile_count());
  uint64_t loaded = whole.loaded;
  for (const uint32_t slots : {200U, 40U, kLookUps + 1U, kLookUps}) {
    TileStatistics statistics;
    EXPECT_EQ(follow_all(slots, statistics), expected) << slots;
    EXPECT_GT(statistics.evicted, 0U);
    EXPECT_LE(statistics.loaded - statistics.evicted, slots);
    EXPECT_GT(statistics.loaded, loaded) << "a smaller pool loads more";
    EXPECT_GT(statistics.stages_again, kPaths);
    loaded = statistics.loaded;
  }
}

TEST_F(ChainsOfTiles, APoolThatIsTooSmallIsAnErrorAndNoHang) {
  plan_.tiles_of_surface = 2; // a lie
  TileStatistics statistics;
  EXPECT_THROW(static_cast<void>(follow_all(2, statistics)), DeviceError);
}

TEST_F(ChainsOfTiles, EndsWhenAbandoned) {
  TilePager pager(*device_, world_->textures, plan_, kLookUps, 1);
  WaveTiles wave;
  int launches = 0;
  pager.run(
      wave, 1,
      [&](uint32_t /*count*/) {
        ++launches;
        wave.pool->begin();
        static_cast<void>(wave.pool->find(static_cast<uint32_t>(launches))); // another one each time
        EXPECT_TRUE(kernels::waits_for_tiles(wave, 0));
      },
      [&] { return launches == 4; });
  EXPECT_EQ(launches, 4);
}

TEST_F(ChainsOfTiles, BytesAreThoseOfTheSlots) {
  for (const uint32_t slots : {1U, 17U, 200U}) {
    const uint64_t bytes = TilePager::bytes(plan_, slots, kPaths);
    EXPECT_GT(bytes, uint64_t{slots} * kTileBytes);
    EXPECT_EQ(TilePager::slots_within(bytes, plan_, kPaths), slots);
    EXPECT_EQ(TilePager::slots_within(bytes - 1, plan_, kPaths), slots - 1);
  }
  EXPECT_EQ(TilePager::slots_within(0, plan_, kPaths), 0U);
  EXPECT_EQ(TilePager::slots_within(uint64_t{1} << 40, plan_, kPaths), plan_.tile_count());
}

} // namespace
} // namespace kindling::test
