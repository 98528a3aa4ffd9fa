// Coverage agrees with sets of sample numbers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/coverage.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace kindling {
namespace {

TEST(Coverage, BlocksLieOnImageGrid) {
  const PixelRect area{V2i(13, 9), V2i(37, 26)};
  const Coverage coverage(area);
  EXPECT_EQ(coverage.area(), area);
  ASSERT_EQ(coverage.block_count(), 4U * 3U);
  EXPECT_EQ(coverage.block(0), (PixelRect{V2i(13, 9), V2i(16, 16)}));
  EXPECT_EQ(coverage.block(5), (PixelRect{V2i(16, 16), V2i(24, 24)}));
  EXPECT_EQ(coverage.block(11), (PixelRect{V2i(32, 24), V2i(37, 26)}));
  std::vector<int64_t> pixels(coverage.block_count());
  for (int y = area.min.y; y < area.max.y; ++y)
    for (int x = area.min.x; x < area.max.x; ++x) {
      const size_t index = coverage.index_of(V2i(x, y));
      ASSERT_LT(index, coverage.block_count());
      const PixelRect block = coverage.block(index);
      EXPECT_TRUE(x >= block.min.x && x < block.max.x && y >= block.min.y && y < block.max.y);
      ++pixels[index];
    }
  for (size_t i = 0; i < pixels.size(); ++i) EXPECT_EQ(pixels[i], coverage.block(i).pixel_count());
  EXPECT_EQ(Coverage().block_count(), 0U);
}

TEST(Coverage, SpansAgreeWithSets) {
  const PixelRect block{V2i(0, 0), V2i(8, 8)};
  std::mt19937 random(1);
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  for (int round = 0; round < 200; ++round) {
    Coverage coverage(block);
    std::set<uint32_t> samples;
    for (int i = 0; i < 30; ++i) {
      const uint32_t first = below(60);
      const SampleRange span{first, first + below(9)};
      bool fits = true;
      for (uint32_t s = span.first; s < span.end; ++s) fits = fits && !samples.contains(s);
      const Coverage before = coverage;
      ASSERT_EQ(coverage.add(0, span), fits);
      if (!fits)
        EXPECT_EQ(coverage, before);
      else
        for (uint32_t s = span.first; s < span.end; ++s) samples.insert(s);

      std::set<uint32_t> found;
      uint32_t last_end = 0;
      for (const SampleRange& s : coverage[0].spans) {
        EXPECT_FALSE(s.empty());
        EXPECT_TRUE(found.empty() || s.first > last_end); // sorted, and they never touch
        last_end = s.end;
        for (uint32_t n = s.first; n < s.end; ++n) found.insert(n);
      }
      ASSERT_EQ(found, samples);

      const SampleRange wanted{below(50), 50};
      uint32_t done = 0;
      while (done < wanted.count() && samples.contains(wanted.first + done)) ++done;
      EXPECT_EQ(coverage.done(0, wanted), done);
      EXPECT_EQ(coverage.complete(0, wanted), done == wanted.count());
      const SampleRange missing = coverage.first_missing(0, wanted);
      EXPECT_EQ(missing.first, wanted.first + done);
      for (uint32_t s = missing.first; s < missing.end; ++s) EXPECT_FALSE(samples.contains(s));
      EXPECT_TRUE(missing.empty() || missing.end == wanted.end || samples.contains(missing.end));
    }
  }
}

TEST(Coverage, StoppedBlockIsComplete) {
  Coverage coverage(PixelRect{V2i(0, 0), V2i(16, 8)});
  coverage.add(1, {0, 4});
  coverage.set_stopped(1);
  EXPECT_TRUE(coverage.complete(1, {0, 100}));
  EXPECT_FALSE(coverage.complete(0, {0, 100}));
  EXPECT_EQ(coverage.done(1, {0, 100}), 4U);
}

TEST(Coverage, DoneShareCountsPixels) {
  Coverage coverage({V2i(0), V2i(12, 8)}); // blocks of 64 and of 32 pixels
  EXPECT_EQ(coverage.done_share({0, 4}), 0.0);
  EXPECT_EQ(coverage.done_share({4, 4}), 1.0); // nothing is wanted
  EXPECT_TRUE(coverage.add(0, {2, 6}));
  EXPECT_EQ(coverage.done_share({0, 4}), 64 * 2 / (96 * 4.0));
  EXPECT_TRUE(coverage.add(0, {0, 1}));
  EXPECT_EQ(coverage.done_share({0, 4}), 64 * 3 / (96 * 4.0));
  coverage.set_stopped(1); // and wants none
  EXPECT_EQ(coverage.done_share({0, 4}), (64 * 3 + 32 * 4) / (96 * 4.0));
  EXPECT_TRUE(coverage.add(0, {1, 2}));
  EXPECT_EQ(coverage.done_share({0, 4}), 1.0);
  EXPECT_EQ(Coverage({V2i(3), V2i(3)}).done_share({0, 4}), 1.0); // of no pixels
}

} // namespace
} // namespace kindling
