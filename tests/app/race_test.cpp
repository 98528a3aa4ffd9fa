// The measurements of a shootout: answers are compared, calls and rounds are those of the settings.
// SPDX-License-Identifier: Apache-2.0
#include "accel/make_accelerator.h"
#include "renderer/app/shootout/shootout_measure.h"
#include "renderer/app/shootout/shootout_report.h"
#include "tests/app/plane_accelerator.h"

namespace kindling::test {
namespace {

using namespace kindling::app;

TEST(Race, CountsDisagreements) {
  const PlaneAccelerator truth(0.0f, 0), liar(0.0f, 10), near_rounding(1e-6f, 0), far_off(0.01f, 0);
  const accel::Accelerator* racers[] = {&truth, &liar, &near_rounding, &far_off};
  const std::vector<RaySet> sets{plane_rays("camera", RayQuery::nearest, 64),
                                 plane_rays("shadow1", RayQuery::any_hit, 0)};
  const SceneResult result = race(racers, sets, 2);
  ASSERT_EQ(result.sets.size(), 2U);
  EXPECT_EQ(result.sets[0].hit_count, 150U);
  EXPECT_EQ(result.sets[1].hit_count, 150U);
  for (const AcceleratorResult& a : result.accelerators) ASSERT_EQ(a.traversal.size(), 6U); // 3 forms each
  for (size_t row = 0; row < 6; ++row) {
    const auto disagreements = [&](size_t a) { return result.accelerators[a].traversal[row].disagreements; };
    EXPECT_EQ(disagreements(0).total(), 0U);
    EXPECT_EQ(disagreements(1).hit_or_miss, 30U) << row;
    EXPECT_EQ(disagreements(1).distance, 0U);
    EXPECT_EQ(disagreements(1).first->ray, 0U); // index 0 is the first lie: a miss in place of a hit at distance 2
    EXPECT_EQ(disagreements(1).first->expected_t, row < 3 ? 2.0f : 0.0f);
    EXPECT_EQ(disagreements(1).first->found_t, kInfinity);
    EXPECT_EQ(disagreements(1).at_edge, 30U); // every hit is at a corner
    EXPECT_FALSE(disagreements(2).first.has_value());
    EXPECT_EQ(disagreements(2).total(), 0U);
    EXPECT_EQ(disagreements(3).hit_or_miss, 0U);
    EXPECT_EQ(disagreements(3).distance, row < 3 ? 150U : 0U); // any hit has no distance
  }
  EXPECT_EQ(sum_disagreements(result.accelerators[1]).hit_or_miss, 180U);
}

// The kd-tree and brute force have equal bits; Embree has a tolerance.
TEST(Race, KdTreeAndBruteForceAreComparedToTheBit) {
  const PlaneAccelerator truth(0.0f, 0), near_rounding(1e-6f, 0);
  const accel::Accelerator* racers[] = {&truth, &near_rounding};
  const std::vector<RaySet> sets{plane_rays("camera", RayQuery::nearest, 64)};
  for (const accel::Kind other : {accel::Kind::embree, accel::Kind::kdtree}) {
    SceneResult result;
    result.accelerators.resize(2);
    result.accelerators[0].variant.kind = accel::Kind::brute_force;
    result.accelerators[1].variant.kind = other;
    RaceSettings settings;
    settings.repeat = 1;
    ASSERT_TRUE(race_traversal(
        sets, racers, settings, [](const std::string&) { return true; }, result));
    for (const TraversalResult& row : result.accelerators[1].traversal)
      EXPECT_EQ(row.disagreements.distance, other == accel::Kind::embree ? 0U : 150U);
  }
}

// Rays near an edge of a sliver, one of them within rounding: an accelerator that misses it there
// is not wrong.
TEST(Race, RoundingIsNotADisagreement) {
  const std::vector<V3f> positions{{-2.19400001f, 0.109999999f, -2.19400001f},
                                   {-2.19400001f, 0.109999999f, 2.99399996f},
                                   {-2.19000006f, 0.109999999f, 2.99399996f},
                                   V3f(0.0f),
                                   V3f(0.0f)};
  const std::vector<uint32_t> indices{0, 1, 2};
  const std::vector<accel::TriangleMesh> meshes{{positions, indices}};
  const std::vector<accel::MeshGroup> groups{{0, 1}};
  const std::vector<accel::Instance> instances{{0, M44f()}};
  const accel::BuildInput geometry{meshes, groups, instances, {}};
  const auto sees_it = accel::make_accelerator(accel::Kind::brute_force, geometry),
             sees_nothing = accel::make_accelerator(accel::Kind::brute_force, {});
  const accel::Accelerator* racers[] = {sees_it.get(), sees_nothing.get()};
  // The first ray passes at an edge within rounding, the other one beside it.
  const V3f direction(0.5f, -1.0f, 0.3f), origin = V3f(-2.19400001f, 0.11f, 0.5f) - direction;
  const std::vector<accel::Ray> rays{
      {.origin = origin, .direction = direction, .t_max = kInfinity},
      {.origin = origin + V3f(1.2e-6f, 0.0f, 0.0f), .direction = direction, .t_max = kInfinity}};
  const std::vector<RaySet> sets{{"bounce1", RayQuery::nearest, 0, rays}, {"shadow1", RayQuery::any_hit, 0, rays}};
  for (const bool judged : {false, true}) {
    SceneResult result;
    result.accelerators.resize(2);
    RaceSettings settings;
    settings.repeat = 1;
    settings.geometry = judged ? &geometry : nullptr;
    ASSERT_TRUE(race_traversal(
        sets, racers, settings, [](const std::string&) { return true; }, result));
    for (const TraversalResult& row : result.accelerators[1].traversal) {
      EXPECT_EQ(row.disagreements.hit_or_miss, judged ? 1U : 2U);
      EXPECT_EQ(row.disagreements.first->ray, judged ? 1U : 0U);
    }
  }
}

TEST(Race, FollowsSettings) {
  const PlaneAccelerator plane(0.0f, 0);
  const accel::Accelerator* racers[] = {&plane};
  const SceneResult result = race(racers, {plane_rays("camera", RayQuery::nearest, 64)}, 3);
  // Each of the four rounds: 300 rays in batches of 128, then in groups of 64.
  const std::vector<size_t> round{128, 128, 44, 64, 64, 64, 64, 44};
  ASSERT_EQ(plane.batches.size(), 4 * round.size());
  for (size_t i = 0; i < plane.batches.size(); ++i) EXPECT_EQ(plane.batches[i], round[i % round.size()]);
  for (const TraversalResult& row : result.accelerators[0].traversal) {
    EXPECT_EQ(row.times_s.size(), 3U);
    EXPECT_EQ(row.ratio_to_first, 1.0);
  }
  EXPECT_GT(result.accelerators[0].traversal_work.wall_s, 0.0); // sum over the timed rounds, by both clocks
  EXPECT_GT(result.accelerators[0].traversal_work.cpu_s, 0.0);
}

TEST(Race, EndsOnRequest) {
  const PlaneAccelerator plane(0.0f, 0);
  const accel::Accelerator* racers[] = {&plane};
  SceneResult result;
  result.accelerators.resize(1);
  int calls = 0;
  const std::vector<RaySet> sets{plane_rays("camera", RayQuery::nearest, 0)};
  EXPECT_FALSE(race_traversal(
      sets, racers, {}, [&](const std::string&) { return ++calls < 3; }, result));
  EXPECT_EQ(calls, 3);
}

TEST(Race, SkipsEmptySets) {
  const PlaneAccelerator plane(0.0f, 0);
  const accel::Accelerator* racers[] = {&plane};
  const SceneResult result = race(racers, {{"bounce3", RayQuery::nearest, 0, {}}}, 1);
  EXPECT_EQ(result.sets.size(), 1U);
  EXPECT_TRUE(result.accelerators[0].traversal.empty());
}

TEST(Race, HeatMapHasOneValuePerPixel) {
  const PlaneAccelerator plane(0.0f, 0);
  const HeatMap map = measure_heat_map(plane, Camera(SceneCamera{}, M44f(), V2i(7, 5)));
  EXPECT_EQ(map.size_px, V2i(7, 5));
  ASSERT_EQ(map.values.size(), 35U);
  for (const float ns : map.values) EXPECT_GE(ns, 0.0f);
}

// Rays of a triangle in z = 0 through Embree's own calls too: every call answers, others have no
// such rows.
TEST(Race, EmbreeHasCallsOfItsOwn) {
  const std::vector<V3f> positions{V3f(-2, -1, 0), V3f(0, -1, 0), V3f(-2, 3, 0), V3f(0)}; // the last one is padding
  const std::vector<uint32_t> indices{0, 1, 2};
  const accel::TriangleMesh mesh{std::span(positions).first(3), indices, true};
  const accel::MeshGroup group{0, 1};
  const accel::Instance instance{0, M44f()};
  const accel::BuildInput input{{&mesh, 1}, {&group, 1}, {&instance, 1}, {}};
  const auto embree = accel::make_accelerator(accel::Kind::embree, input);
  const PlaneAccelerator plane(0.0f, 0);
  const accel::Accelerator* racers[] = {&plane, embree.get()};
  const std::vector<RaySet> sets{plane_rays("camera", RayQuery::nearest, 64),
                                 plane_rays("shadow1", RayQuery::any_hit, 0)};
  const SceneResult result = race(racers, sets, 1);
  size_t own = 0;
  for (size_t row = 0; row < result.accelerators[0].traversal.size(); ++row) {
    const TraversalResult &other = result.accelerators[0].traversal[row],
                          &own_row = result.accelerators[1].traversal[row];
    EXPECT_EQ(other.form, own_row.form);
    EXPECT_EQ(own_row.disagreements.total(), 0U) << call_form_name(own_row.form);
    if (every_accelerator_has(own_row.form)) continue;
    EXPECT_TRUE(other.times_s.empty());
    EXPECT_EQ(own_row.ratio_to_first, 0.0);
    own += own_row.times_s.size();
  }
  EXPECT_GE(own, 4U); // packets; Embree 3 has streams too
  SceneResult without;
  without.accelerators.resize(2);
  RaceSettings settings;
  settings.embree_calls = false;
  EXPECT_TRUE(race_traversal(
      sets, racers, settings, [](const std::string&) { return true; }, without));
  EXPECT_EQ(without.accelerators[1].traversal.size(), 6U);
}

TEST(Race, CostsAreMeansOverRays) {
  // Visits as many nodes as its number says, twice as many triangles; any hit: one leaf.
  class Counting final : public PlaneAccelerator {
   public:
    Counting() : PlaneAccelerator(0.0f, 0) {}
    std::optional<accel::TraversalCost> traversal_cost(const accel::Ray& ray, bool any_hit) const override {
      return accel::TraversalCost{ray.index, any_hit ? 1U : 0U, 2 * ray.index};
    }
  };
  const std::vector<RaySet> sets{plane_rays("camera", RayQuery::nearest, 64),
                                 plane_rays("shadow1", RayQuery::any_hit, 0),
                                 {"bounce3", RayQuery::nearest, 0, {}}};
  const std::vector<MeanCost> costs = measure_costs(Counting(), sets);
  ASSERT_EQ(costs.size(), 3U);
  EXPECT_DOUBLE_EQ(costs[0].nodes, 149.5);
  EXPECT_DOUBLE_EQ(costs[0].leaves, 0.0);
  EXPECT_DOUBLE_EQ(costs[1].leaves, 1.0);
  EXPECT_DOUBLE_EQ(costs[1].triangles, 299.0);
  EXPECT_EQ(costs[2].nodes, 0.0);
  EXPECT_TRUE(measure_costs(PlaneAccelerator(0.0f, 0), sets).empty());
  const Camera camera(SceneCamera{}, M44f(), V2i(7, 5));
  EXPECT_EQ(count_step_map(Counting(), camera).values, std::vector<float>(35, 0.0f));
  EXPECT_TRUE(count_step_map(PlaneAccelerator(0.0f, 0), camera).values.empty());
}

} // namespace
} // namespace kindling::test
