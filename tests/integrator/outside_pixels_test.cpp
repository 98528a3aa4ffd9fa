// The pixels outside of a crop: each belongs to one block of the crop.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/outside_pixels.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace kindling::test {
namespace {

constexpr int kSide = 8;

TEST(OutsidePixels, AreSharedOutAmongTheBlocksOfTheCrop) {
  struct Case {
    V2i size, min, end;
  };
  for (const Case& c :
       {Case{{40, 30}, {3, 2}, {38, 27}}, Case{{40, 30}, {0, 0}, {40, 30}}, Case{{40, 30}, {0, 5}, {40, 7}},
        Case{{40, 30}, {17, 0}, {18, 30}}, Case{{40, 30}, {39, 29}, {40, 30}}, Case{{9, 9}, {0, 0}, {1, 1}}}) {
    const OutsidePixels outside{c.size, c.min, c.end};
    std::vector<int> seen(static_cast<size_t>(c.size.x) * static_cast<size_t>(c.size.y));
    uint64_t next = 0, smallest = UINT64_MAX, largest = 0;
    for (int y = c.min.y / kSide; y <= (c.end.y - 1) / kSide; ++y)
      for (int x = c.min.x / kSide; x <= (c.end.x - 1) / kSide; ++x) {
        const V2i first(std::max(x * kSide, c.min.x), std::max(y * kSide, c.min.y));
        const OutsidePixels::Range share = outside.share_of(first, kSide);
        const V2i last(std::min(x * kSide + kSide, c.end.x) - 1, std::min(y * kSide + kSide, c.end.y) - 1);
        EXPECT_EQ(outside.share_of(last, kSide).first, share.first);
        EXPECT_EQ(share.first, next);
        next = share.end;
        smallest = std::min(smallest, share.count());
        largest = std::max(largest, share.count());
        for (uint64_t number = share.first; number < share.end; ++number) ++seen.at(outside.index_at(number));
      }
    EXPECT_EQ(next, outside.count());
    EXPECT_LE(largest, smallest + 1);
    for (int y = 0; y < c.size.y; ++y)
      for (int x = 0; x < c.size.x; ++x) {
        const bool inside = x >= c.min.x && y >= c.min.y && x < c.end.x && y < c.end.y;
        EXPECT_EQ(seen[static_cast<size_t>(y * c.size.x + x)], inside ? 0 : 1) << x << "," << y;
      }
  }
}

TEST(OutsidePixels, AreCountedInTheLargestImages) {
  const OutsidePixels outside{V2i(1 << 20), V2i(1 << 19, 8), V2i((1 << 19) + 1, 1 << 20)};
  const uint64_t all = outside.count();
  EXPECT_EQ(all, (uint64_t{1} << 40) - ((1 << 20) - 8));
  EXPECT_EQ(outside.index_at(all - 1), (uint64_t{1} << 40) - 1);
  const OutsidePixels::Range last = outside.share_of(V2i(1 << 19, (1 << 20) - 1), kSide);
  EXPECT_EQ(last.end, all);
  EXPECT_EQ(OutsidePixels{}.count(), 0U);
  EXPECT_EQ(OutsidePixels{}.share_of(V2i(0), kSide).count(), 0U);
}

} // namespace
} // namespace kindling::test
