// The parts of a shootout: statistics, names of accelerators, the race itself with accelerators that lie, plots and images.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/indexed_png.h"
#include "renderer/app/measure/measurement.h"
#include "renderer/app/measure/svg.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/options/options.h"
#include "renderer/app/shootout/shootout_measure.h"
#include "renderer/app/shootout/shootout_plots.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/shootout/shootout_summary.h"
#include "renderer/image/decode_image.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <sstream>

namespace kindling::test {
namespace {

using namespace kindling::app;

TEST(Measurement, MedianAndSpread) {
  EXPECT_EQ(median({}), 0.0);
  EXPECT_EQ(median(std::vector<double>{3}), 3.0);
  EXPECT_EQ(median(std::vector<double>{9, 1, 4}), 4.0);
  EXPECT_EQ(median(std::vector<double>{9, 1, 4, 2}), 3.0);
  EXPECT_EQ(percentile(std::vector<double>{0, 10, 20, 30, 40}, 0.0), 0.0);
  EXPECT_EQ(percentile(std::vector<double>{0, 10, 20, 30, 40}, 1.0), 40.0);
  EXPECT_DOUBLE_EQ(percentile(std::vector<double>{40, 10, 20, 30, 0}, 0.9), 36.0);
  const Summary summary = summarize(std::vector<double>{2, 5, 4});
  EXPECT_EQ(summary.median, 4.0);
  EXPECT_EQ(summary.min, 2.0);
  EXPECT_EQ(summary.max, 5.0);
  EXPECT_EQ(summary.spread_percent(), 75.0);
  EXPECT_EQ(summarize({}).spread_percent(), 0.0);
}

TEST(Measurement, RatiosAreTakenRepetitionByRepetition) {
  // The machine was half as fast in the second repetition: the ratio does not see it.
  EXPECT_DOUBLE_EQ(speed_ratio(std::vector<double>{1, 2, 1}, std::vector<double>{0.5, 1, 0.5}), 2.0);
  EXPECT_DOUBLE_EQ(speed_ratio(std::vector<double>{1, 1, 1}, std::vector<double>{2, 4, 8}), 0.25);
  EXPECT_DOUBLE_EQ(speed_ratio(std::vector<double>{0, 3}, std::vector<double>{1, 1}), 3.0);
  EXPECT_EQ(speed_ratio({}, {}), 0.0);
  EXPECT_DOUBLE_EQ(geometric_mean(std::vector<double>{2, 8, 0}), 4.0);
  EXPECT_EQ(geometric_mean({}), 0.0);
}

TEST(AcceleratorVariant, NamesAreParsed) {
  const auto variants =
      parse_accelerator_variants("kdtree,embree:best,embree:fast:non-robust,embree:robust,brute-force,kdtree:portable");
  ASSERT_TRUE(variants.ok()) << variants.error().message;
  std::vector<std::string> names;
  for (const AcceleratorVariant& variant : variants.value()) names.push_back(variant.name());
  EXPECT_EQ(names, (std::vector<std::string>{"kdtree", "embree:best", "embree:fast:non-robust", "embree", "brute-force",
                                             "kdtree:portable"}));
  EXPECT_EQ(variants.value()[2].quality, accel::Quality::fast);
  EXPECT_FALSE(variants.value()[2].robust);
  EXPECT_TRUE(variants.value()[1].robust);
}

TEST(AcceleratorVariant, WrongNamesAreRefused) {
  const auto expect_refused = [](const char* text, const std::string& words) {
    const auto variants = parse_accelerator_variants(text);
    ASSERT_FALSE(variants.ok()) << text;
    EXPECT_EQ(variants.error().kind, ErrorKind::usage);
    EXPECT_NE(variants.error().message.find(words), std::string::npos) << variants.error().message;
  };
  expect_refused("", "");
  expect_refused("bvh", "unknown accelerator 'bvh'; use kdtree, embree or brute-force");
  expect_refused("embree:finest", "unknown setting 'finest' of embree; use fast, balanced or best");
  expect_refused("embree:", "unknown setting '' of embree");
  expect_refused("kdtree:non-robust", "kdtree is always robust");
  expect_refused("embree:portable", "embree has no kernels for portable that this processor runs; use sse2");
  expect_refused("kdtree:sse2", "kdtree has no kernels for sse2 that this processor runs; use portable");
  expect_refused("brute-force:avx2", "brute-force has no instruction sets to choose from");
  expect_refused("brute-force:best", "brute-force has no qualities");
  expect_refused("embree,kdtree,embree:balanced", "embree is given twice");
}

TEST(AcceleratorVariant, AreLimitedToAnInstructionSet) {
  using accel::SimdTarget;
  std::vector<AcceleratorVariant> variants =
      parse_accelerator_variants("kdtree,embree,brute-force,kdtree:portable,embree:sse2").value();
  limit_instruction_set(variants, SimdTarget::sse42);
  const bool has_sse42 = accel::embree_simd_targets().back() >= SimdTarget::sse42;
  EXPECT_EQ(variants[0].simd, SimdTarget::portable);
  EXPECT_EQ(variants[1].simd, has_sse42 ? SimdTarget::sse42 : SimdTarget::sse2);
  EXPECT_EQ(variants[2].simd, std::nullopt);
  EXPECT_EQ(variants[3].simd, SimdTarget::portable);
  EXPECT_EQ(variants[4].simd, SimdTarget::sse2); // its own
  EXPECT_EQ(parse_instruction_set("sse2").value(), SimdTarget::sse2);
  EXPECT_EQ(parse_instruction_set("portable").error().kind, ErrorKind::usage);
  EXPECT_NE(parse_instruction_set("neon").error().message.find("'neon' is not an instruction set"), std::string::npos);
}

// Rays along -z meet the plane z = 0 where x < 0; `shift` moves what is said of the distance, and every `lie_every`-th answer is wrong.
class PlaneAccelerator : public accel::Accelerator {
 public:
  PlaneAccelerator(float shift, uint32_t lie_every) : shift_(shift), lie_every_(lie_every) {}

  accel::Hit intersect(const accel::Ray& ray) const override {
    accel::Hit hit;
    const bool lie = lie_every_ > 0 && ray.index % lie_every_ == 0;
    if ((ray.origin.x < 0.0f) == lie) return hit;
    hit.t = ray.origin.z + shift_;
    hit.instance = hit.mesh = 0;
    hit.triangle = lie_every_; // ids differ between accelerators, and must not count
    return hit;
  }
  bool occluded(const accel::Ray& ray) const override { return intersect(ray).is_hit(); }
  void intersect(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const override {
    batches.push_back(rays.size());
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = intersect(rays[i]);
  }
  void occluded(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const override {
    for (size_t i = 0; i < rays.size(); ++i) occluded[i] = this->occluded(rays[i]) ? 1 : 0;
  }
  Imath::Box3f bounds() const override { return {}; }
  accel::Statistics statistics() const override { return {}; }

  mutable std::vector<size_t> batches;

 private:
  float shift_;
  uint32_t lie_every_;
};

// Every other one of 300 rays hits.
RaySet plane_rays(const std::string& name, RayQuery query, uint32_t group) {
  RaySet set{name, query, group, {}};
  for (uint32_t i = 0; i < 300; ++i)
    set.rays.push_back({.origin = V3f(i % 2 == 0 ? -1.0f : 1.0f, 0.0f, 2.0f),
                        .direction = V3f(0.0f, 0.0f, -1.0f),
                        .t_max = kInfinity,
                        .index = i});
  return set;
}

SceneResult race(std::span<const accel::Accelerator* const> racers, const std::vector<RaySet>& sets, uint32_t repeat) {
  SceneResult result;
  result.accelerators.resize(racers.size());
  RaceSettings settings;
  settings.batch_size = 128;
  settings.repeat = repeat;
  EXPECT_TRUE(race_traversal(
      sets, racers, settings, [](const std::string&) { return true; }, result));
  return result;
}

TEST(Race, DisagreementsAreCounted) {
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

// A ray that leaves a sliver and that the watertight test lets hit it again: an accelerator that misses it is no worse. The same
// ray from a centimeter behind must hit.
TEST(Race, RoundingIsNoDisagreement) {
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
  const V3f origin(-2.19390368f, 0.110003747f, -1.25852215f), direction(-0.502367318f, 0.530064642f, -0.683124125f);
  const std::vector<accel::Ray> rays{
      {.origin = origin, .direction = direction, .t_max = kInfinity},
      {.origin = origin - direction * 0.01f, .direction = direction, .t_max = kInfinity}};
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

TEST(Race, CallsAreMadeAsSettingsSay) {
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
}

TEST(Race, EndsWhenAsked) {
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

TEST(Race, EmptySetsAreNoRace) {
  const PlaneAccelerator plane(0.0f, 0);
  const accel::Accelerator* racers[] = {&plane};
  const SceneResult result = race(racers, {{"bounce3", RayQuery::nearest, 0, {}}}, 1);
  EXPECT_EQ(result.sets.size(), 1U);
  EXPECT_TRUE(result.accelerators[0].traversal.empty());
}

TEST(Race, HeatMapHasAPixelForEachRay) {
  const PlaneAccelerator plane(0.0f, 0);
  const HeatMap map = measure_heat_map(plane, Camera(SceneCamera{}, M44f(), V2i(7, 5)));
  EXPECT_EQ(map.size_px, V2i(7, 5));
  ASSERT_EQ(map.values.size(), 35U);
  for (const float ns : map.values) EXPECT_GE(ns, 0.0f);
}

// Rays of a triangle in z = 0 through Embree's own calls too: every call answers, others have no such rows.
TEST(Race, EmbreeHasMoreCalls) {
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

// One kind of each, in seconds: what every variant took by its calls.
SceneResult timed_scene() {
  SceneResult scene;
  scene.sets = {{"camera", RayQuery::nearest, 64, 100, 0},
                {"bounce1", RayQuery::nearest, 0, 100, 0},
                {"bounce3", RayQuery::nearest, 0, 100, 0},
                {"shadow1", RayQuery::any_hit, 0, 0, 0}}; // no rays
  const auto add = [&scene](AcceleratorVariant variant, double build_s, size_t bytes) -> AcceleratorResult& {
    AcceleratorResult& result = scene.accelerators.emplace_back();
    result.variant = variant;
    result.build.many_threads_s = {build_s};
    result.build.statistics.memory_bytes = bytes;
    return result;
  };
  const auto row = [](AcceleratorResult& a, size_t set, CallForm form, double time_s) {
    a.traversal.push_back({set, form, {time_s, 2 * time_s}, 0.0, {}});
  };
  using enum CallForm;
  AcceleratorResult& robust = add({accel::Kind::embree}, 1.0, 100);
  for (const size_t set : {0, 1, 2}) row(robust, set, single, 8.0);
  row(robust, 1, stream, 4.0);
  row(robust, 1, packet, 16.0);
  AcceleratorResult& best = add({accel::Kind::embree, accel::Quality::best, false}, 8.0, 150);
  for (const size_t set : {0, 1, 2}) row(best, set, single, 2.0);
  AcceleratorResult& kdtree = add({accel::Kind::kdtree}, 4.0, 50);
  for (const size_t set : {0, 1, 2}) row(kdtree, set, single, 4.0);
  for (const size_t set : {1, 2}) row(kdtree, set, batch, 1.0);
  row(kdtree, 0, coherent, 4.0);
  return scene;
}

TEST(ShootoutSummary, TakesTheBestOfBothSides) {
  ShootoutReport report;
  report.scenes = {timed_scene()};
  const std::vector<EmbreeComparison> scene = compare_with_embree(report.scenes[0]);
  ASSERT_EQ(scene.size(), 1U);
  EXPECT_EQ(scene[0].contender, "kdtree");
  struct Expected {
    std::optional<double> robust, any;
  };
  const double root8 = std::sqrt(4.0 * 8.0); // streams at bounce1, single calls at bounce3
  const Expected expected[] = {{root8, 2.0}, {2.0, 0.5}, {2.0, 0.5}, {{}, {}}, {4.0, 4.0}, {{}, 0.5}, {0.5, 0.5}};
  ASSERT_EQ(scene[0].lines.size(), std::size(expected));
  for (size_t i = 0; i < std::size(expected); ++i) {
    const EmbreeComparisonLine& line = scene[0].lines[i];
    ASSERT_EQ(line.robust.has_value(), expected[i].robust.has_value()) << line.measure;
    ASSERT_EQ(line.any.has_value(), expected[i].any.has_value()) << line.measure;
    EXPECT_DOUBLE_EQ(line.robust.value_or(0.0), expected[i].robust.value_or(0.0)) << line.measure;
    EXPECT_DOUBLE_EQ(line.any.value_or(0.0), expected[i].any.value_or(0.0)) << line.measure;
    EXPECT_EQ(line.lower_wins, i >= 4);
  }
  // A second scene in which the kd-tree took a quarter of the time to build.
  report.scenes.push_back(timed_scene());
  report.scenes[1].accelerators[2].build.many_threads_s = {1.0};
  const std::vector<EmbreeComparison> means = compare_with_embree(report);
  EXPECT_DOUBLE_EQ(*means[0].lines[4].any, 2.0);
  EXPECT_DOUBLE_EQ(*means[0].lines[0].any, 2.0);
  EXPECT_FALSE(means[0].lines[3].any.has_value());
  const std::string text = format_comparisons(means, ", geometric means of 2 scenes");
  for (const char* words :
       {"kdtree against the best of Embree, geometric means of 2 scenes", ">= 1.3x", "<= 4.0x", "2.00x"})
    EXPECT_NE(text.find(words), std::string::npos) << words << text;

  report.scenes[0].accelerators.erase(report.scenes[0].accelerators.begin(), report.scenes[0].accelerators.begin() + 2);
  EXPECT_TRUE(compare_with_embree(report.scenes[0]).empty());
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

TEST(ShootoutReport, LeafSizesAreSummarized) {
  const LeafSizes sizes = summarize_leaf_sizes({0, 3, 1, 0, 4, 0, 0}); // 21 references in 8 leaves
  EXPECT_DOUBLE_EQ(sizes.mean, 21.0 / 8.0);
  EXPECT_EQ(sizes.median, 2U);
  EXPECT_EQ(sizes.max, 4U);
  const std::string svg = draw_leaf_sizes({0, 3, 1, 0, 4, 1, 1}, 0, 5);
  EXPECT_NE(svg.find("<title>4: 4 leaves</title>"), std::string::npos) << svg;
  EXPECT_NE(svg.find("<title>5 or more: 2 leaves</title>"), std::string::npos) << svg;
}

// A report with names that a careless format would trip over.
ShootoutReport small_report(size_t scenes) {
  const PlaneAccelerator a(0.0f, 0), b(0.0f, 10);
  const accel::Accelerator* racers[] = {&a, &b};
  ShootoutReport report;
  report.command_line = "kindling shootout '<b>.glb'";
  report.repeat = 3;
  for (size_t s = 0; s < scenes; ++s) {
    SceneResult scene = race(racers, {plane_rays("camera", RayQuery::nearest, 64)}, 3);
    scene.file = s == 0 ? "a \"b\", <c> & d.glb" : "other.glb";
    scene.triangle_count = 100 * (s + 1);
    scene.accelerators[1].variant.kind = accel::Kind::kdtree;
    for (AcceleratorResult& result : scene.accelerators) {
      result.build.one_thread_s = {0.25, 0.5, 0.75};
      result.build.many_threads_s = {0.125};
      result.heat_map = {V2i(2, 2), {0.0f, 10.0f, 20.0f, 30.0f}};
    }
    report.scenes.push_back(std::move(scene));
  }
  return report;
}

TEST(ShootoutReport, JsonHoldsWhatWasMeasured) {
  const auto json = nlohmann::json::parse(format_shootout_json(small_report(1)));
  const auto& scene = json["scenes"][0];
  EXPECT_EQ(scene["file"], "a \"b\", <c> & d.glb");
  EXPECT_EQ(scene["accelerators"][0]["build"]["one_thread"]["median_s"], 0.5);
  EXPECT_TRUE(scene["accelerators"][0]["build_peak_bytes"].is_null());
  EXPECT_EQ(scene["accelerators"][1]["traversal"][0]["disagreements"]["hit_or_miss"], 30);
  EXPECT_EQ(json["traversal_threads"], 1);
}

TEST(ShootoutReport, DisagreementsAreExplained) {
  ShootoutReport report = small_report(1);
  SceneResult& scene = report.scenes[0];
  const std::string robust = format_scene_tables(report, scene);
  EXPECT_NE(robust.find("0 disagreements with single calls of embree among 900 answers (0 hit or miss, 0 distance)\n"),
            std::string::npos)
      << robust;
  EXPECT_NE(robust.find("kdtree: 90 disagreements with single calls of embree among 900 answers (90 hit or miss, 0 "
                        "distance), 90 of them at an edge of a triangle\n"),
            std::string::npos)
      << robust;
  scene.accelerators[1].variant = {accel::Kind::embree, accel::Quality::balanced, false};
  EXPECT_NE(format_scene_tables(report, scene)
                .find("90 of them at an edge of a triangle; rays slip through edges where it is not robust\n"),
            std::string::npos);
}

TEST(ShootoutReport, CsvQuotesFields) {
  std::istringstream csv(format_shootout_csv(small_report(1)));
  std::string heading, row;
  std::getline(csv, heading);
  std::getline(csv, row);
  EXPECT_TRUE(row.starts_with("\"a \"\"b\"\", <c> & d.glb\",100,0,embree,camera,nearest,single,300,")) << row;
}

TEST(ShootoutReport, PageIsEscapedAndCompleteInItself) {
  const std::string page = format_shootout_html(small_report(2));
  EXPECT_NE(page.find("a &quot;b&quot;, &lt;c&gt; &amp; d.glb"), std::string::npos);
  EXPECT_EQ(page.find("<b>.glb"), std::string::npos);
  EXPECT_NE(page.find("Build time against triangles"), std::string::npos);
  EXPECT_EQ(format_shootout_html(small_report(1)).find("Build time against triangles"), std::string::npos);
  for (const char* external : {"http:", "https:", "<link", "<script", "url(", "href="})
    EXPECT_EQ(page.find(external), std::string::npos) << external;
  for (size_t at = page.find("src=\""); at != std::string::npos; at = page.find("src=\"", at + 1))
    EXPECT_EQ(page.compare(at + 5, 15, "data:image/png;"), 0);
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(Plots, AxisSteps) {
  EXPECT_EQ(axis_step(0.0), 1.0);
  EXPECT_DOUBLE_EQ(axis_step(10.0), 2.0);
  EXPECT_DOUBLE_EQ(axis_step(4.0), 1.0);
  EXPECT_DOUBLE_EQ(axis_step(0.3), 0.05);
  EXPECT_DOUBLE_EQ(axis_step(799.0), 100.0);
  for (double largest = 1e-3; largest < 1e5; largest *= 1.37) {
    const double steps = largest / axis_step(largest);
    EXPECT_GE(steps, 4.0 - 1e-9) << largest;
    EXPECT_LE(steps, 10.0 + 1e-9) << largest;
  }
}

class Images : public SceneFolder {};

TEST_F(Images, PngIsReadBack) {
  // Larger than one stored block of 65535 bytes.
  const int width = 301, height = 257;
  std::vector<uint8_t> pixels;
  for (int i = 0; i < width * height; ++i) pixels.push_back(static_cast<uint8_t>(i * 7 + i / width));
  Palette palette;
  for (size_t i = 0; i < 256; ++i)
    palette[i] = {static_cast<uint8_t>(i), static_cast<uint8_t>(255 - i), static_cast<uint8_t>(i / 2)};
  write_file("a.png", encode_indexed_png(pixels, width, height, palette));
  const Result<Image> image = read_image_file(folder_ / "a.png");
  ASSERT_TRUE(image.ok()) << image.error().message;
  ASSERT_EQ(image.value().width, width);
  ASSERT_EQ(image.value().height, height);
  ASSERT_EQ(image.value().channels, 3);
  ASSERT_EQ(image.value().type, PixelType::u8);
  for (size_t i = 0; i < pixels.size(); ++i)
    for (size_t k = 0; k < 3; ++k)
      ASSERT_EQ(static_cast<uint8_t>(image.value().pixels[3 * i + k]), palette[pixels[i]][k]) << i;
}

TEST(Images64, Base64) {
  EXPECT_EQ(encode_base64(""), "");
  EXPECT_EQ(encode_base64("f"), "Zg==");
  EXPECT_EQ(encode_base64("fo"), "Zm8=");
  EXPECT_EQ(encode_base64("foo"), "Zm9v");
  EXPECT_EQ(encode_base64("foobar"), "Zm9vYmFy"); // RFC 4648, section 10
  EXPECT_EQ(encode_base64("\xff\xfe\xfd"), "//79");
}

} // namespace
} // namespace kindling::test
