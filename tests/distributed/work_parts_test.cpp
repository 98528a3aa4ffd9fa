// Division of images into parts: exact coverage, part numbers, file names, arguments.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/work_parts.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

TEST(WorkParts, PartsCoverEachSampleOnce) {
  for (const uint32_t samples : {1U, 7U, 64U, 1000U, 1U << 20})
    for (const uint32_t count : {1U, 2U, 3U, 7U}) {
      if (count > samples) continue;
      uint32_t next = 0;
      for (uint32_t k = 1; k <= count; ++k) {
        const Result<SampleRange> span = part_samples(samples, {k, count});
        ASSERT_TRUE(span.ok()) << span.error().message;
        EXPECT_EQ(span.value().first, next);
        EXPECT_FALSE(span.value().empty());
        EXPECT_LE(span.value().count(), samples / count + 1);
        next = span.value().end;
      }
      EXPECT_EQ(next, samples);
    }
}

TEST(WorkParts, RefusesMorePartsThanSamples) {
  for (uint32_t k = 1; k <= 4; ++k) {
    const Result<SampleRange> span = part_samples(3, {k, 4});
    ASSERT_FALSE(span.ok());
    EXPECT_EQ(span.error().kind, ErrorKind::usage);
    EXPECT_NE(span.error().message.find("use at most 3"), std::string::npos) << span.error().message;
  }
}

TEST(WorkParts, TilePartsCoverEachPixelOnce) {
  const PixelRect crop{V2i(5, 3), V2i(75, 50)};
  int64_t pixels = 0;
  for (uint32_t k = 1; k <= 6; ++k) {
    const Result<PixelRect> region = tile_part_region(crop, {k, 6});
    ASSERT_TRUE(region.ok()) << region.error().message;
    pixels += region.value().pixel_count();
    for (int axis = 0; axis < 2; ++axis) { // whole blocks but for the crop's border
      EXPECT_TRUE(region.value().min[axis] == crop.min[axis] || region.value().min[axis] % kBlockSize == 0);
      EXPECT_TRUE(region.value().max[axis] == crop.max[axis] || region.value().max[axis] % kBlockSize == 0);
    }
  }
  EXPECT_EQ(pixels, crop.pixel_count());
}

TEST(WorkParts, RefusesMoreTilePartsThanBlocks) {
  for (uint32_t k = 1; k <= 5; ++k) EXPECT_FALSE(tile_part_region({V2i(0, 0), V2i(16, 16)}, {k, 5}).ok());
  EXPECT_TRUE(tile_part_region({V2i(0, 0), V2i(16, 16)}, {4, 4}).ok());
}

TEST(WorkParts, NumbersRoundTrip) {
  const Result<PartNumber> part = parse_part_number("3/8");
  ASSERT_TRUE(part.ok());
  EXPECT_EQ(part.value(), (PartNumber{3, 8}));
  EXPECT_EQ(part_number_text(part.value()), "3/8");
  for (const char* text : {"", "3", "3/", "/8", "0/8", "9/8", "1/0", "3/8/9", "-1/8", "a/b", "3 /8", "1/99999999999"})
    EXPECT_FALSE(parse_part_number(text).ok()) << text;
}

TEST(WorkParts, FileNamesContainTheirParts) {
  EXPECT_EQ(part_file_name("forest", {PartNumber{3, 8}, {}}), "forest-part-3-of-8.kacc");
  EXPECT_EQ(part_file_name("forest", {{}, PartNumber{1, 4}}), "forest-tiles-1-of-4.kacc");
  EXPECT_EQ(part_file_name("forest", {PartNumber{3, 8}, PartNumber{1, 4}}), "forest-part-3-of-8-tiles-1-of-4.kacc");
}

TEST(WorkParts, ParsesPartAndWholeImageOfArguments) {
  const std::vector<std::string> arguments{
      "render",         "scene.gltf", "--part",       "3/8",    "--spp",   "64",     "--tile-part=2/4", "-o", "p.kacc",
      "--output=p.png", "-op.exr",    "--checkpoint", "p.kacc", "--stats", "p.json", "--seed",          "4"};
  EXPECT_EQ(part_of_arguments(arguments), (WorkPart{PartNumber{3, 8}, PartNumber{2, 4}}));
  EXPECT_EQ(whole_image_arguments(arguments),
            (std::vector<std::string>{"render", "scene.gltf", "--spp", "64", "--seed", "4"}));
  const std::vector<std::string> whole{"render", "a.glb", "--orbit", "1,2,3", "-q"};
  EXPECT_EQ(part_of_arguments(whole), WorkPart{});
  EXPECT_EQ(whole_image_arguments(whole), whole);
}

} // namespace
} // namespace kindling::test
