// Tests that directions sampled from patches match their stated density.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/bright_patches.h"

#include "renderer/guiding/guide_record.h"
#include "renderer/sampling/warp.h"
#include "tests/guiding/cell_counts.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Random;

// On the walls of a room of 2 x 2 x 2 around the origin, facing inwards; two overlap as seen from
// some points, one faces outwards.
std::vector<BrightPatch> room_patches() {
  return {
      {V3f(0.3f, 1.0f, -0.2f), V3f(0.5f, 0.0f, 0.05f), 3, 40.0f},
      {V3f(-1.0f, 0.2f, 0.1f), V3f(0.0f, 0.3f, 0.6f), 0, 3.0f},
      {V3f(-0.7f, 0.2f, 0.1f), V3f(0.0f, 0.2f, 0.2f), 0, 5.0f},
      {V3f(1.0f, -0.5f, 0.0f), V3f(0.0f, 0.08f, 0.9f), 1, 30.0f},
      {V3f(0.0f, -1.0f, 0.0f), V3f(0.3f, 0.0f, 0.3f), 2, 2.0f},
      {V3f(0.0f, 0.0f, 1.0f), V3f(0.4f, 0.4f, 0.0f), 4, 9.0f},
      {V3f(0.2f, 0.1f, 1.0f), V3f(0.4f, 0.4f, 0.0f), 5, 1.0f},
      {V3f(0.1f, 0.0f, -1.0f), V3f(0.1f, 0.3f, 0.0f), 4, 12.0f},
      {V3f(-0.4f, 1.0f, 0.5f), V3f(0.08f, 0.0f, 0.4f), 3, 25.0f},
  };
}

struct Place {
  V3f position, normal;
};
const Place kPlaces[] = {{V3f(0.0f, -0.9f, 0.0f), V3f(0, 1, 0)},
                         {V3f(-0.2f, 0.3f, -0.4f), V3f(0.6f, 0.0f, 0.8f)},
                         {V3f(0.9f, 0.1f, 0.2f), V3f(-1, 0, 0)},
                         {V3f(0.3f, 0.5f, -0.5f), V3f(0, 0.6f, 0.8f)}};

TEST(Facing, IsNearestHalfAxis) {
  EXPECT_EQ(facing_of(V3f(1, 0, 0)), 0U);
  EXPECT_EQ(facing_of(V3f(-0.8f, 0.6f, 0)), 1U);
  EXPECT_EQ(facing_of(V3f(0.1f, 0.9f, 0.2f)), 2U);
  EXPECT_EQ(facing_of(V3f(0.1f, -0.9f, 0.2f)), 3U);
  EXPECT_EQ(facing_of(V3f(0, 0.1f, 0.5f)), 4U);
  EXPECT_EQ(facing_of(V3f(0, 0.1f, -0.5f)), 5U);
}

TEST(BrightPatches, ChancesFollowFormFactors) {
  const BrightPatches patches(room_patches());
  for (const Place& place : kPlaces) {
    BrightPatches::Chances chances;
    patches.chances(place.position, place.normal, chances);
    EXPECT_GT(chances.sum, 0.01f);
    EXPECT_LE(chances.sum, 1.0f - BrightPatches::kMinRest + 1e-6f);
    float sum = 0.0f;
    for (size_t j = 0; j < patches.patches().size(); ++j) {
      const BrightPatch& patch = patches.patches()[j];
      sum += chances.of[j];
      const V3f to_patch = patch.center - place.position;
      const auto axis = static_cast<int>(patch.facing / 2);
      const bool faces = (patch.facing % 2 == 0 ? -to_patch[axis] : to_patch[axis]) > 0.0f;
      EXPECT_EQ(chances.of[j] > 0.0f, faces && to_patch.dot(place.normal) > 0.0f) << j;
    }
    EXPECT_NEAR(sum, chances.sum, 1e-5f);
  }
  // A large bright ceiling leaves the minimum rest.
  const BrightPatch ceiling{V3f(0, 1, 0), V3f(5, 0, 5), 3, 1e6f};
  BrightPatches::Chances chances;
  BrightPatches(std::span(&ceiling, 1)).chances(V3f(0.0f), V3f(0, 1, 0), chances);
  EXPECT_NEAR(chances.sum, 1.0f - BrightPatches::kMinRest, 1e-5f);
  // Seen from behind, or without patches, there is no target.
  BrightPatches(std::span(&ceiling, 1)).chances(V3f(0, 2, 0), V3f(0, -1, 0), chances);
  EXPECT_EQ(chances.sum, 0.0f);
  BrightPatches().chances(V3f(0.0f), V3f(0, 1, 0), chances);
  EXPECT_EQ(chances.sum, 0.0f);
}

// Counts directions in cells of z and azimuth. The expectation integrates one random point in each
// of a million small cells: the density jumps at the edges of patches, where quadrature has no
// order.
TEST(BrightPatches, SamplingMatchesPdf) {
  const BrightPatches patches(room_patches());
  constexpr size_t kRows = 8, kColumns = 16, kFine = 128;
  constexpr int kSamples = 40000;
  constexpr double kCellSize = 4.0 * std::numbers::pi / (kRows * kFine * kColumns * kFine);
  uint64_t seed = 0;
  for (const Place& place : kPlaces) {
    BrightPatches::Chances chances;
    patches.chances(place.position, place.normal, chances);
    Random random(++seed);
    std::vector<double> expected(kRows * kColumns), observed(kRows * kColumns);
    double integral = 0.0;
    for (size_t row = 0; row < kRows * kFine; ++row)
      for (size_t column = 0; column < kColumns * kFine; ++column) {
        const double z = 1.0 - 2.0 * (static_cast<double>(row) + random.next_double()) / (kRows * kFine);
        const double phi =
            2.0 * std::numbers::pi * (static_cast<double>(column) + random.next_double()) / (kColumns * kFine);
        const double r = std::sqrt(1.0 - z * z);
        const V3f w(static_cast<float>(r * std::cos(phi)), static_cast<float>(r * std::sin(phi)),
                    static_cast<float>(z));
        const double mass = static_cast<double>(patches.density(chances, place.position, w) / chances.sum) * kCellSize;
        expected[row / kFine * kColumns + column / kFine] += mass * kSamples;
        integral += mass;
      }
    // Half of the points in the 10,000 or so small cells on an edge are on the wrong side, at
    // random.
    EXPECT_NEAR(integral, 1.0, 5e-3) << place.position;
    for (int i = 0; i < kSamples; ++i) {
      const float u_patch = random.next_1d();
      const std::optional<V3f> w = patches.sample(chances, place.position, u_patch, random.next_2d());
      ASSERT_TRUE(w);
      double turns = std::atan2(static_cast<double>(w->y), static_cast<double>(w->x)) / (2.0 * std::numbers::pi);
      turns -= std::floor(turns);
      const auto row = static_cast<size_t>(std::min(0.5 * (1.0 - static_cast<double>(w->z)) * kRows, kRows - 1.0));
      const auto column = static_cast<size_t>(std::min(turns * kColumns, kColumns - 1.0));
      observed[row * kColumns + column] += 1.0;
    }
    test::expect_counts(observed, expected, 4, testing::PrintToString(place.position));
  }
}

// Every sampled direction has a positive density, except for those that rounding moves over an
// edge.
TEST(BrightPatches, SamplesHavePositiveDensity) {
  const BrightPatches patches(room_patches());
  Random random(9);
  int without = 0;
  for (int i = 0; i < 100000; ++i) {
    const Place& place = kPlaces[i % 4];
    BrightPatches::Chances chances;
    patches.chances(place.position, place.normal, chances);
    const float u_patch = random.next_1d();
    const std::optional<V3f> w = patches.sample(chances, place.position, u_patch, random.next_2d());
    ASSERT_TRUE(w);
    if (!(patches.density(chances, place.position, *w) > 0.0f)) ++without;
  }
  EXPECT_LT(without, 10);
}

} // namespace
} // namespace kindling
