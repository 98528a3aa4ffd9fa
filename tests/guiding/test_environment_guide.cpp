// Tests of learned shares of directions that follow the environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/environment_guide.h"

#include "renderer/guiding/learn_guide.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

namespace kindling {
namespace {

using test::Random;

constexpr V3f kUpwards(0, 1, 0);

GuideRecord record_at(const V3f& position, float contribution2, float environment) {
  GuideRecord record;
  record.position = position;
  record.normal = kUpwards;
  record.hit = position + kUpwards;
  record.base = record.replaced = record.allowed = 1.0f;
  record.contribution2 = contribution2;
  record.environment = environment;
  return record;
}

// A floor: on the left a tenth of the directions finds a lamp, which would be found four times as
// often by following the environment; on the right the environment finds less than the BSDF.
std::vector<GuideRecord> lamp_floor(int count, uint64_t seed) {
  Random random(seed);
  std::vector<GuideRecord> records;
  for (int i = 0; i < count; ++i) {
    const V3f position{2.0f * random.next_1d() - 1.0f, 0.0f, random.next_1d()};
    const bool lamp = position.x < 0.0f && random.next_1d() < 0.1f;
    records.push_back(record_at(position, lamp ? 25.0f : 1.0f, lamp ? 4.0f : 0.5f));
  }
  return records;
}

// The second moment with a share e is 2.5 / (1 + 3 e) + 0.9 / (1 - 0.5 e) on the left.
double moment_on_the_left(double e) { return 2.5 / (1.0 + 3.0 * e) + 0.9 / (1.0 - 0.5 * e); }

TEST(EnvironmentGuide, LearnsTheShareWithTheLeastNoise) {
  double best = 0.0;
  for (double e = 0.0; e <= EnvironmentGuideView::kMaxShare; e += 0.01)
    if (moment_on_the_left(e) < moment_on_the_left(best)) best = e;
  ASSERT_GT(best, 0.2);
  std::vector<GuideRecord> records = lamp_floor(20000, 1);
  const EnvironmentGuide guide(records);
  EXPECT_GT(guide.region_count(), 20U);
  Random random(2);
  double sum = 0.0;
  constexpr int kPoints = 400;
  for (int i = 0; i < kPoints; ++i) {
    sum += static_cast<double>(guide.find(V3f{-random.next_1d(), 0, random.next_1d()}, kUpwards));
    EXPECT_EQ(guide.find(V3f{0.3f + 0.7f * random.next_1d(), 0, random.next_1d()}, kUpwards), 0.0f);
  }
  // Regions differ by the number of records with the lamp; the curve is flat around its minimum.
  EXPECT_LT(moment_on_the_left(sum / kPoints), 1.02 * moment_on_the_left(best));
  EXPECT_NEAR(second_moment(lamp_floor(20000, 3), guide, 0.0),
              (moment_on_the_left(best) + 1.0) / (moment_on_the_left(0.0) + 1.0), 0.03);
}

TEST(EnvironmentGuide, FacingsAreApart) {
  std::vector<GuideRecord> records = lamp_floor(20000, 1), down = records;
  for (GuideRecord& record : down) {
    record.normal = -kUpwards;
    record.environment = 0.0f;
  }
  records.insert(records.end(), down.begin(), down.end());
  const EnvironmentGuide guide(records);
  EXPECT_GT(guide.find(V3f(-0.5f, 0, 0.5f), kUpwards), 0.0f);
  EXPECT_EQ(guide.find(V3f(-0.5f, 0, 0.5f), -kUpwards), 0.0f);
}

TEST(EnvironmentGuide, IsEmptyWhereNothingIsGained) {
  EXPECT_TRUE(EnvironmentGuide().empty());
  EXPECT_TRUE(EnvironmentGuide(std::span<GuideRecord>()).empty());
  std::vector<GuideRecord> records;
  for (int i = 0; i < 2000; ++i) records.push_back(record_at(V3f(static_cast<float>(i), 0, 0), 1.0f, 0.9f));
  const EnvironmentGuide guide(records);
  EXPECT_TRUE(guide.empty());
  EXPECT_EQ(guide.region_count(), 0U);
  EXPECT_EQ(second_moment(records, guide, 0.0), 1.0);
}

TEST(EnvironmentGuide, TheSameShareEverywhere) {
  const EnvironmentGuide guide(0.25f);
  EXPECT_FALSE(guide.empty());
  for (const V3f& normal : {V3f(1, 0, 0), V3f(0, -1, 0), V3f(0, 0.6f, 0.8f)})
    EXPECT_EQ(guide.find(V3f(7, 8, 9), normal), 0.25f);
}

// A hundred contributions, the k-th of squared brightness k / q^2 if it is found q times as often.
TEST(EnvironmentGuide, RareLightIsLeftOut) {
  std::vector<GuideRecord> records;
  for (int k = 1; k <= 100; ++k) records.push_back(record_at(V3f(0.0f), static_cast<float>(k), 2.0f));
  const EnvironmentGuide guide(0.5f); // finds all of them 1.5 times as often
  const auto sum_to = [](double n) { return 0.5 * n * (n + 1.0); };
  EXPECT_NEAR(second_moment(records, guide, 0.0), 1.0 / 1.5, 1e-6);
  // Three are two of those that are found more often; of them there are 1.5 each.
  EXPECT_NEAR(second_moment(records, guide, 3.0), sum_to(98) / 1.5 / sum_to(97), 1e-6);
  EXPECT_EQ(second_moment(records, guide, 1000.0), 1.0); // nothing is left
}

TEST(LearnEnvironment, HalvesJudgeEachOther) {
  const LearnedEnvironment learned = learn_environment(lamp_floor(20000, 4), 0.0);
  EXPECT_FALSE(learned.guide.empty());
  EXPECT_LT(learned.second_moment, 0.8);
  EXPECT_GT(learned.second_moment, 0.6);
  EXPECT_EQ(learn_environment({}, 0.0).second_moment, 1.0);
  EXPECT_TRUE(learn_environment(lamp_floor(300, 5), 0.0).guide.empty()); // too few
  // If the lamp's light is too rare to be seen, a guide would be in vain.
  EXPECT_GE(learn_environment(lamp_floor(20000, 4), 4000.0).second_moment, 1.0);
}

TEST(LearnEnvironment, DoesNotDependOnThreads) {
  const std::vector<GuideRecord> records = lamp_floor(60000, 6);
  LearnedEnvironment alone, together;
  tbb::task_arena(1).execute([&] { alone = learn_environment(records, 2.0); });
  tbb::task_arena(3).execute([&] { together = learn_environment(records, 2.0); });
  EXPECT_EQ(together.second_moment, alone.second_moment);
  ASSERT_EQ(together.guide.shares.size(), alone.guide.shares.size());
  for (size_t i = 0; i < alone.guide.shares.size(); ++i) ASSERT_EQ(together.guide.shares[i], alone.guide.shares[i]);
  ASSERT_EQ(together.guide.nodes.size(), alone.guide.nodes.size());
  for (size_t i = 0; i < alone.guide.nodes.size(); ++i)
    ASSERT_EQ(together.guide.nodes[i].split, alone.guide.nodes[i].split);
}

} // namespace
} // namespace kindling
