// Tiles, regions, blocks and passes cover every pixel and sample once.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/tile_scheduler.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling {
namespace {

TEST(TileScheduler, TilesCoverTheCropOnce) {
  for (const PixelRect& crop :
       {PixelRect{V2i(0, 0), V2i(64, 64)}, PixelRect{V2i(3, 5), V2i(77, 41)}, PixelRect{V2i(31, 31), V2i(33, 33)}})
    for (const int side : {8, 32, 64}) {
      std::vector<int> seen(100 * 100, 0);
      for (const PixelRect& tile : make_tiles(crop, side)) {
        const std::vector<PixelRect> blocks = make_blocks(tile);
        ASSERT_EQ(count_blocks(tile), blocks.size());
        for (size_t i = 0; i < blocks.size(); ++i) {
          const PixelRect& block = blocks[i];
          ASSERT_EQ(block_of(tile, i), block);
          EXPECT_FALSE(block.empty());
          EXPECT_LE(block.width(), kBlockSize);
          EXPECT_LE(block.height(), kBlockSize);
          // Blocks lie on the image's own grid, so that groups of camera rays do not depend on
          // tiles.
          EXPECT_EQ(block.min.x / kBlockSize, (block.max.x - 1) / kBlockSize);
          EXPECT_EQ(block.min.y / kBlockSize, (block.max.y - 1) / kBlockSize);
          for (int y = block.min.y; y < block.max.y; ++y)
            for (int x = block.min.x; x < block.max.x; ++x) ++seen[static_cast<size_t>(y * 100 + x)];
        }
      }
      for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 100; ++x) {
          const bool inside = x >= crop.min.x && x < crop.max.x && y >= crop.min.y && y < crop.max.y;
          ASSERT_EQ(seen[static_cast<size_t>(y * 100 + x)], inside ? 1 : 0);
        }
    }
}

TEST(TileScheduler, RegionsCoverTheCropOnceWithSimilarAreas) {
  for (const PixelRect& crop : {PixelRect{V2i(0, 0), V2i(640, 480)}, PixelRect{V2i(3, 5), V2i(77, 41)},
                                PixelRect{V2i(31, 31), V2i(33, 33)}, PixelRect{V2i(0, 0), V2i(301, 246)}})
    for (const int workers : {1, 2, 3, 4, 7, 16, 64}) {
      const std::vector<PixelRect> regions = make_regions(crop, workers);
      ASSERT_EQ(regions.size(), static_cast<size_t>(workers));
      std::vector<int> seen(640 * 480, 0);
      for (const PixelRect& region : regions) {
        if (region.empty()) continue;
        for (const int axis : {0, 1}) { // cuts are on the grid of blocks
          EXPECT_TRUE(region.min[axis] == crop.min[axis] || region.min[axis] % kBlockSize == 0);
          EXPECT_TRUE(region.max[axis] == crop.max[axis] || region.max[axis] % kBlockSize == 0);
        }
        for (int y = region.min.y; y < region.max.y; ++y)
          for (int x = region.min.x; x < region.max.x; ++x) ++seen[static_cast<size_t>(y * 640 + x)];
      }
      for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 640; ++x) {
          const bool inside = x >= crop.min.x && x < crop.max.x && y >= crop.min.y && y < crop.max.y;
          ASSERT_EQ(seen[static_cast<size_t>(y * 640 + x)], inside ? 1 : 0) << x << ", " << y << ", " << workers;
        }
      if (crop.pixel_count() == 640 * 480) {
        for (const PixelRect& region : regions) // within a block's rounding at each of log2(workers) cuts
          EXPECT_NEAR(static_cast<double>(region.pixel_count()) * workers / (640.0 * 480.0), 1.0, 0.25) << workers;
      }
    }
}

TEST(TileScheduler, SingleBlockHasOneOwner) {
  int owners = 0;
  for (const PixelRect& region : make_regions({V2i(8, 8), V2i(16, 16)}, 5)) owners += region.empty() ? 0 : 1;
  EXPECT_EQ(owners, 1);
}

TEST(TileScheduler, PassesTakeEverySampleOnce) {
  for (const double speed : {0.0, 0.01, 3.0, 1000.0})
    for (const uint32_t total : {1U, 2U, 7U, 64U, 1000U}) {
      uint32_t done = 0;
      while (done < total) {
        const SampleRange pass = next_pass(done, total, speed);
        ASSERT_EQ(pass.first, done);
        ASSERT_GE(pass.count(), 1U);
        ASSERT_LE(done + pass.count(), total);
        done += pass.count();
      }
    }
  EXPECT_EQ(next_pass(0, 100, 0.0).count(), 1U);    // the first image comes early
  EXPECT_EQ(next_pass(50, 1000, 0.01).count(), 1U); // slow: one at a time
  EXPECT_GE(next_pass(64, 1000, 1e6).count(), 32U); // fast: long passes
}

} // namespace
} // namespace kindling
