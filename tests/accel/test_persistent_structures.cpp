// Tests of persistent structures: split worlds, reuse by the next build, and no wrong reuse.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kdtree_accelerator.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"
#include "tests/accel/compact_copy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <span>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

bool accept_by_hash(const void*, const Ray& ray, const Hit& candidate) {
  uint32_t h = ray.key * 2654435761U ^ candidate.triangle * 40503U ^ candidate.mesh * 97U ^ candidate.instance * 31U;
  h ^= h >> 15;
  return (h & 3) != 0;
}

M44f translated(const V3f& by) {
  M44f m;
  m.setTranslation(by);
  return m;
}

// Build input over arrays that other inputs may share.
struct Input {
  std::vector<TriangleMesh> meshes;
  std::vector<MeshGroup> groups;
  std::vector<Instance> instances;
  std::vector<std::span<const M44f>> motions;
  HitFilter filter;

  explicit Input(const TestScene& scene) {
    const BuildInput input = scene.input();
    meshes.assign(input.meshes.begin(), input.meshes.end());
    groups.assign(input.groups.begin(), input.groups.end());
    for (size_t i = 0; i < input.instances.size(); ++i) instances.push_back(input.instances[i]);
    motions.assign(input.motions.begin(), input.motions.end());
    filter = input.filter;
  }
  [[nodiscard]] BuildInput view() const { return {meshes, groups, instances, motions, filter}; }
};

std::unique_ptr<Accelerator> build(Kind kind, const Input& input,
                                   std::unique_ptr<PersistentStructures> structures = nullptr,
                                   const BuildOptions& options = {}) {
  return make_accelerator(kind, input.view(), options, std::move(structures));
}

// Returns intersecting spheres, a soup and cut-outs, a group that is placed twice, and one that
// moves.
TestScene mixed_scene() {
  Rng rng(7);
  Mesh leaves = triangle_soup(rng, 400, 1.2f, 0.3f), pile = coplanar_pile(rng, 100);
  leaves.opaque = pile.opaque = false;
  TestScene scene;
  const uint32_t world = scene.add_group({sphere(12, 24, 0.8f, V3f(0)), leaves, sphere(10, 20, 0.7f, V3f(0.5f, 0, 0)),
                                          triangle_soup(rng, 300, 1.0f, 0.2f), pile});
  const uint32_t placed = scene.add_group({gridded_box(4, V3f(-0.3f), V3f(0.3f)), sphere(6, 12, 0.2f, V3f(0.4f))});
  const uint32_t moving = scene.add_group({sphere(8, 16, 0.3f, V3f(0))});
  scene.add_instance(world, M44f());
  scene.add_instance(placed, translated({1.5f, 0, 0}));
  scene.add_instance(placed, translated({0, 1.2f, 0.3f}));
  scene.add_instance(moving, {translated({-1, -1, 0}), translated({1, -1, 0.5f})});
  scene.set_filter({accept_by_hash, nullptr});
  return scene;
}

std::vector<Ray> rays_through(const TestScene& scene, size_t count) {
  Rng rng(11);
  std::vector<Ray> rays = random_rays(rng, scene.bounds(), static_cast<int>(count));
  const std::vector<Ray> axial = axis_parallel_rays(rng, scene, static_cast<int>(count / 4));
  rays.insert(rays.end(), axial.begin(), axial.end());
  for (Ray& ray : rays) {
    ray.key = static_cast<uint32_t>(rng());
    ray.time = uniform(rng);
    if (rng() % 3 == 0) ray.t_max = kInfinity;
  }
  return rays;
}

size_t different(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i)
    count += a[i].is_hit() != b[i].is_hit() || (a[i].is_hit() && std::memcmp(&a[i], &b[i], sizeof(Hit)) != 0) ? 1 : 0;
  return count;
}

struct Answers {
  std::vector<Hit> single, batch, coherent;
  std::vector<uint8_t> blocked, blocked_batch, blocked_coherent;

  Answers(const Accelerator& accelerator, const std::vector<Ray>& rays)
      : batch(rays.size()), coherent(rays.size()), blocked_batch(rays.size()), blocked_coherent(rays.size()) {
    for (const Ray& ray : rays) {
      single.push_back(accelerator.intersect(ray));
      blocked.push_back(accelerator.occluded(ray) ? 1 : 0);
    }
    accelerator.intersect(rays, batch);
    accelerator.occluded(rays, blocked_batch);
    accelerator.intersect_coherent(rays, coherent);
    accelerator.occluded_coherent(rays, blocked_coherent);
    if (view_of(accelerator) != nullptr) expect_same_by_compact_queries(accelerator, rays);
  }

 private:
  void expect_same_by_compact_queries(const Accelerator& accelerator, const std::vector<Ray>& rays) const {
    const CompactCopy queries(accelerator);
    std::vector<Hit> compact;
    std::vector<uint8_t> blocked_compact;
    for (const Ray& ray : rays) {
      compact.push_back(queries.intersect(ray));
      blocked_compact.push_back(queries.occluded(ray) ? 1 : 0);
    }
    EXPECT_EQ(different(compact, single), 0U);
    EXPECT_EQ(blocked_compact, blocked);
  }
};

void expect_same(const Answers& a, const Answers& b) {
  EXPECT_EQ(different(a.single, b.single), 0U);
  EXPECT_EQ(different(a.batch, b.batch), 0U);
  EXPECT_EQ(different(a.coherent, b.coherent), 0U);
  EXPECT_EQ(a.blocked, b.blocked);
  EXPECT_EQ(a.blocked_batch, b.blocked_batch);
  EXPECT_EQ(a.blocked_coherent, b.blocked_coherent);
}

class ReusedStructures : public ::testing::TestWithParam<Kind> {};

// Every split of the world's five meshes must match the oracle.
TEST_P(ReusedStructures, SplitWorldsMatchOracle) {
  if (GetParam() == Kind::brute_force) return;
  const TestScene scene = mixed_scene();
  const auto oracle = build(Kind::brute_force, Input(scene));
  const std::vector<Ray> rays = rays_through(scene, 600);
  const auto whole = build(GetParam(), Input(scene));
  const Answers expected(*oracle, rays), in_one(*whole, rays);
  for (uint32_t division = 0; division < 32; ++division) {
    SCOPED_TRACE(division);
    Input input(scene);
    for (uint32_t m = 0; m < 5; ++m) input.meshes[m].persistent_id = (division >> m & 1U) != 0 ? m + 1 : 0;
    const auto accelerator = build(GetParam(), input);
    const Answers answers(*accelerator, rays);
    EXPECT_EQ(accelerator->bounds(), whole->bounds());
    EXPECT_EQ(accelerator->statistics().triangle_count, whole->statistics().triangle_count);
    EXPECT_EQ(different(answers.single, answers.batch), 0U);
    EXPECT_EQ(answers.blocked, answers.blocked_batch);
    for (size_t i = 0; i < rays.size(); ++i) {
      EXPECT_EQ(disagreement(scene, rays[i], expected.single[i], answers.single[i]), "");
      EXPECT_EQ(disagreement(scene, rays[i], expected.single[i], answers.coherent[i]), "");
      EXPECT_EQ(answers.blocked[i] != 0, answers.single[i].is_hit());
    }
    if (GetParam() != Kind::kdtree) continue;
    EXPECT_EQ(answers.blocked, in_one.blocked);
    EXPECT_EQ(different(answers.single, in_one.single), 0U);
  }
}

// The same triangles in both parts of a world, some behind a filter: at equal distance the smallest
// ids win.
TEST(PersistentTrees, TiesGoToTheSmallestIds) {
  for (const bool opaque : {true, false}) {
    Rng rng(3);
    const Mesh pile = coplanar_pile(rng, 60), soup = triangle_soup(rng, 60, 1.0f, 0.8f);
    Mesh pile_again = pile, soup_again = soup;
    pile_again.opaque = opaque;
    TestScene scene;
    scene.add_instance(scene.add_group({pile, soup, pile_again, soup_again, pile, soup}), M44f());
    scene.add_instance(0, translated({0, 0, 0})); // the same instance again
    scene.set_filter({accept_by_hash, nullptr});
    const std::vector<Ray> rays = rays_through(scene, 1000);
    const Answers expected(*build(Kind::brute_force, Input(scene)), rays);
    size_t hits = 0;
    for (const Hit& hit : expected.single) hits += hit.is_hit() ? 1 : 0;
    ASSERT_GT(hits, rays.size() / 8);
    for (uint32_t division = 0; division < 64; ++division) {
      SCOPED_TRACE(division);
      Input input(scene);
      for (uint32_t m = 0; m < 6; ++m) input.meshes[m].persistent_id = (division >> m & 1U) != 0 ? m + 1 : 0;
      const Answers answers(*build(Kind::kdtree, input), rays);
      EXPECT_EQ(different(answers.single, expected.single), 0U);
      EXPECT_EQ(different(answers.batch, expected.single), 0U);
      EXPECT_EQ(answers.blocked_batch, expected.blocked);
    }
  }
}

// All instruction sets give equal answers in a split world.
TEST(PersistentTrees, AllKernelsAgree) {
  const TestScene scene = mixed_scene();
  const std::vector<Ray> rays = rays_through(scene, 800);
  Input input(scene);
  input.meshes[0].persistent_id = 1;
  input.meshes[1].persistent_id = 2;
  BuildOptions options;
  options.simd = SimdTarget::portable;
  const Answers expected(*build(Kind::kdtree, input, nullptr, options), rays);
  for (const SimdTarget target : simd_targets()) {
    options.simd = target;
    expect_same(Answers(*build(Kind::kdtree, input, nullptr, options), rays), expected);
  }
}

// Every crossing of a split world, by all instruction sets.
TEST(PersistentTrees, CrossingsEqualBruteForce) {
  const TestScene scene = mixed_scene();
  const std::vector<Ray> rays = rays_through(scene, 500);
  Input input(scene);
  const auto oracle = build(Kind::brute_force, input);
  size_t found = 0;
  for (const SimdTarget target : simd_targets())
    for (const uint32_t division : {0b000001U, 0b010010U, 0b101100U, 0b111110U}) {
      for (uint32_t m = 0; m < 6; ++m) input.meshes[m].persistent_id = (division >> m & 1U) != 0 ? m + 1 : 0;
      BuildOptions options;
      options.simd = target;
      const auto split = build(Kind::kdtree, input, nullptr, options);
      for (const Ray& ray : rays) {
        std::vector<Crossing> expected, crossings;
        ASSERT_TRUE(oracle->all_hits(ray, kNoLimit, expected));
        ASSERT_TRUE(split->all_hits(ray, kNoLimit, crossings));
        ASSERT_EQ(crossings, expected) << division << " " << simd_target_name(target);
        found += crossings.size();
      }
    }
  EXPECT_GT(found, rays.size());
}

TEST(PersistentTrees, TraversalCostCountsBothTrees) {
  const TestScene scene = mixed_scene();
  Input input(scene);
  input.meshes[0].persistent_id = 1;
  const auto split = build(Kind::kdtree, input);
  for (const Ray& ray : rays_through(scene, 500)) {
    const std::optional<TraversalCost> cost = split->traversal_cost(ray, false);
    ASSERT_TRUE(cost.has_value());
    EXPECT_LE(split->intersect(ray).is_hit() ? 1U : 0U, cost->triangles);
  }
}

size_t triangles_of(const Input& input, const std::vector<size_t>& meshes) {
  size_t count = 0;
  for (const size_t m : meshes) count += input.meshes[m].triangle_count();
  return count;
}

// A sequence in which one mesh of the world moves, and is removed in every other frame, so that
// indices change.
TEST_P(ReusedStructures, AreReusedByNextBuild) {
  const TestScene scene = mixed_scene();
  const std::vector<Ray> rays = rays_through(scene, 500);
  std::unique_ptr<PersistentStructures> structures;
  std::vector<V3f> moved(scene.mesh(3).positions);
  moved.reserve(moved.size() + 2);
  for (int frame = 0; frame < 6; ++frame) {
    SCOPED_TRACE(frame);
    for (V3f& p : moved) p.y += 0.1f;
    Input input(scene);
    for (const size_t m : {0, 1, 2, 4, 5, 6, 7}) input.meshes[m].persistent_id = m + 1;
    input.meshes[3].positions = moved;
    size_t changing = input.meshes[3].triangle_count();
    if (frame % 2 == 1) { // mesh 3 is removed, and later meshes are renumbered
      input.meshes.erase(input.meshes.begin() + 3);
      --input.groups[0].mesh_count;
      --input.groups[1].first_mesh;
      --input.groups[2].first_mesh;
      changing = 0;
    }
    input.instances[2].object_to_world[3][0] += 0.1f * static_cast<float>(frame);
    auto accelerator = build(GetParam(), input, std::move(structures));
    const auto fresh = build(GetParam(), input);
    const size_t all =
        triangles_of(input, {0, 1, 2, 3, 4, 5, 6}) + (frame % 2 == 0 ? input.meshes[7].triangle_count() : 0);
    EXPECT_EQ(fresh->statistics().built_triangle_count, all);
    EXPECT_EQ(accelerator->statistics().built_triangle_count,
              frame == 0 || GetParam() == Kind::brute_force ? all : changing);
    EXPECT_EQ(accelerator->statistics().triangle_count, fresh->statistics().triangle_count);
    EXPECT_EQ(accelerator->bounds(), fresh->bounds());
    expect_same(Answers(*accelerator, rays), Answers(*fresh, rays));
    structures = accelerator->take_structures();
    EXPECT_EQ(structures != nullptr, GetParam() != Kind::brute_force);
  }
}

// Changed structures are rebuilt, and the result is correct.
TEST_P(ReusedStructures, AreNotReusedForChangedInput) {
  if (GetParam() == Kind::brute_force) return;
  const TestScene scene = mixed_scene();
  const std::vector<Ray> rays = rays_through(scene, 400);
  Input whole(scene);
  for (size_t m = 0; m < whole.meshes.size(); ++m) whole.meshes[m].persistent_id = m + 1;
  const size_t world = triangles_of(whole, {0, 1, 2, 3, 4}), placed = triangles_of(whole, {5, 6}),
               moving = triangles_of(whole, {7});
  struct Case {
    const char* name;
    std::function<void(Input&, BuildOptions&)> change;
    size_t built;
  };
  const Case cases[] = {
      {"nothing", [](Input&, BuildOptions&) {}, 0},
      {"opacity", [](Input& i, BuildOptions&) { i.meshes[0].opaque = false; }, world},
      {"opacity of a group", [](Input& i, BuildOptions&) { i.meshes[6].opaque = false; }, placed},
      {"another mesh", [](Input& i, BuildOptions&) { i.meshes[7].persistent_id = 99; }, moving},
      {"not persistent", [](Input& i, BuildOptions&) { i.meshes[7].persistent_id = 0; }, moving},
      {"order", [](Input& i, BuildOptions&) { std::swap(i.meshes[0], i.meshes[1]); }, world},
      {"quality", [](Input&, BuildOptions& o) { o.quality = Quality::fast; }, world + placed + moving},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name);
    Input input = whole;
    BuildOptions options;
    one.change(input, options);
    auto first = build(GetParam(), whole);
    auto structures = first->take_structures();
    first.reset();
    const auto accelerator = build(GetParam(), input, std::move(structures), options);
    EXPECT_EQ(accelerator->statistics().built_triangle_count, one.built);
    expect_same(Answers(*accelerator, rays), Answers(*build(GetParam(), input, nullptr, options), rays));
  }
  // Structures of another kind, without the filter, or not robust are not reused.
  const Kind other = GetParam() == Kind::kdtree ? Kind::embree : Kind::kdtree;
  EXPECT_EQ(build(other, whole, build(GetParam(), whole)->take_structures())->statistics().built_triangle_count,
            world + placed + moving);
  if (GetParam() != Kind::embree) return;
  BuildOptions options;
  options.robust = false;
  EXPECT_EQ(build(Kind::embree, whole, build(Kind::embree, whole)->take_structures(), options)
                ->statistics()
                .built_triangle_count,
            world + placed + moving);
  Input unfiltered = whole;
  unfiltered.filter = {};
  EXPECT_EQ(
      build(Kind::embree, unfiltered, build(Kind::embree, whole)->take_structures())->statistics().built_triangle_count,
      world + placed + moving);
}

// The accelerator may be destroyed before or after the structures taken from it.
TEST_P(ReusedStructures, OutliveTheirAccelerator) {
  const TestScene scene = mixed_scene();
  Input input(scene);
  input.meshes[0].persistent_id = 1;
  for (const bool first : {true, false}) {
    auto accelerator = build(GetParam(), input);
    auto structures = accelerator->take_structures();
    if (first) accelerator.reset();
    structures.reset();
  }
  // No mesh is persistent.
  EXPECT_EQ(build(GetParam(), Input(scene))->take_structures(), nullptr);
}

// Structures that are not reused are freed.
TEST_P(ReusedStructures, AreFreedIfUnused) {
  const TestScene scene = mixed_scene();
  std::unique_ptr<PersistentStructures> structures;
  std::vector<size_t> bytes;
  for (uint64_t frame = 0; frame < 20; ++frame) {
    Input input(scene);
    for (size_t m = 0; m < input.meshes.size(); ++m) input.meshes[m].persistent_id = m + 1;
    input.meshes[7].persistent_id = 100 + frame; // a new id each time
    auto accelerator = build(GetParam(), input, std::move(structures));
    bytes.push_back(accelerator->statistics().memory_bytes);
    structures = accelerator->take_structures();
  }
  // Embree's count includes rounding by its allocators.
  EXPECT_LE(bytes.back(), bytes[1] + bytes[1] / 100);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ReusedStructures, ::testing::ValuesIn(kAllKinds), kind_label);

} // namespace
} // namespace kindling::accel::testing
