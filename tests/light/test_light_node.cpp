// Tests of LightNode: conservative rounding, and profiles of families against sums of members.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_node.h"

#include "renderer/light/light_tree.h"
#include "tests/light/light_soup.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Random;
using test::random_direction;
using test::random_point;

TEST(LightNode, RoundedBoundsContainOriginals) {
  Random random(51);
  for (int round = 0; round < 500; ++round) {
    // From clusters of a millimeter to a kilometer away from the origin, with members up to the
    // size of the cluster.
    const float extent = std::pow(10.0f, -3.0f + 6.0f * random.next_1d());
    const V3f far = random_point(random, round % 3 == 0 ? 1000.0f : 0.0f);
    std::vector<LightFamily> families(1 + static_cast<size_t>(random.next_1d() * 7.99f));
    for (LightFamily& f : families) {
      f.center = far + random_point(random, extent);
      f.radius = extent * std::pow(10.0f, -4.0f + 5.0f * random.next_1d());
      f.axis = random_direction(random);
      f.cos_reach = 2.0f * random.next_1d() - 1.0f;
      f.even = std::pow(10.0f, -15.0f * random.next_1d());
    }
    LightNode node{};
    node.store(families);
    for (size_t i = 0; i < families.size(); ++i) {
      const LightFamily& f = families[i];
      const V3d center(static_cast<double>(node.origin[0]) + static_cast<double>(node.x[i] * node.step),
                       static_cast<double>(node.origin[1]) + static_cast<double>(node.y[i] * node.step),
                       static_cast<double>(node.origin[2]) + static_cast<double>(node.z[i] * node.step));
      const double radius = static_cast<double>(node.radius[i]) * static_cast<double>(node.step);
      ASSERT_GE(radius, (center - V3d(f.center)).length() + static_cast<double>(f.radius)) << round << " " << i;
      const V3f axis = V3f(node.axis_x[i], node.axis_y[i], node.axis_z[i]) * (1.0f / 127.0f);
      const float reach = static_cast<float>(node.cos_reach[i]) / 127.0f;
      // A direction at the edge of the reach.
      const V3f side = f.axis.cross(random_direction(random)).normalized();
      const V3f edge = f.axis * f.cos_reach + side * safe_sqrt(1.0f - f.cos_reach * f.cos_reach);
      ASSERT_GT(axis.dot(edge), reach);
      const auto even = std::bit_cast<float>(static_cast<uint32_t>(node.even[i]) << 15);
      ASSERT_NEAR(even, f.even, 0.002f * f.even);
    }
    for (size_t i = families.size(); i < LightNode::kWidth; ++i) ASSERT_EQ(node.even[i], 0);
  }
}

// Compares the root's estimate at a far point with the sum over emitters whose normals are in a cap
// around an axis.
TEST(LightNode, FamilyProfileMatchesSumOfMembers) {
  Random random(52);
  struct Kind {
    float cos_cap;
    float back;
    float tolerance; // of the maximum
  };
  // Exact for planes, spheres and half spheres (except for rounding to bytes); approximate in
  // between.
  for (const Kind& kind : {Kind{1.0f, 0.0f, 0.02f}, Kind{1.0f, 1.0f, 0.02f}, Kind{-1.0f, 0.0f, 0.05f},
                           Kind{-1.0f, 0.0625f, 0.05f}, Kind{0.0f, 0.0f, 0.05f}, Kind{0.7f, 0.0f, 0.1f}}) {
    const V3f axis = random_direction(random);
    std::vector<EmitterBounds> emitters(3000);
    for (EmitterBounds& e : emitters) {
      do {
        e.axis = kind.cos_cap == 1.0f ? axis : random_direction(random);
      } while (e.axis.dot(axis) < kind.cos_cap - 1e-4f);
      e.center = random_point(random, 0.001f);
      e.intensity = 0.5f + random.next_1d();
      e.back = kind.back;
    }
    const LightTree tree(emitters);
    double largest = 0.0, worst = 0.0;
    for (int i = 0; i < 200; ++i) {
      const V3f towards = random_direction(random);
      double expected = 0.0;
      for (const EmitterBounds& e : emitters) {
        const float c = towards.dot(e.axis);
        expected += static_cast<double>(e.intensity * std::max(c, -c * e.back)) * 0.01;
      }
      const auto guess = static_cast<double>(tree.irradiance(towards * 10.0f, -towards));
      largest = std::max(largest, expected);
      worst = std::max(worst, std::fabs(guess - expected));
    }
    EXPECT_LT(worst, static_cast<double>(kind.tolerance) * largest) << kind.cos_cap << " " << kind.back;
  }
}

// Verifies the figure in the README.
TEST(LightNode, MemoryPerEmitter) {
  Random random(53);
  std::vector<EmitterBounds> emitters(80'000);
  V3f bulb(0.0f);
  for (size_t i = 0; i < emitters.size(); ++i) {
    if (i % 80 == 0) bulb = random_point(random, 20.0f);
    emitters[i].axis = random_direction(random);
    emitters[i].center = bulb + emitters[i].axis * 0.1f;
    emitters[i].radius = 0.02f;
    emitters[i].intensity = 1.0f;
  }
  const LightTree tree(emitters);
  EXPECT_LT(static_cast<double>(tree.memory_bytes()) / 80'000.0, 36.0);
}

} // namespace
} // namespace kindling
