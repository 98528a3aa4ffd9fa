// Batches of rays on the host device: the answers of the kd-tree, for all kinds of scenes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/rays_on_device.h"

#include "renderer/device/host_device.h"
#include "tests/accel/accel_scenes.h"
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/motion_scenes.h"
#include "tests/device/tested_device.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

namespace at = accel::testing;

// Compares both queries; the hits must be those of single rays on the CPU, bit for bit. Returns how
// many rays hit.
size_t compare(RaysOnDevice& on_device, const accel::Accelerator& tree, const std::vector<accel::Ray>& rays) {
  on_device.set_rays(rays);
  on_device.find_nearest_hits();
  on_device.find_any_hits();
  std::vector<accel::Hit> hits(rays.size());
  std::vector<uint32_t> are_blocked(rays.size());
  on_device.copy_hits(hits);
  on_device.copy_blocked(are_blocked);
  size_t count = 0, different = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const accel::Hit expected = tree.intersect(rays[i]);
    count += expected.is_hit() ? 1 : 0;
    const bool same = expected.is_hit() ? hits[i] == expected : !hits[i].is_hit();
    different += same && (are_blocked[i] == 1) == tree.occluded(rays[i]) ? 0 : 1;
  }
  EXPECT_EQ(different, 0U);
  return count;
}

TEST(RaysOnDevice, AnswersAreThoseOfTheTree) {
  const std::unique_ptr<Device> device = make_tested_device(2);
  size_t hits = 0, scenes = 0;
  for (uint32_t seed = 1; scenes < 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    at::Rng rng(seed);
    const bool moves = seed % 2 == 0;
    const at::TestScene scene = moves ? at::random_motion(rng, 60) : at::random_scene(rng, 60);
    if (scene.input().filter.accept != nullptr) continue;
    ++scenes;
    std::unique_ptr<accel::Accelerator> tree = at::build(accel::Kind::kdtree, scene);
    ASSERT_TRUE(check_device_rays(*tree).ok());
    std::vector<accel::Ray> rays = at::aimed_rays(rng, moves ? scene.posed(0.5f) : scene, 300);
    for (accel::Ray& ray : rays) ray.time = at::uniform(rng);
    RaysOnDevice on_device(*device, *tree);
    EXPECT_GT(on_device.tree_bytes(), 0U);
    hits += compare(on_device, *tree, rays);
    rays.resize(7); // another batch on the same tree
    hits += compare(on_device, *tree, rays);
  }
  EXPECT_GT(hits, 1000U);
}

TEST(RaysOnDevice, NoRaysAreNoError) {
  const std::unique_ptr<Device> device = make_host_device(1);
  const at::TestScene scene(at::sphere(4, 8, 1.0f, Imath::V3f(0.0f)));
  RaysOnDevice on_device(*device, *at::build(accel::Kind::kdtree, scene));
  on_device.set_rays({});
  on_device.find_nearest_hits();
  on_device.find_any_hits();
  on_device.copy_hits({});
}

TEST(RaysOnDevice, RefusesOtherAcceleratorsAndCutOuts) {
  at::TestScene scene(at::sphere(4, 8, 1.0f, Imath::V3f(0.0f)));
  const Result<void> other = check_device_rays(*at::build(accel::Kind::embree, scene));
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().message, "a device traces rays with the kd-tree alone; use --accel kdtree");
  scene.set_filter({.accept = [](const void*, const accel::Ray&, const accel::Hit&) { return false; }});
  const Result<void> cut = check_device_rays(*at::build(accel::Kind::kdtree, scene));
  ASSERT_FALSE(cut.ok());
  EXPECT_NE(cut.error().message.find("cut-outs"), std::string::npos);
}

} // namespace
} // namespace kindling::test
