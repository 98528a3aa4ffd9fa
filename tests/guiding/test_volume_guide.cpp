// Tests of learned directions in media: what is bright, sampling, densities.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/volume_guide.h"

#include "renderer/base/frame.h"
#include "renderer/sampling/warp.h"
#include "tests/guiding/cell_counts.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace kindling {
namespace {

using test::Random;

const V3f kBeam = V3f(0.3f, 0.8f, -0.5f).normalized();
constexpr float kBeamWidth = 0.02f; // 1 - cos: 11 degrees

V3f point_in_cube(Random& random) {
  const V2f xy = random.next_2d();
  return V3f(xy.x, xy.y, random.next_1d()) * 2.0f - V3f(1.0f);
}

// A cube of 2 m. Light comes from everywhere, and on the left half as much from a lamp.
std::vector<VolumeRecord> lamp_on_the_left(int count, uint64_t seed) {
  Random random(seed);
  std::vector<VolumeRecord> records;
  for (int i = 0; i < count; ++i) {
    const V3f position = point_in_cube(random);
    const V2f u = random.next_2d();
    const V3f direction = position.x < 0.0f && i % 2 == 0
                              ? Frame::around(kBeam).to_world(sample_uniform_cone(u, kBeamWidth))
                              : sample_uniform_sphere(u);
    records.push_back({position, direction, 3.0f});
  }
  return records;
}

TEST(Octahedron, PointsAndDirectionsAreInverse) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const V3f direction = sample_uniform_sphere(random.next_2d());
    const V2f point = point_of_direction(direction);
    ASSERT_TRUE(point.x >= 0.0f && point.x <= 1.0f && point.y >= 0.0f && point.y <= 1.0f) << direction;
    // A difference of coordinates, some units in the last place, grows to the norm of the sphere.
    ASSERT_LT((direction_of_point(point) - direction).length(), 1e-6f) << direction;
    const V2f other = random.next_2d();
    ASSERT_LT((point_of_direction(direction_of_point(other)) - other).length(), 1e-6f) << other;
    const uint32_t quarter = quarter_of(other);
    const V2f within = point_in_quarter(other, quarter);
    ASSERT_TRUE(within.x >= 0.0f && within.x < 1.0f && within.y >= 0.0f && within.y < 1.0f) << other;
  }
  for (int axis = 0; axis < 6; ++axis) {
    V3f direction(0.0f);
    direction[axis / 2] = axis % 2 == 0 ? 1.0f : -1.0f;
    EXPECT_LT((direction_of_point(point_of_direction(direction)) - direction).length(), 1e-6f) << direction;
  }
}

// The solid angles of caps, from the areas of small squares.
TEST(Octahedron, AreasHaveTheirSolidAngles) {
  constexpr int kSteps = 1024;
  const V3f axis = V3f(0.2f, -0.5f, 0.7f).normalized();
  double whole = 0.0, cap = 0.0;
  for (int y = 0; y < kSteps; ++y)
    for (int x = 0; x < kSteps; ++x) {
      const V3f direction =
          direction_of_point(V2f((static_cast<float>(x) + 0.5f) / kSteps, (static_cast<float>(y) + 0.5f) / kSteps));
      const double part = static_cast<double>(steradians_per_area(direction)) / (kSteps * kSteps);
      whole += part;
      if (direction.dot(axis) > 0.5f) cap += part;
    }
  EXPECT_NEAR(whole, 4.0 * std::numbers::pi, 1e-4);
  EXPECT_NEAR(cap, std::numbers::pi, 2e-3); // the edge crosses 3,000 squares
}

TEST(VolumeGuide, FindsTheLampWhereItIsSeen) {
  std::vector<VolumeRecord> records = lamp_on_the_left(200000, 2);
  const VolumeGuide guide(records);
  ASSERT_FALSE(guide.empty());
  EXPECT_GT(guide.regions.size(), 20U);
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    V3f position = point_in_cube(random);
    position.x = std::copysign(std::max(std::abs(position.x), 0.1f), position.x);
    const VolumeGuideView::Region& region = guide.find(position);
    if (position.x > 0.0f) {
      EXPECT_EQ(region.share, 0.0f) << position;
      continue;
    }
    EXPECT_GT(region.share, 0.2f) << position;
    EXPECT_LT(region.share, 0.4f) << position;
    EXPECT_GT(region.mean.dot(kBeam), 0.9f) << position;
    // Spread over at most twice its angle, four times its solid angle.
    EXPECT_GT(guide.pdf(region.root, kBeam), 0.25f * 0.5f * kInvPi / kBeamWidth) << position;
    EXPECT_LT(guide.pdf(region.root, -kBeam), 0.02f) << position;
  }
}

TEST(VolumeGuide, EvenLightIsNotGuided) {
  Random random(4);
  std::vector<VolumeRecord> records;
  for (int i = 0; i < 100000; ++i) {
    const V3f position = point_in_cube(random);
    const V3f direction = sample_uniform_sphere(random.next_2d());
    records.push_back({position, direction, 0.5f + random.next_1d()});
  }
  EXPECT_TRUE(VolumeGuide(records).empty());
  EXPECT_TRUE(VolumeGuide().empty());
  EXPECT_TRUE(VolumeGuide(std::span<VolumeRecord>()).empty());
}

// Records at one place cannot be divided, and one direction only so far.
TEST(VolumeGuide, EqualRecordsMakeOneRegion) {
  for (const V3f& direction : {V3f(0, 0, 1), V3f(0, 0, -1), V3f(1, 0, 0), kBeam}) {
    std::vector<VolumeRecord> records(20000, {V3f(1, 2, 3), direction, 1.0f});
    const VolumeGuide guide(records);
    ASSERT_EQ(guide.regions.size(), 1U);
    const VolumeGuideView::Region& region = guide.find(V3f(0.0f));
    EXPECT_GT(region.share, 0.5f);
    EXPECT_LT(region.share, 1.0f);
    EXPECT_GT(guide.pdf(region.root, direction), 30.0f) << direction;
    EXPECT_GT(guide.pdf(region.root, -direction), 0.0f) << direction;
  }
}

TEST(VolumeGuide, IsIndependentOfThreadCount) {
  std::vector<VolumeRecord> records = lamp_on_the_left(60000, 5), same = records;
  VolumeGuide alone, together;
  tbb::task_arena(1).execute([&] { alone = VolumeGuide(records); });
  tbb::task_arena(2).execute([&] { together = VolumeGuide(same); });
  ASSERT_EQ(alone.quarters.size(), together.quarters.size());
  Random random(6);
  for (int i = 0; i < 5000; ++i) {
    const V3f position = point_in_cube(random);
    const VolumeGuideView::Region &a = alone.find(position), &b = together.find(position);
    ASSERT_EQ(a.share, b.share);
    ASSERT_EQ(a.mean, b.mean);
    if (!(a.share > 0.0f)) continue;
    const V2f u = random.next_2d();
    ASSERT_EQ(alone.sample(a.root, u), together.sample(b.root, u));
  }
}

// Counts directions in cells of z and azimuth. The expectation integrates one random point in each
// of a million small cells: the density jumps at the edges of squares.
TEST(VolumeGuide, SamplingMatchesPdf) {
  std::vector<VolumeRecord> records = lamp_on_the_left(50000, 7);
  Random spread(8);
  for (size_t i = 0; i < records.size(); i += 5) { // a second lamp, and one at a fold of the octahedron
    const Frame frame = Frame::around(i % 2 == 0 ? V3f(-0.6f, 0.0f, 0.8f) : V3f(0.7f, 0.7f, -0.05f).normalized());
    records[i].direction = frame.to_world(sample_uniform_cone(spread.next_2d(), kBeamWidth));
  }
  const VolumeGuide guide(records);
  constexpr size_t kRows = 8, kColumns = 16, kFine = 128;
  constexpr int kSamples = 100000;
  constexpr double kCellSize = 4.0 * std::numbers::pi / (kRows * kFine * kColumns * kFine);
  uint64_t seed = 10;
  for (const V3f& position : {V3f(-0.5f, 0.5f, 0.5f), V3f(-0.2f, -0.9f, 0.1f), V3f(0.6f, 0.2f, -0.7f)}) {
    const VolumeGuideView::Region& region = guide.find(position);
    ASSERT_GT(region.share, 0.0f);
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
        const double mass = static_cast<double>(guide.pdf(region.root, w)) * kCellSize;
        expected[row / kFine * kColumns + column / kFine] += mass * kSamples;
        integral += mass;
      }
    EXPECT_NEAR(integral, 1.0, 5e-3) << position;
    for (int i = 0; i < kSamples; ++i) {
      const V3f w = guide.sample(region.root, random.next_2d());
      ASSERT_NEAR(w.length(), 1.0f, 1e-6f);
      ASSERT_GT(guide.pdf(region.root, w), 0.0f);
      double turns = std::atan2(static_cast<double>(w.y), static_cast<double>(w.x)) / (2.0 * std::numbers::pi);
      turns -= std::floor(turns);
      const auto row = static_cast<size_t>(std::min(0.5 * (1.0 - static_cast<double>(w.z)) * kRows, kRows - 1.0));
      const auto column = static_cast<size_t>(std::min(turns * kColumns, kColumns - 1.0));
      observed[row * kColumns + column] += 1.0;
    }
    test::expect_counts(observed, expected, 3, testing::PrintToString(position));
  }
}

} // namespace
} // namespace kindling
