// Tests of learned light selection probabilities, and of LightSet with them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/light_selection_tree.h"

#include "renderer/light/light_set.h"
#include "renderer/sampling/warp.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace kindling {
namespace {

using test::Random;

// A floor: on the left the sun is nine times as strong as the lamps, on the right it does not
// arrive.
std::vector<LightRecord> floor_records(int count, uint64_t seed) {
  Random random(seed);
  std::vector<LightRecord> records;
  for (int i = 0; i < count; ++i) {
    LightRecord record;
    record.position = V3f{2.0f * random.next_1d() - 1.0f, 0.0f, random.next_1d()};
    record.facing = static_cast<uint8_t>(facing_of(V3f(0, 1, 0)));
    record.unguided_probability = 0.5f;
    const bool sun = record.position.x < 0.0f && i % 2 == 0;
    record.kind = sun ? LightKind::directional : LightKind::tree;
    record.moment = sun ? 81.0f : 1.0f;
    records.push_back(record);
  }
  return records;
}

TEST(LightSelectionTree, LearnsFromUnoccludedSamples) {
  std::vector<LightRecord> records = floor_records(20000, 1);
  const LightSelectionTree shares(records);
  EXPECT_GT(shares.region_count(), 50U);
  const LightProbabilities& left = shares.find(V3f(-0.5f, 0, 0.5f), V3f(0, 1, 0));
  const LightProbabilities& right = shares.find(V3f(0.5f, 0, 0.5f), V3f(0, 1, 0));
  EXPECT_NEAR(left[1] / left[0], 9.0f, 1.0f); // square roots of the moments
  EXPECT_GT(right[0], 0.8f);
  for (const LightProbabilities& here : {left, right})
    for (const float share : here) EXPECT_GE(share, 0.05f); // lower bound
  const std::vector<LightRecord> others = floor_records(20000, 2);
  EXPECT_LT(second_moment(others, shares), 0.7);
  EXPECT_TRUE(LightSelectionTree().empty());
  EXPECT_EQ(LightSelectionTree(LightProbabilities{0.5f, 0.2f, 0.3f}).find(V3f(1, 2, 3), V3f(0, 0, 1))[1], 0.2f);
  EXPECT_TRUE(LightSelectionTree(std::span<LightRecord>()).empty());
}

// Records of samples that a guide has drawn predict what those without a guide do: samples of the
// sun are three times as likely, and each counts a third as much.
TEST(LightSelectionTree, GainsAreRelativeToSamplesWithoutAGuide) {
  std::vector<LightRecord> records = floor_records(20000, 1);
  const LightSelectionTree shares(records);
  const double unguided = second_moment(records, shares);
  std::vector<LightRecord> guided;
  for (LightRecord record : records) {
    const int times = record.kind == LightKind::directional ? 3 : 1;
    record.moment /= static_cast<float>(times);
    guided.insert(guided.end(), static_cast<size_t>(times), record);
  }
  EXPECT_NEAR(second_moment(guided, shares), unguided, 1e-5); // moments are floats
}

// Large regions are built by several threads: the tree equals that of one thread, and all leaves
// are in place.
TEST(LightSelectionTree, IsIndependentOfThreadCount) {
  std::vector<LightRecord> records = floor_records(60000, 3);
  for (size_t i = 0; i < records.size(); i += 3) records[i].facing = static_cast<uint8_t>(i % kFacings);
  std::vector<LightRecord> same = records;
  LightSelectionTree alone, together;
  tbb::task_arena(1).execute([&] { alone = LightSelectionTree(records); });
  tbb::task_arena(2).execute([&] { together = LightSelectionTree(same); });
  EXPECT_EQ(together.region_count(), alone.region_count());
  Random random(4);
  for (int i = 0; i < 5000; ++i) {
    const V3f position{2.0f * random.next_1d() - 1.0f, 0.0f, random.next_1d()};
    for (uint32_t facing = 0; facing < kFacings; ++facing)
      ASSERT_EQ(alone.find(position, facing), together.find(position, facing));
    // The sun, and only on the left.
    const LightProbabilities& up = together.find(position, V3f(0, 1, 0));
    if (std::abs(position.x) > 0.2f) {
      EXPECT_EQ(up[1] > 0.3f, position.x < 0.0f) << position;
    }
  }
  EXPECT_EQ(second_moment(records, alone), second_moment(same, together));
}

// Any number of searches at once ends where single ones do, also from roots without children.
TEST(LightSelectionTree, FindsManyRegionsTogether) {
  std::vector<LightRecord> records = floor_records(20000, 5);
  const LightSelectionTree tree(records);
  const V3f normals[] = {V3f(0, 1, 0), V3f(0, -1, 0), V3f(1, 0, 0)};
  Random random(6);
  for (size_t count = 0; count <= 33; ++count) {
    std::vector<RegionSearch> searches;
    std::vector<const LightProbabilities*> expected;
    for (size_t i = 0; i < count; ++i) {
      const V3f position{2.4f * random.next_1d() - 1.2f, 0.0f, random.next_1d()};
      const V3f& normal = normals[random.next_u64() % 3];
      searches.push_back(LightSelectionTreeView::search(position, normal));
      expected.push_back(&tree.find(position, normal));
    }
    find_regions(tree.nodes, searches);
    for (size_t i = 0; i < count; ++i) ASSERT_EQ(&tree.probabilities[searches[i].at], expected[i]) << i;
  }
}

// A triangle, three suns, of which one is below the horizon, and an environment.
LightSet lights_of_all_kinds() {
  LightSetInput input;
  input.emissions = {{Rgb(3.0f), nullptr, true}};
  input.triangles = {{V3f(-1, 2, -1), V3f(1, 2, -1), V3f(0, 2, 1), 0}};
  input.directionals = {{V3f(0, -1, 0), Rgb(2.0f)}, {V3f(0.6f, -0.8f, 0), Rgb(1.0f)}, {V3f(0, 1, 0), Rgb(5.0f)}};
  input.environment = std::make_shared<Environment>(Rgb(0.5f));
  return LightSet(input);
}

// All samples have the density of the pdf functions, and kinds are selected as often as learned.
TEST(LightSelectionTree, LightSetUsesLearnedProbabilities) {
  const LightSet lights = lights_of_all_kinds();
  const V3f point(0.2f, 0, 0.1f), normal(0, 1, 0);
  for (const LightProbabilities& learned :
       {LightProbabilities{0.2f, 0.5f, 0.3f}, LightProbabilities{2.0f, 0.05f, 0.4f}}) {
    Random random(3);
    constexpr int kSamples = 100000;
    std::array<int, kLightKinds> counts{};
    for (int i = 0; i < kSamples; ++i) {
      const float u_light = random.next_1d();
      const std::optional<LightSample> s = lights.sample(point, normal, u_light, random.next_2d(), &learned);
      ASSERT_TRUE(s);
      ++counts[static_cast<size_t>(s->kind)];
      if (s->kind == LightKind::environment) {
        const float pdf = lights.pdf_environment(point, normal, s->wi, &learned);
        ASSERT_NEAR(s->pdf, pdf, 1e-4f * pdf);
        ASSERT_EQ(lights.environment_eval(point, normal, s->wi, &learned).pdf, pdf);
      }
      if (s->kind == LightKind::tree) {
        const float pdf = lights.pdf_triangle(0, point, normal, s->wi, s->distance, &learned);
        ASSERT_NEAR(s->pdf, pdf, 1e-3f * pdf);
      }
    }
    const float sum = learned[0] + learned[1] + learned[2];
    for (size_t f = 0; f < kLightKinds; ++f) {
      const double p = static_cast<double>(learned[f] / sum);
      EXPECT_NEAR(counts[f], p * kSamples, 5.0 * std::sqrt(p * (1.0 - p) * kSamples)) << f;
    }
  }
}

// Samples with learned probabilities name those with which the same kinds are selected without.
TEST(LightSelectionTree, LightSetNamesProbabilitiesWithoutAGuide) {
  const LightSet lights = lights_of_all_kinds();
  const V3f point(0.2f, 0, 0.1f), normal(0, 1, 0);
  const LightProbabilities learned{0.2f, 0.7f, 0.1f};
  const auto number = [](const LightSample& s) { return s.kind == LightKind::directional ? 10 + s.emitter : 0; };
  const auto key = [&](const LightSample& s) { return std::pair(s.kind, number(s)); };
  std::map<std::pair<LightKind, uint32_t>, float> unlearned;
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const float u_light = random.next_1d();
    const std::optional<LightSample> s = lights.sample(point, normal, u_light, random.next_2d());
    ASSERT_TRUE(s);
    unlearned[key(*s)] = s->kind_probability;
  }
  EXPECT_EQ(unlearned.size(), 4U);
  for (int i = 0; i < 2000; ++i) {
    const float u_light = random.next_1d();
    const std::optional<LightSample> s = lights.sample(point, normal, u_light, random.next_2d(), &learned);
    ASSERT_TRUE(s);
    const float probability = lights.unlearned_kind_probability(point, normal, *s);
    EXPECT_EQ(probability, unlearned.at(key(*s)));
    EXPECT_NE(probability, s->kind_probability);
  }
}

// Missing kinds leave their probability to the others.
TEST(LightSelectionTree, AbsentKindsAreIgnored) {
  LightSetInput input;
  input.directionals = {{V3f(0, -1, 0), Rgb(2.0f)}};
  input.environment = std::make_shared<Environment>(Rgb(0.5f));
  const LightSet lights(input);
  const LightProbabilities learned{0.6f, 0.3f, 0.1f};
  Random random(4);
  int suns = 0;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const float u_light = random.next_1d();
    const auto s = lights.sample(V3f(0.0f), V3f(0, 1, 0), u_light, random.next_2d(), &learned);
    ASSERT_TRUE(s);
    suns += s->delta ? 1 : 0;
  }
  EXPECT_NEAR(suns, 0.75 * kSamples, 5.0 * std::sqrt(0.75 * 0.25 * kSamples));
  // The sun is below the horizon.
  for (int i = 0; i < 100; ++i) {
    const float u_light = random.next_1d();
    const auto s = lights.sample(V3f(0.0f), V3f(0, -1, 0), u_light, random.next_2d(), &learned);
    ASSERT_TRUE(s);
    EXPECT_EQ(s->kind, LightKind::environment);
  }
}

} // namespace
} // namespace kindling
