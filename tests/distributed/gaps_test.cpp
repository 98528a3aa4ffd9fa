// Gaps in a coverage are found, counted and described.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/gaps.h"

#include "renderer/distributed/work_parts.h"
#include "renderer/session/tile_scheduler.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

constexpr uint32_t kSamples = 64;
const PixelRect kCrop{V2i(0, 0), V2i(64, 48)};

void add(Coverage& coverage, const PixelRect& region, const SampleRange& span) {
  for (const PixelRect& block : make_blocks(region)) EXPECT_TRUE(coverage.add(coverage.index_of(block.min), span));
}

using Lines = std::vector<std::string>;

TEST(Gaps, NoneInCompleteCoverage) {
  Coverage coverage(kCrop);
  add(coverage, kCrop, {0, kSamples});
  const Gaps gaps = find_gaps(coverage, kCrop, kSamples, {});
  EXPECT_TRUE(gaps.none());
  EXPECT_EQ(gaps.lines, Lines{});
}

TEST(Gaps, GapOfAllPixelsIsOneLine) {
  Coverage coverage(kCrop);
  add(coverage, kCrop, {0, 21});
  add(coverage, kCrop, {42, kSamples});
  const Gaps gaps = find_gaps(coverage, kCrop, kSamples, {});
  EXPECT_EQ(gaps.lines, Lines{"samples 21-41 of all pixels"});
  EXPECT_EQ(gaps.missing_samples, 21U * 64 * 48);
  EXPECT_EQ(gaps.empty_pixels, 0U);
  EXPECT_EQ(find_gaps(coverage, kCrop, kSamples, {3, 0}).lines, Lines{"part 2/3: samples 21-41 of all pixels"});
  // Gaps that are not whole parts have no names.
  EXPECT_EQ(find_gaps(coverage, kCrop, kSamples, {4, 0}).lines, Lines{"samples 21-41 of all pixels"});
}

TEST(Gaps, SeveralPartsShareALine) {
  Coverage coverage(kCrop);
  add(coverage, kCrop, {0, 8});
  add(coverage, kCrop, {24, 56});
  EXPECT_EQ(find_gaps(coverage, kCrop, kSamples, {8, 0}).lines,
            Lines{"parts 2-3/8 and 8/8: samples 8-23 and 56-63 of all pixels"});
}

TEST(Gaps, EveryPartIsNamed) {
  for (const uint32_t count : {2U, 3U, 7U, 13U, 64U})
    for (uint32_t k = 1; k <= count; ++k) {
      Coverage coverage(kCrop);
      for (uint32_t other = 1; other <= count; ++other)
        if (other != k) add(coverage, kCrop, part_samples(kSamples, {other, count}).value());
      const Lines lines = find_gaps(coverage, kCrop, kSamples, {count, 0}).lines;
      ASSERT_EQ(lines.size(), 1U);
      EXPECT_TRUE(lines[0].starts_with("part " + part_number_text({k, count}) + ": ")) << lines[0];
    }
}

TEST(Gaps, TilePartsAreNamed) {
  Coverage coverage(kCrop);
  const std::vector<PixelRect> regions = make_regions(kCrop, 4);
  add(coverage, regions[0], {0, kSamples});
  add(coverage, regions[3], {0, kSamples});
  const Gaps named = find_gaps(coverage, kCrop, kSamples, {0, 4});
  EXPECT_EQ(named.lines, (Lines{"tile part 2/4: all samples of pixels 0,24 to 32,48",
                                "tile part 3/4: all samples of pixels 32,0 to 64,24"}));
  EXPECT_EQ(named.empty_pixels, 2U * 32 * 24);
  EXPECT_EQ(named.missing_samples, 64U * named.empty_pixels);
  EXPECT_EQ(find_gaps(coverage, kCrop, kSamples, {}).lines.size(), 2U);
}

TEST(Gaps, BothKindsOfPartsTogether) {
  Coverage coverage(kCrop);
  const std::vector<PixelRect> regions = make_regions(kCrop, 2);
  add(coverage, regions[0], {0, kSamples});
  add(coverage, regions[1], {0, 32});
  EXPECT_EQ(find_gaps(coverage, kCrop, kSamples, {2, 2}).lines,
            Lines{"tile part 2/2: part 2/2: samples 32-63 of pixels 32,0 to 64,48"});
}

// The crop is not aligned to blocks, within an area of whole blocks as for adaptive sampling.
TEST(Gaps, CountsOnlyPixelsOfTheCrop) {
  const PixelRect crop{V2i(5, 3), V2i(21, 13)};
  Coverage coverage(PixelRect{V2i(0, 0), V2i(24, 16)});
  Gaps gaps = find_gaps(coverage, crop, 2, {});
  EXPECT_EQ(gaps.lines, Lines{"all samples of all pixels"});
  EXPECT_EQ(gaps.empty_pixels, 160U);
  EXPECT_EQ(gaps.missing_samples, 320U);
  EXPECT_TRUE(coverage.add(0, {0, 2}));
  coverage.set_stopped(1); // has all that it needs
  gaps = find_gaps(coverage, crop, 2, {});
  EXPECT_EQ(gaps.lines, (Lines{"all samples of pixels 16,3 to 21,13", "all samples of pixels 5,8 to 16,13"}));
}

TEST(Gaps, ListIsBounded) {
  Coverage coverage(PixelRect{V2i(0, 0), V2i(160, 80)});
  for (size_t i = 0; i < coverage.block_count(); ++i) { // a chess board
    if ((i / 20 + i) % 2 == 0) {
      EXPECT_TRUE(coverage.add(i, {0, kSamples}));
    }
  }
  const Gaps gaps = find_gaps(coverage, coverage.area(), kSamples, {});
  EXPECT_LE(gaps.lines.size(), 25U);
  EXPECT_NE(gaps.lines.back().find("other places"), std::string::npos);
  EXPECT_EQ(gaps.empty_pixels, 160U * 80 / 2);
}

} // namespace
} // namespace kindling::test
