// Tests of guides learned from synthetic records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/learn_guide.h"

#include "renderer/base/frame.h"
#include "renderer/sampling/warp.h"
#include "tests/guiding/on_any_threads.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Random;

// From the floor of a room of 4 x 2 x 4 to its ceiling, which is bright in a strip at x from 1 to
// 1.1, and dim elsewhere. The walls are equally dim. Directions are cosine-distributed.
std::vector<GuideRecord> room_records(int count, uint64_t seed, float strip_radiance) {
  Random random(seed);
  std::vector<GuideRecord> records;
  while (static_cast<int>(records.size()) < count) {
    GuideRecord record;
    record.position = V3f{4.0f * random.next_1d() - 2.0f, 0.0f, 4.0f * random.next_1d() - 2.0f};
    record.normal = V3f(0, 1, 0);
    const V3f wi = Frame::around(record.normal).to_world(sample_cosine_hemisphere(random.next_2d()));
    if (wi.y < 0.001f) continue;
    // The ceiling, or the wall that is hit first.
    float distance = 2.0f / wi.y;
    record.hit_facing = 3;
    for (const int axis : {0, 2}) {
      const float to_wall = ((wi[axis] > 0.0f ? 2.0f : -2.0f) - record.position[axis]) / wi[axis];
      if (to_wall >= distance) continue;
      distance = to_wall;
      record.hit_facing = 2 * static_cast<uint32_t>(axis) + (wi[axis] > 0.0f ? 1 : 0);
    }
    record.hit = record.position + wi * distance;
    const bool bright = record.hit_facing == 3 && record.hit.x > 1.0f && record.hit.x < 1.1f;
    record.contribution2 = square(bright ? strip_radiance : 0.1f + 0.1f * random.next_1d());
    const float pdf = wi.y * kInvPi;
    record.replaced = 1.0f;
    record.allowed = 1.0f / pdf;
    records.push_back(record);
  }
  return records;
}

TEST(LearnGuide, FindsBrightStrip) {
  const LearnedGuide learned = learn_guide(room_records(20000, 1, 5.0f), {});
  EXPECT_LT(learned.second_moment, 0.5);
  // From the middle of the floor most guided directions lead into the strip.
  const BrightPatches& patches = learned.guide.patches;
  BrightPatches::Chances chances;
  patches.chances(V3f(0.0f), V3f(0, 1, 0), chances);
  EXPECT_GT(chances.sum, 0.15f);
  Random random(2);
  int inside = 0;
  for (int i = 0; i < 1000; ++i) {
    const float u_patch = random.next_1d();
    const std::optional<V3f> wi = patches.sample(chances, V3f(0.0f), u_patch, random.next_2d());
    ASSERT_TRUE(wi);
    const float x = wi->x * 2.0f / wi->y;
    inside += x > 0.98f && x < 1.12f ? 1 : 0;
  }
  EXPECT_GT(inside, 800);
}

TEST(LearnGuide, PredictedGainHoldsForOtherRecords) {
  const LearnedGuide learned = learn_guide(room_records(100000, 3, 5.0f), {});
  const std::vector<GuideRecord> others = room_records(100000, 4, 5.0f);
  EXPECT_NEAR(second_moment(others, learned.guide.patches), learned.second_moment, 0.05);
}

TEST(LearnGuide, PredictsNoGainWithoutBrightRegions) {
  const LearnedGuide learned = learn_guide(room_records(20000, 5, 0.15f), {});
  EXPECT_GT(learned.second_moment, 0.97);
}

// Hits on the six sides of a cube of 10 m: most on squares of 1 m, five to a side. One on the last
// side measures 2 m and is as bright as all others together.
std::vector<GuideRecord> hits_on_squares(int count, uint64_t seed) {
  Random random(seed);
  std::vector<GuideRecord> records(static_cast<size_t>(count));
  for (size_t i = 0; i < records.size(); ++i) {
    GuideRecord& record = records[i];
    record.hit_facing = static_cast<uint32_t>(i % kFacings);
    const auto axis = static_cast<int>(record.hit_facing / 2);
    const auto square_number = std::floor(6.0f * random.next_1d());
    const bool large = record.hit_facing == 5 && square_number == 0.0f;
    V2f place{10.0f * random.next_1d() - 5.0f, 10.0f * random.next_1d() - 5.0f}; // number 5: anywhere
    if (square_number < 5.0f) {
      const float size = large ? 2.0f : 1.0f;
      place = {2.0f * square_number - 4.5f + size * random.next_1d(), size * random.next_1d()};
    }
    record.hit[axis] = record.hit_facing % 2 == 0 ? -5.0f : 5.0f;
    record.hit[(axis + 1) % 3] = place.x;
    record.hit[(axis + 2) % 3] = place.y;
    record.contribution2 = square_number == 5.0f ? 0.01f : large ? 30.0f : 1.0f;
  }
  return records;
}

// There are more squares than there may be patches. The brightest has patches, and so has every
// side, although most of it is dim. No patch is inside of another.
TEST(FindPatches, ChoosesTheBestClusters) {
  std::vector<GuideRecord> records = hits_on_squares(36000, 8);
  const std::vector<BrightPatch> patches = find_patches(records, {PatchSearch::Splits::spread, 0.6});
  EXPECT_EQ(patches.size(), BrightPatches::kMax);
  std::array<bool, kFacings> sides{};
  bool found = false;
  for (const BrightPatch& patch : patches) {
    sides[patch.facing] = true;
    found |= patch.facing == 5 && (patch.center - V3f(-3.5f, 1.0f, 5.0f)).length() < 0.2f;
    for (const BrightPatch& other : patches) {
      const V3f between = patch.center - other.center;
      bool inside = &other != &patch && other.facing == patch.facing;
      for (int k = 0; k < 3; ++k) inside &= std::fabs(between[k]) <= other.half_size[k];
      EXPECT_FALSE(inside) << patch.center << " in " << other.center;
    }
  }
  EXPECT_TRUE(found);
  EXPECT_EQ(std::count(sides.begin(), sides.end(), true), kFacings);
}

// With less gain to expect, a patch must be brighter to be worth its directions.
TEST(FindPatches, ExpectationsSetThePrice) {
  std::vector<GuideRecord> records = hits_on_squares(36000, 9);
  const auto area_of = [&](double expected_moment) {
    double area = 0.0;
    for (const BrightPatch& patch : find_patches(records, {PatchSearch::Splits::spread, expected_moment})) {
      const V3f size = patch.half_size * 2.0f;
      area += static_cast<double>(size.x * size.y + size.y * size.z + size.z * size.x);
    }
    return area;
  };
  EXPECT_GT(area_of(0.05), 1.2 * area_of(20.0));
}

// The strengths are a minimum: no change of a single one lowers the second moment of the fitted
// records.
TEST(LearnGuide, StrengthsAreAMinimum) {
  std::vector<GuideRecord> records = room_records(5000, 6, 5.0f);
  std::vector<BrightPatch> patches = find_patches(records, {});
  ASSERT_FALSE(patches.empty());
  const BrightPatches fitted = fit_strengths(records, patches);
  const double best = second_moment(records, fitted);
  for (size_t j = 0; j < fitted.patches().size(); ++j)
    for (const float factor : {0.8f, 1.25f}) {
      std::vector<BrightPatch> changed(fitted.patches().begin(), fitted.patches().end());
      changed[j].strength *= factor;
      EXPECT_GT(second_moment(records, BrightPatches(changed)), best * 0.998) << j << " times " << factor;
    }
}

TEST(LearnGuide, IsIndependentOfThreadCount) {
  EXPECT_FALSE(test::learn_on_any_threads(room_records(100000, 7, 3.0f)).guide.patches.empty());
}

TEST(LearnGuide, HandlesEmptyAndDegenerateRecords) {
  EXPECT_TRUE(learn_guide({}, {}).guide.patches.empty());
  EXPECT_EQ(learn_guide({}, {}).second_moment, 1.0);
  // All hits in one place: no split can separate them, and no rectangle around them is flat.
  GuideRecord record;
  record.normal = V3f(0, 1, 0);
  record.hit = V3f(1, 1, 1);
  record.contribution2 = record.replaced = record.allowed = 1.0f;
  const std::vector<GuideRecord> same(5000, record);
  const LearnedGuide learned = learn_guide(same, {});
  EXPECT_TRUE(std::isfinite(learned.second_moment));
  for (const BrightPatch& patch : learned.guide.patches.patches()) EXPECT_TRUE(std::isfinite(patch.strength));
}

} // namespace
} // namespace kindling
