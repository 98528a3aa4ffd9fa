// Plugins through the C interface: their adapter, and the compressed wide BVH against brute force.
// SPDX-License-Identifier: Apache-2.0
#include "accel/make_accelerator.h"
#include "accel/plugin/load_plugin.h"
#include "accel/rounding.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

const AcceleratorPlugin& plugin(const std::string& file) {
  std::string error;
  static std::map<std::string, std::unique_ptr<AcceleratorPlugin>> plugins;
  std::unique_ptr<AcceleratorPlugin>& found = plugins[file];
  if (!found) found = AcceleratorPlugin::open(file, error);
  EXPECT_TRUE(found) << file << " " << error;
  return *found;
}

class Plugins : public ::testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] std::unique_ptr<PluginAccelerator> build(const TestScene& scene, int threads = 1,
                                                         const std::string& options = {}) const {
    PluginBuild built = plugin(GetParam()).build(scene.input(), threads, options);
    EXPECT_TRUE(built.accelerator) << built.error;
    return std::move(built.accelerator);
  }

  // Compares all queries with brute force; differences must be those of rounding. The share that
  // is not must not exceed `tolerated`.
  void compare_all(const std::string& name, const TestScene& scene, const std::vector<Ray>& rays,
                   double tolerated = 0.0) const {
    SCOPED_TRACE(name);
    const auto oracle = make_accelerator(Kind::brute_force, scene.input());
    const auto tested = build(scene);
    ASSERT_TRUE(tested);
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    tested->intersect(rays, hits);
    tested->occluded(rays, blocked);
    size_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const Hit expected = oracle->intersect(rays[i]);
      const bool same = hits[i].is_hit() == expected.is_hit() && (!expected.is_hit() || hits[i].t == expected.t);
      const bool right = (same || rounding_explains(scene.input(), rays[i], expected, hits[i])) &&
                         (blocked[i] != 0) == hits[i].is_hit();
      const Hit single = tested->intersect(rays[i]);
      EXPECT_EQ(single.is_hit(), hits[i].is_hit());
      if (single.is_hit()) {
        EXPECT_EQ(single, hits[i]);
      }
      if (right) continue;
      if (++wrong <= 2 && tolerated == 0.0)
        ADD_FAILURE() << "o " << rays[i].origin << " d " << rays[i].direction << " (" << rays[i].t_min << ", "
                      << rays[i].t_max << "]: expected " << expected.t << (expected.is_hit() ? "" : " miss")
                      << ", found " << hits[i].t << (hits[i].is_hit() ? "" : " miss") << ", blocked "
                      << int{blocked[i]};
    }
    EXPECT_LE(static_cast<double>(wrong), tolerated * static_cast<double>(rays.size()));
    EXPECT_EQ(tested->failure(), "");
  }
};

std::vector<Ray> all_rays(const TestScene& scene, int count) {
  Rng rng(17);
  std::vector<Ray> rays = random_rays(rng, scene.bounds(), count);
  for (const auto& more : {axis_parallel_rays(rng, scene, count), grazing_rays(rng, scene, count)})
    rays.insert(rays.end(), more.begin(), more.end());
  return rays;
}

TEST_P(Plugins, AdversarialScenes) {
  for (const NamedScene& named : adversarial_scenes())
    compare_all(named.name, named.scene, all_rays(named.scene, static_cast<int>(trials("KINDLING_PLUGIN_RAYS", 600))));
}

TEST_P(Plugins, HostileScenes) {
  for (const NamedScene& named : hostile_scenes()) {
    Rng rng(5);
    compare_all(named.name, named.scene, aimed_rays(rng, named.scene, 1000));
  }
}

TEST_P(Plugins, Instances) {
  Rng rng(3);
  TestScene scene;
  const uint32_t first = scene.add_group({sphere(8, 16, 1.0f, V3f(0)), terrain(6, 2.0f, 0.5f)});
  const uint32_t second = scene.add_group({gridded_box(3, V3f(-1), V3f(1))});
  scene.add_instance(second, M44f());
  for (int i = 0; i < 60; ++i) {
    const float wide = uniform(rng, 0.2f, 2.0f), high = uniform(rng, 0.2f, 2.0f), angle = uniform(rng, 0.0f, 6.0f);
    const V3f axis = uniform_direction(rng);
    const V3f translation = uniform_direction(rng) * 10.0f;
    scene.add_instance(i % 3 == 0 ? second : first,
                       placed(V3f(wide, high, i % 5 == 0 ? -1.0f : 1.0f), axis, angle, translation));
  }
  M44f flat;
  flat.setScale(V3f(1, 1, 0)); // nothing of it is hit
  scene.add_instance(first, flat);
  compare_all("instances", scene, random_rays(rng, scene.bounds(), 4000));
}

// Rays from inside of closed meshes, at their vertices, edges and along axes.
TEST_P(Plugins, NoRayLeavesAClosedMesh) {
  Rng rng(71);
  for (const V3f& center : {V3f(0), V3f(3.3f, -7.7f, 5.1f)})
    for (const Mesh& mesh : {sphere(24, 48, 1.0f, center), gridded_box(8, center - V3f(1), center + V3f(1))}) {
      const TestScene scene(mesh);
      const auto accelerator = build(scene);
      size_t leaks = 0;
      const size_t count = trials("KINDLING_PLUGIN_RAYS", 60000);
      for (size_t i = 0; i < count; ++i) {
        const auto triangle = static_cast<uint32_t>(rng() % (mesh.indices.size() / 3));
        const V3f a = mesh.corner(triangle, 0), b = mesh.corner(triangle, 1);
        Ray ray;
        ray.origin = center + (i % 5 == 0 ? V3f(0) : uniform_direction(rng) * 0.5f);
        ray.direction = (i % 2 == 0 ? a : a + (b - a) * uniform(rng)) - ray.origin;
        if (i % 7 == 0) {
          const auto axis = static_cast<int>(i % 3);
          ray.direction = V3f(0);
          ray.direction[axis] = i % 14 == 0 ? 1.0f : -1.0f;
        }
        ray.t_max = kInfinity;
        leaks += accelerator->intersect(ray).is_hit() && accelerator->occluded(ray) ? 0 : 1;
      }
      EXPECT_EQ(leaks, 0U);
    }
}

TEST_P(Plugins, ThreadsDoNotChangeHits) {
  Rng rng(9);
  const TestScene scene(triangle_soup(rng, 30000, 10.0f, 0.3f));
  const auto one = build(scene, 1), many = build(scene, 8);
  const std::vector<Ray> rays = random_rays(rng, scene.bounds(), 3000);
  for (const Ray& ray : rays) {
    const Hit a = one->intersect(ray), b = many->intersect(ray);
    ASSERT_EQ(a.is_hit(), b.is_hit());
    if (a.is_hit()) {
      ASSERT_EQ(a, b);
    }
  }
}

TEST_P(Plugins, LeafSizesDoNotChangeHits) {
  Rng rng(9);
  const TestScene scene(triangle_soup(rng, 3000, 10.0f, 0.5f));
  const auto four = build(scene, 1, "leaf=4"), one = build(scene, 1, "leaf=1");
  for (const Ray& ray : random_rays(rng, scene.bounds(), 3000)) {
    const Hit a = four->intersect(ray), b = one->intersect(ray);
    ASSERT_EQ(a.is_hit(), b.is_hit());
    if (a.is_hit()) {
      ASSERT_EQ(a.t, b.t);
    }
  }
  EXPECT_GT(one->statistics().leaf_count, four->statistics().leaf_count);
  EXPECT_EQ(one->statistics().reference_count, 3000U);
  const PluginBuild refused = plugin(GetParam()).build(scene.input(), 1, "leaf=9");
  EXPECT_FALSE(refused.accelerator);
  EXPECT_EQ(refused.error, "unknown options 'leaf=9'; use leaf=1 to leaf=4");
}

INSTANTIATE_TEST_SUITE_P(CompressedBvh, Plugins,
                         ::testing::Values(KINDLING_COMPRESSED_BVH, KINDLING_COMPRESSED_BVH_PORTABLE),
                         [](const auto& tested) { return std::string(tested.index == 0 ? "native" : "portable"); });

TEST(LoadPlugin, RefusesMotion) {
  const TestScene scene(sphere(4, 8, 1.0f, V3f(0)));
  const std::vector<Instance> instances{{0, M44f(), 0}};
  const std::vector<M44f> keys(2);
  const std::vector<std::span<const M44f>> motions{keys};
  BuildInput input = scene.input();
  input.instances = InstanceList(instances);
  input.motions = motions;
  const PluginBuild moving = plugin(KINDLING_COMPRESSED_BVH).build(input, 1, "");
  EXPECT_FALSE(moving.accelerator);
  EXPECT_EQ(moving.error, "instance 0 moves, and plugins know no motion");
}

TEST(LoadPlugin, RefusesFilesThatAreNoLibraries) {
  std::string error;
  EXPECT_FALSE(AcceleratorPlugin::open("no such file", error));
  EXPECT_NE(error.find("cannot be opened: "), std::string::npos) << error;
  EXPECT_FALSE(AcceleratorPlugin::open("libm.so.6", error)) << "found in the folders of the system";
}

TEST(LoadPlugin, ReportsStatistics) {
  const AcceleratorPlugin& bvh = plugin(KINDLING_COMPRESSED_BVH);
  EXPECT_EQ(bvh.version(), 1U);
  EXPECT_NE(bvh.description().find("8-wide BVH with compressed nodes"), std::string::npos);
  const TestScene scene(sphere(8, 16, 2.0f, V3f(1, 0, 0)));
  const PluginBuild built = bvh.build(scene.input(), 1, "");
  ASSERT_TRUE(built.accelerator) << built.error;
  const Statistics statistics = built.accelerator->statistics();
  EXPECT_EQ(statistics.triangle_count, scene.mesh(0).indices.size() / 3);
  EXPECT_EQ(statistics.instance_count, 1U);
  EXPECT_GT(statistics.memory_bytes, 0U);
  EXPECT_NEAR(built.accelerator->bounds().max.x, 3.0f, 1e-3f);
}

} // namespace
} // namespace kindling::accel::testing
