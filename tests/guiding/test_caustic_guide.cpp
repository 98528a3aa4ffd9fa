// Tests of learned directions of caustics: regions, sampling, densities, and the predicted gain.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/caustic_guide.h"

#include "tests/guiding/cell_counts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace kindling {
namespace {

using test::Random;

constexpr float kLensHeight = 0.5f;
const V3f kUp(0, 0, 1);

// A floor of 1 m, twice as bright on the right half, under a lens at z = 0.5 that every place sees
// in another spot.
std::vector<CausticRecord> lens_over_floor(int count, uint64_t seed) {
  Random random(seed);
  std::vector<CausticRecord> records;
  for (int i = 0; i < count; ++i) {
    const V2f at = random.next_2d();
    const V3f origin(0.5f + 0.3f * (at.x - 0.5f), 0.5f + 0.3f * (at.y - 0.5f), kLensHeight);
    records.push_back({V3f(at.x, at.y, 0.0f), origin, at.x > 0.5f ? 2.0f : 1.0f});
  }
  return records;
}

CausticGuideView::Chances chances_at(const CausticGuide& guide, const V3f& position, const V3f& normal = kUp) {
  CausticGuideView::Chances chances;
  const CausticGuideView::Region* const region = guide.find(position);
  EXPECT_NE(region, nullptr) << position;
  if (region != nullptr) guide.find_chances(*region, position, normal, 0.5f, chances);
  return chances;
}

TEST(CausticGuide, HasRegionsOnlyWhereLightArrives) {
  std::vector<CausticRecord> records = lens_over_floor(5000, 1);
  const CausticGuide guide(records, 5000, 1.0f);
  ASSERT_FALSE(guide.empty());
  for (const CausticRecord& record : records) ASSERT_NE(guide.find(record.position), nullptr) << record.position;
  EXPECT_EQ(guide.find(V3f(0.5f, 0.5f, 0.3f)), nullptr);
  EXPECT_EQ(guide.find(V3f(2.0f, 0.5f, 0.0f)), nullptr);
  EXPECT_EQ(guide.find(V3f(0.5f, 0.5f, kInfinity)), nullptr);
  EXPECT_TRUE(CausticGuide().empty());
  std::vector<CausticRecord> few = lens_over_floor(CausticGuide::kLobes - 1, 2);
  EXPECT_TRUE(CausticGuide(few, 100, 1.0f).empty());
}

TEST(CausticGuide, AimsAtTheLens) {
  for (const int count : {2000, 200000}) {
    std::vector<CausticRecord> records = lens_over_floor(count, 3);
    const CausticGuide guide(records, 1, 1.0f);
    Random random(4);
    int outside = 0; // between the boxes of regions
    for (int i = 0; i < 200; ++i) {
      const V2f at = random.next_2d() * 0.9f + V2f(0.05f);
      const V3f position(at.x, at.y, 0.0f);
      if (guide.find(position) == nullptr) {
        ++outside;
        continue;
      }
      const CausticGuideView::Chances chances = chances_at(guide, position);
      const V3f to_spot =
          (V3f(0.5f + 0.3f * (at.x - 0.5f), 0.5f + 0.3f * (at.y - 0.5f), kLensHeight) - position).normalized();
      // A region of n records has the side sqrt(16 / n); directions at its two ends differ by less
      // than that over the distance, and a lobe is not wider.
      const float side = std::sqrt(2.0f * 16.0f / static_cast<float>(count));
      const float u_lobe = random.next_1d();
      const V3f w = CausticGuideView::sample(chances, u_lobe, random.next_2d());
      EXPECT_LT((w - to_spot).length(), 3.0f * side / kLensHeight) << position << count;
    }
    EXPECT_LE(outside, 4);
  }
}

// Stronger caustics are sampled more often, in relation to other light.
TEST(CausticGuide, ChancesFollowIrradiance) {
  constexpr int kCount = 100000;
  for (const float other : {0.3f, 3.0f}) {
    std::vector<CausticRecord> records = lens_over_floor(kCount, 5);
    const CausticGuide guide(records, kCount, other);
    for (const float x : {0.2f, 0.8f}) {
      // The power of a record counts over its cosine, so irradiance at the floor is the cosine
      // times 1 or 2 W/m2.
      const V3f position(x, 0.5f, 0.0f), origin(0.5f + 0.3f * (x - 0.5f), 0.5f, kLensHeight);
      const float cosine = kLensHeight / (origin - position).length();
      const float irradiance = (x > 0.5f ? 2.0f : 1.0f) * cosine;
      double sum = 0.0;
      constexpr int kSpots = 64; // one region has 16 records, whose area varies
      for (int i = 0; i < kSpots; ++i)
        sum += static_cast<double>(
            chances_at(guide, position + V3f(0.0f, 0.1f * (static_cast<float>(i) / kSpots - 0.5f), 0.0f)).sum);
      EXPECT_NEAR(sum / kSpots, 0.5 * irradiance / (irradiance + other), 0.07) << x << " " << other;
    }
    // Surfaces that face away have none.
    EXPECT_EQ(chances_at(guide, V3f(0.5f, 0.5f, 0.0f), -kUp).sum, 0.0f);
  }
}

// Records at one place have no area: nothing is known of their strength.
TEST(CausticGuide, EqualRecordsAreNotSampled) {
  std::vector<CausticRecord> records(100, {V3f(1, 2, 3), V3f(1, 2, 4), 1.0f});
  const CausticGuide guide(records, 100, 1.0f);
  const CausticGuideView::Chances chances = chances_at(guide, V3f(1, 2, 3));
  EXPECT_EQ(chances.sum, 0.0f);
  EXPECT_EQ(CausticGuideView::density(chances, kUp), 0.0f);
}

// Below a sphere, many records have the height of the floor; each must be in its region.
TEST(CausticGuide, FloorsBelowOtherThingsHaveTheirRegions) {
  std::vector<CausticRecord> records = lens_over_floor(3000, 6);
  Random random(7);
  for (size_t i = 0; i < records.size(); i += 10) records[i].position.z = 2.0f + random.next_1d();
  const std::vector<CausticRecord> given = records;
  const CausticGuide guide(records, 3000, 1.0f);
  size_t missing = 0;
  for (const CausticRecord& record : given) {
    const CausticGuideView::Region* const region = guide.find(record.position);
    ASSERT_NE(region, nullptr) << record.position;
    if (std::find(region->x.begin(), region->x.end(), record.origin.x) == region->x.end()) ++missing;
  }
  EXPECT_LE(missing, given.size() / 50); // of regions with more records than lobes
}

// Counts where directions meet the plane of the lens, in cells, against the density there.
TEST(CausticGuide, SamplingMatchesDensity) {
  std::vector<CausticRecord> records = lens_over_floor(4000, 7);
  const CausticGuide guide(records, 4000, 1.0f);
  constexpr int kCells = 16, kFine = 64, kSamples = 200000;
  uint64_t seed = 10;
  for (const V3f& position : {V3f(0.5f, 0.5f, 0.0f), V3f(0.1f, 0.8f, 0.0f), V3f(0.9f, 0.3f, 0.01f)}) {
    const CausticGuideView::Chances chances = chances_at(guide, position);
    ASSERT_GT(chances.sum, 0.1f);
    // The square around the spots.
    const V2f spot(0.5f + 0.3f * (position.x - 0.5f), 0.5f + 0.3f * (position.y - 0.5f));
    constexpr float kHalf = 0.1f;
    const float height = kLensHeight - position.z;
    Random random(++seed);
    std::vector<double> expected(kCells * kCells), observed(kCells * kCells);
    double inside = 0.0;
    for (int y = 0; y < kCells * kFine; ++y)
      for (int x = 0; x < kCells * kFine; ++x) {
        const V2f within = V2f(static_cast<float>(x), static_cast<float>(y)) + random.next_2d();
        const V2f at = spot + (within * (2.0f / (kCells * kFine)) - V2f(1.0f)) * kHalf;
        const V3f to(at.x - position.x, at.y - position.y, height);
        const double distance2 = static_cast<double>(to.length2());
        const double area = square(2.0 * static_cast<double>(kHalf) / (kCells * kFine));
        const double solid_angle = area * static_cast<double>(height) / (distance2 * std::sqrt(distance2));
        const double mass =
            static_cast<double>(CausticGuideView::density(chances, to.normalized()) / chances.sum) * solid_angle;
        expected[static_cast<size_t>(y / kFine * kCells + x / kFine)] += mass * kSamples;
        inside += mass;
      }
    EXPECT_NEAR(inside, 1.0, 5e-3) << position;
    for (int i = 0; i < kSamples; ++i) {
      const float u_lobe = random.next_1d();
      const V3f w = CausticGuideView::sample(chances, u_lobe, random.next_2d());
      ASSERT_NEAR(w.length(), 1.0f, 1e-6f);
      ASSERT_GT(CausticGuideView::density(chances, w), 0.0f);
      const V2f at(position.x + w.x * height / w.z, position.y + w.y * height / w.z);
      const V2f cell = ((at - spot) * (1.0f / kHalf) + V2f(1.0f)) * (0.5f * kCells);
      ASSERT_TRUE(cell.x >= 0.0f && cell.x < kCells && cell.y >= 0.0f && cell.y < kCells) << at;
      observed[static_cast<size_t>(static_cast<int>(cell.y) * kCells + static_cast<int>(cell.x))] += 1.0;
    }
    EXPECT_GT(test::expect_counts(observed, expected, 3, testing::PrintToString(position)), 10);
  }
}

TEST(CausticGain, CountsLightThatIsFoundMoreOften) {
  std::vector<GuideRecord> records(4);
  records[0].contribution2 = 4.0f; // as before
  records[1].contribution2 = 1.0f; // 20 times as often
  records[1].without_caustics = 0.05f;
  records[2].contribution2 = 0.25f; // twice as often, which does not count
  records[2].without_caustics = 0.5f;
  records[3].contribution2 = 1.0f; // less often
  records[3].without_caustics = 1.5f;
  const CausticGain gain = caustic_gain(records, 10);
  EXPECT_NEAR(gain.share, 0.1, 1e-6);
  EXPECT_NEAR(gain.second_moment, 6.25 / (4.0 + 20.0 + 0.5 + 1.0 / 1.5), 1e-6);
  EXPECT_EQ(caustic_gain({}, 10).second_moment, 1.0);
  EXPECT_EQ(caustic_gain(records, 0).share, 0.0);
}

} // namespace
} // namespace kindling
