// Tests of openings that are found in synthetic records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/frame.h"
#include "renderer/guiding/learn_guide.h"
#include "renderer/sampling/warp.h"
#include "tests/guiding/on_any_threads.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Random;

// A rectangle in a wall of the room, across `axis` on the side of larger coordinates: y from 0.8 to
// 1.6, and from -0.5 to 1 along the third axis.
struct Window {
  int axis;
  [[nodiscard]] bool contains(const V3f& at, float margin) const {
    const float along = at[2 - axis];
    return at.y > 0.8f - margin && at.y < 1.6f + margin && along > -0.5f - margin && along < 1.0f + margin;
  }
};

constexpr float kRoom = 2.0f; // half of the sides, and the height
constexpr float kYard = 20.0f;

// Returns the distance along a unit direction to the border of a space with walls at +-`half` and a
// ceiling at `top`, and sets the facing of the border.
float to_border(const V3f& from, const V3f& wi, float half, float top, uint32_t& facing) {
  float nearest = (top - from.y) / wi.y;
  facing = 3;
  for (const int axis : {0, 2}) {
    const float distance = ((wi[axis] > 0.0f ? half : -half) - from[axis]) / wi[axis];
    if (distance >= nearest) continue;
    nearest = distance;
    facing = 2 * static_cast<uint32_t>(axis) + (wi[axis] > 0.0f ? 1 : 0);
  }
  return nearest;
}

// From the floor of a room with windows, whose walls and ceiling are dim, to these and to the sky.
// Only every eighth dim direction is recorded; its contribution is eight times as large.
std::vector<GuideRecord> room_records(int count, uint64_t seed, std::span<const Window> windows) {
  Random random(seed);
  std::vector<GuideRecord> records;
  while (static_cast<int>(records.size()) < count) {
    GuideRecord record;
    record.position = V3f{4.0f * random.next_1d() - 2.0f, 0.0f, 4.0f * random.next_1d() - 2.0f} * 0.999f;
    record.normal = V3f(0, 1, 0);
    const V3f wi = Frame::around(record.normal).to_world(sample_cosine_hemisphere(random.next_2d()));
    if (wi.y < 0.001f) continue;
    record.hit = record.position + wi * to_border(record.position, wi, kRoom, kRoom, record.hit_facing);
    record.contribution2 = 8.0f * square(0.1f + 0.1f * random.next_1d());
    for (const Window& window : windows) {
      if (record.hit_facing != 2 * static_cast<uint32_t>(window.axis) + 1 || !window.contains(record.hit, 0.0f))
        continue;
      record.hit = record.position + wi * to_border(record.position, wi, kYard, kYard, record.hit_facing);
      record.hit_kind = kOnBounds;
      record.contribution2 = square(3.0f);
    }
    if (record.hit_kind == kOnSurface && random.next_1d() > 0.125f) continue;
    record.replaced = 1.0f;
    record.allowed = kPi / wi.y;
    records.push_back(record);
  }
  return records;
}

bool same_hit(const GuideRecord& a, const GuideRecord& b) { return a.hit == b.hit && a.hit_group() == b.hit_group(); }

constexpr Window kEast{0}, kSouth{2};

TEST(Openings, AreWhereTheWindowsAre) {
  const Window windows[] = {kEast, kSouth};
  const std::vector<GuideRecord> records = room_records(20000, 1, windows);
  std::vector<GuideRecord> moved = records;
  ASSERT_TRUE(move_to_openings(moved));
  int through = 0, found = 0, others = 0;
  for (size_t i = 0; i < records.size(); ++i) {
    const bool from_the_sky = records[i].hit_kind == kOnBounds;
    through += from_the_sky ? 1 : 0;
    if (moved[i].hit_kind < kFirstOpening) {
      EXPECT_TRUE(same_hit(moved[i], records[i]));
      continue;
    }
    const Window& window = moved[i].hit_facing == 1 ? kEast : kSouth;
    const bool in_window = moved[i].hit_facing == 2 * static_cast<uint32_t>(window.axis) + 1;
    if (!in_window) continue; // few rays are left for other openings
    (from_the_sky ? found : others) += 1;
    // The hit is on the same ray, close to the wall, and seen from inside.
    EXPECT_NEAR(moved[i].hit[window.axis], kRoom, 0.2f);
    const V3f before = records[i].hit - records[i].position, after = moved[i].hit - records[i].position;
    EXPECT_NEAR(before.normalized().dot(after.normalized()), 1.0f, 1e-4f);
    if (from_the_sky) {
      EXPECT_TRUE(window.contains(moved[i].hit, 0.25f)) << moved[i].hit;
    }
  }
  ASSERT_GT(through, 500);
  EXPECT_GT(found, through * 8 / 10);
  EXPECT_LT(others, through / 20);
}

TEST(Openings, NoneWithoutWindows) {
  const std::vector<GuideRecord> records = room_records(20000, 2, {});
  std::vector<GuideRecord> same = records;
  EXPECT_FALSE(move_to_openings(same));
  EXPECT_TRUE(std::equal(same.begin(), same.end(), records.begin(), records.end(), same_hit));
  // Nor under an open sky.
  for (GuideRecord& record : same) {
    const V3f wi = (record.hit - record.position).normalized();
    record.hit = record.position + wi * to_border(record.position, wi, kYard, kYard, record.hit_facing);
    record.hit_kind = kOnBounds;
    record.contribution2 = 1.0f;
  }
  EXPECT_FALSE(move_to_openings(same));
  EXPECT_FALSE(move_to_openings({}));
}

TEST(Openings, GuideAimsAtTheWindow) {
  const Window windows[] = {kEast};
  const LearnedGuide learned = learn_guide(room_records(40000, 3, windows), {});
  EXPECT_LT(learned.second_moment_of_openings, 0.5);
  const std::vector<GuideRecord> others = room_records(40000, 6, windows);
  EXPECT_NEAR(second_moment(others, learned.patches_of_openings), learned.second_moment_of_openings, 0.05);
  EXPECT_LT(learned.second_moment_of_openings, 0.8 * second_moment(others, learned.guide.patches));

  const BrightPatches& patches = learned.patches_of_openings;
  const V3f from(-0.5f, 0.0f, 0.2f);
  BrightPatches::Chances chances;
  patches.chances(from, V3f(0, 1, 0), chances);
  const auto through = [&](const V3f& wi) {
    return wi.x > 0.0f && kEast.contains(from + wi * ((kRoom - from.x) / wi.x), 0.1f);
  };
  Random random(4);
  int inside = 0, by_chance = 0;
  for (int i = 0; i < 1000; ++i) {
    const float u_patch = random.next_1d();
    const std::optional<V3f> wi = patches.sample(chances, from, u_patch, random.next_2d());
    ASSERT_TRUE(wi);
    inside += through(*wi) ? 1 : 0;
    by_chance += through(Frame::around(V3f(0, 1, 0)).to_world(sample_cosine_hemisphere(random.next_2d()))) ? 1 : 0;
  }
  EXPECT_GT(inside, 800);
  EXPECT_GT(chances.sum * static_cast<float>(inside), 3.0f * static_cast<float>(by_chance));
}

TEST(Openings, DoNotDependOnThreads) {
  const Window windows[] = {kEast};
  EXPECT_FALSE(test::learn_on_any_threads(room_records(50000, 5, windows)).patches_of_openings.empty());
}

} // namespace
} // namespace kindling
