// Tests of Embree with instances that single precision cannot invert, and with far rays.
// Debian's Embree aborts if a ray is not finite in the space of an instance.
// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_limits.h"

#include "accel/affine.h"
#include "accel/embree/embree_accelerator.h"
#include "accel/motion.h"
#include "accel/rounding.h"
#include "accel/triangle.h"
#include "tests/accel/accel_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kindling::accel::testing {
namespace {

using embree::required_ray_extent;
using embree::safe_ray_extent;
using embree::start_at_bounds;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float power_of_ten(Rng& rng, float low, float high) { return std::pow(10.0f, uniform(rng, low, high)); }
float signed_power_of_ten(Rng& rng, float low, float high) {
  const float factor = uniform(rng, -1.0f, 1.0f);
  return factor * power_of_ten(rng, low, high);
}
// Returns a random direction with a length that is a random power of ten.
V3f any_size(Rng& rng, float low, float high) {
  const V3f direction = uniform_direction(rng);
  return direction * power_of_ten(rng, low, high);
}

M44f turned(Rng& rng) {
  M44f m;
  m.rotate(uniform_direction(rng) * 3.0f);
  return m;
}

// Returns two rotations with a scale per axis between them.
M44f squashed(Rng& rng, float low, float high) {
  M44f scale;
  scale.setScale(V3f{power_of_ten(rng, low, high), power_of_ten(rng, low, high), power_of_ten(rng, low, high)});
  const M44f first = turned(rng);
  return first * scale * turned(rng);
}

// Returns the largest entry of the inverse of the upper 3x3 matrix, computed by cofactors in single
// precision as Embree does.
float largest_inverse_entry(const M44f& m) {
  const V3f x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]), z(m[2][0], m[2][1], m[2][2]);
  const float determinant = x.dot(y.cross(z));
  float largest = 0.0f;
  for (const V3f& row : {y.cross(z), z.cross(x), x.cross(y)})
    for (int k = 0; k < 3; ++k) {
      const float entry = std::fabs(row[k] / determinant);
      largest = entry <= largest ? largest : entry; // NaN counts as largest
    }
  return largest;
}

TEST(EmbreeLimits, SafeExtentBoundsSinglePrecisionInverse) {
  Rng rng(907);
  int guarded = 0, passed = 0;
  for (int i = 0; i < 20000; ++i) {
    M44f m = squashed(rng, -14.0f, 14.0f);
    if (i % 2 == 0) m = squashed(rng, -1.0f, 1.0f);
    if (i % 5 == 0) m[2][0] = m[1][0], m[2][1] = m[1][1] * (1.0f + 1e-7f), m[2][2] = m[1][2]; // nearly singular
    for (int k = 0; k < 3; ++k) m[3][k] = signed_power_of_ten(rng, -3.0f, 9.0f);
    const float extent = safe_ray_extent(std::span(&m, 1));
    (extent < 1e12f ? guarded : passed) += 1;
    if (extent == 0.0f) continue;
    EXPECT_LE(largest_inverse_entry(m) * (extent + std::fabs(m[3][0])), kMaxCoordinate);
  }
  EXPECT_GT(guarded, 5000);
  EXPECT_GT(passed, 5000);
}

TEST(EmbreeLimits, SafeExtentHoldsAtAllTimes) {
  Rng rng(911);
  int safe = 0;
  for (int i = 0; i < 500; ++i) {
    const M44f first = squashed(rng, -1.0f, 1.0f);
    M44f turn;
    const V3f axis = uniform_direction(rng);
    turn.rotate(axis * uniform(rng, 0.0f, 3.2f));
    const M44f keys[2] = {first, first * turn};
    const float extent = safe_ray_extent(keys);
    safe += extent >= 1e12f ? 1 : 0;
    for (int step = 0; step <= 1000 && extent > 0.0f; ++step)
      ASSERT_LE(largest_inverse_entry(matrix_at(keys, static_cast<float>(step) / 1000.0f)) * extent, kMaxCoordinate);
  }
  EXPECT_GT(safe, 250);
  const M44f identity;
  M44f mirrored;
  mirrored.setScale(V3f(-1.0f, 1.0f, 1.0f));
  const M44f through_zero[2] = {identity, mirrored};
  EXPECT_EQ(safe_ray_extent(through_zero), 0.0f);
  EXPECT_GT(safe_ray_extent(std::span(&identity, 1)), 1.6e18f);
}

TEST(EmbreeLimits, RaysStartAtBounds) {
  Rng rng(919);
  const Box3f box(V3f(-1, -2, -3), V3f(2, 1, 4));
  int started_count = 0;
  for (int i = 0; i < 5000; ++i) {
    Ray ray;
    ray.origin = any_size(rng, 3.0f, 18.0f);
    ray.direction = uniform_in(rng, box) - ray.origin;
    ray.direction *= power_of_ten(rng, -6.0f, 0.0f);
    ray.t_max = i % 2 == 0 ? kInfinity : ray.origin.length() / ray.direction.length();
    const auto started = start_at_bounds(ray, box);
    if (!started) continue;
    ++started_count;
    EXPECT_TRUE(can_hit(started->ray, static_cast<float>(required_ray_extent(5.0))));
    EXPECT_NEAR(started->ray.direction.length(), 1.0f, 1e-5f);
    const Imath::V3d at = Imath::V3d(ray.origin) + Imath::V3d(ray.direction) * started->advance;
    EXPECT_LE((at - Imath::V3d(started->ray.origin)).length(), 1e-5);
    const float t = started->world_t(ray, 0.5f);
    EXPECT_GT(t, ray.t_min);
    EXPECT_LE(t, ray.t_max);
  }
  EXPECT_GT(started_count, 1500); // directions from the farthest origins are rounded
  Ray past;
  past.origin = V3f(1e15f, 0, 0);
  past.direction = V3f(1, 0, 0);
  past.t_max = kInfinity;
  EXPECT_FALSE(start_at_bounds(past, box));
  past.direction = V3f(-1, 0, 0);
  EXPECT_TRUE(start_at_bounds(past, box));
  past.t_max = 1e14f;
  EXPECT_FALSE(start_at_bounds(past, box));
  EXPECT_FALSE(start_at_bounds(past, Box3f()));
}

// Returns one accelerator for each of Embree's calls.
std::vector<std::unique_ptr<Accelerator>> by_all_calls(const Accelerator& embree) {
  std::vector<std::unique_ptr<Accelerator>> calls;
  for (const EmbreeCall call :
       {EmbreeCall::packet, EmbreeCall::coherent_packet, EmbreeCall::stream, EmbreeCall::coherent_stream})
    if (auto by_call = with_embree_call(embree, call)) calls.push_back(std::move(by_call));
  return calls;
}

class EmbreeEdges : public ::testing::TestWithParam<Kernels> {};

bool accept_odd(const void*, const Ray& ray, const Hit& candidate) {
  EXPECT_GT(candidate.t, ray.t_min);
  return candidate.triangle % 2 == 1;
}

// Rays are axis-aligned, so that their lines are exact at any distance.
TEST_P(EmbreeEdges, FarRaysHitTheirTargets) {
  for (const bool cut_out : {false, true}) {
    TestScene scene;
    Mesh globe = sphere(16, 32, 1e5f, V3f(0));
    globe.opaque = !cut_out;
    const uint32_t group = scene.add_group({globe});
    if (cut_out) scene.set_filter({accept_odd, nullptr});
    M44f small; // Embree's instance then takes rays up to 1e13
    small.setScale(1e-5f);
    scene.add_instance(group, small);
    const auto embree = build(GetParam(), scene), oracle = build(Kind::brute_force, scene);
    const auto calls = by_all_calls(*embree);
    Rng rng(929);
    std::vector<Ray> rays;
    for (int i = 0; i < 2000; ++i) {
      Ray ray;
      const int axis = i % 3;
      ray.origin = V3f{uniform(rng, -1.1f, 1.1f), uniform(rng, -1.1f, 1.1f), uniform(rng, -1.1f, 1.1f)};
      ray.origin[axis] = -power_of_ten(rng, 13.5f, 18.2f);
      ray.direction = V3f(0);
      ray.direction[axis] = power_of_ten(rng, -2.0f, 2.0f);
      ray.t_max = kInfinity;
      rays.push_back(ray);
    }
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    size_t hit_count = 0, different = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      // the same ray from nearby
      Ray near = rays[i];
      const int axis = static_cast<int>(i) % 3;
      near.origin[axis] = -2.0f;
      const Hit expected = oracle->intersect(near), found = embree->intersect(rays[i]);
      if (expected.is_hit() != found.is_hit()) { // at the silhouette or at an edge of a cut-out triangle
        ++different;
        continue;
      }
      ASSERT_EQ(embree->occluded(rays[i]), found.is_hit());
      if (!found.is_hit()) continue;
      ++hit_count;
      const double t = (static_cast<double>(-rays[i].origin[axis]) - 2.0) / rays[i].direction[axis] + expected.t;
      different += std::fabs(found.t - t) > 1e-6 * t + 1e-5 * expected.t ? 1 : 0;
    }
    EXPECT_GT(hit_count, 500U);
    EXPECT_LE(different, 4U);
    for (const auto& call : calls) {
      call->intersect(rays, hits);
      call->occluded(rays, blocked);
      different = 0;
      for (size_t i = 0; i < rays.size(); ++i) {
        const bool hit = embree->intersect(rays[i]).is_hit();
        different += hits[i].is_hit() != hit || blocked[i] != (hit ? 1 : 0) ? 1 : 0;
      }
      EXPECT_LE(different, 4U); // packets round differently at edges
    }
  }
}

// Scales from 1e-12 to 1e15, matrices that are singular or nearly so at some time, scenes up to the
// largest coordinate, and rays of all sizes: no call aborts, and rays from nearby match brute
// force.
TEST_P(EmbreeEdges, ExtremeInstancesMatchBruteForce) {
  Rng rng(937);
  size_t hit_count = 0, unexplained = 0, ray_count = 0;
  for (int seed = 0; seed < 120; ++seed) {
    TestScene scene;
    const float unit = seed % 3 == 0 ? 1.0f : power_of_ten(rng, -8.0f, 17.5f);
    const uint32_t group = scene.add_group({sphere(6, 12, unit, V3f(0)), triangle_soup(rng, 20, unit, unit)});
    for (int i = 0; i < 4; ++i) {
      M44f m = seed % 2 == 0 ? squashed(rng, -0.5f, 0.5f) : squashed(rng, -11.0f, 13.0f);
      if (seed % 2 == 0) m *= M44f().setScale(power_of_ten(rng, -8.0f, 2.0f));
      for (int k = 0; k < 3; ++k) m[3][k] = signed_power_of_ten(rng, -2.0f, seed % 2 == 0 ? 2.0f : 12.0f);
      if (seed % 4 == 3 && i % 2 == 0) {
        M44f other = i == 0 ? m : squashed(rng, -2.0f, 2.0f);
        for (int k = 0; k < 3; ++k) other[k][0] = i == 0 ? -other[k][0] : other[k][0];
        scene.add_instance(group, std::vector<M44f>{m, other});
      } else {
        scene.add_instance(group, m);
      }
    }
    if (seed % 5 == 0) scene.add_instance(group, M44f());
    const auto embree = build(GetParam(), scene), oracle = build(Kind::brute_force, scene);
    const auto calls = by_all_calls(*embree);
    std::vector<Ray> rays;
    for (int i = 0; i < 400; ++i) {
      const Instance& instance = scene.instances()[rng() % scene.instances().size()];
      const Mesh& mesh = scene.mesh(0);
      Ray ray;
      ray.time = uniform(rng);
      const M44f to_world = matrix_at(scene.input(), instance, ray.time);
      const auto triangle = static_cast<uint32_t>(rng() % (mesh.indices.size() / 3));
      V3f target, from;
      to_world.multVecMatrix((mesh.corner(triangle, 0) + mesh.corner(triangle, 1) + mesh.corner(triangle, 2)) / 3.0f,
                             target);
      to_world.multVecMatrix(uniform_direction(rng) * unit * 2.0f, from);
      ray.origin = i % 4 == 0 ? any_size(rng, 0.0f, 19.0f) : from;
      ray.direction = i % 8 == 1 ? any_size(rng, -20.0f, 18.0f) : target - ray.origin;
      ray.t_max = i % 7 == 0 ? power_of_ten(rng, -10.0f, 30.0f) : kInfinity;
      if (i % 50 == 0) ray.origin[i % 3] = std::numeric_limits<float>::quiet_NaN();
      rays.push_back(ray);
    }
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> blocked(rays.size());
    for (const auto& call : calls) {
      call->intersect(rays, hits);
      call->occluded(rays, blocked);
    }
    embree->intersect(rays, hits);
    embree->occluded(rays, blocked);
    for (size_t i = 0; i < rays.size(); ++i) {
      const Hit found = embree->intersect(rays[i]);
      ASSERT_EQ(found.instance, hits[i].instance);
      ASSERT_EQ(found.triangle, hits[i].triangle);
      // Distances overflow beyond about 5e12; where axes differ by 1e24 every hit is rounding.
      if (i % 4 == 0 || i % 8 == 1 || unit > 1e3f || seed % 2 == 1) continue;
      const Hit expected = oracle->intersect(rays[i]);
      ++ray_count;
      hit_count += expected.is_hit() ? 1 : 0;
      const bool same = expected.triangle == found.triangle && expected.t == found.t;
      unexplained += same || rounding_explains(scene.input(), rays[i], expected, found) ? 0 : 1;
    }
  }
  EXPECT_GT(hit_count, ray_count / 3);
  EXPECT_EQ(unexplained, 0U) << "of " << ray_count;
}

std::vector<Kernels> embree_kernels() {
  std::vector<Kernels> kernels = all_kernels();
  std::erase_if(kernels, [](const Kernels& k) { return k.kind != Kind::embree; });
  return kernels;
}

INSTANTIATE_TEST_SUITE_P(All, EmbreeEdges, ::testing::ValuesIn(embree_kernels()), kernels_label);

} // namespace
} // namespace kindling::accel::testing
