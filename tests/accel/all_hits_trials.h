// Accelerators, rays and answers for tests of every crossing.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/all_hits.h"
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

namespace kindling::accel::testing {

// Builds an accelerator that can answer, by certain kernels if they are given.
[[nodiscard]] inline std::unique_ptr<Accelerator> build_all_hits(Kind kind, const TestScene& scene,
                                                                 std::optional<SimdTarget> simd = {}) {
  BuildOptions options;
  options.all_hits = true;
  options.simd = simd;
  return build(kind, scene, options);
}

// The answer for one ray.
[[nodiscard]] inline std::vector<Crossing> crossings_of(const Accelerator& accelerator, const Ray& ray,
                                                        size_t limit = kNoLimit) {
  std::vector<Crossing> crossings;
  EXPECT_TRUE(accelerator.all_hits(ray, limit, crossings));
  return crossings;
}

// Rays at vertices and edges, anywhere, along axes and along faces: seven quarters of `count`.
[[nodiscard]] inline std::vector<Ray> hard_rays(Rng& rng, const TestScene& scene, int count) {
  std::vector<Ray> rays = aimed_rays(rng, scene, count);
  for (const std::vector<Ray>& more : {random_rays(rng, scene.bounds(), count / 4),
                                       axis_parallel_rays(rng, scene, count / 4), grazing_rays(rng, scene, count / 4)})
    rays.insert(rays.end(), more.begin(), more.end());
  return rays;
}

// Half of all triangles, for a hit filter.
[[nodiscard]] inline bool accept_even(const void*, const Ray&, const Hit& candidate) {
  return candidate.triangle % 2 == 0;
}

} // namespace kindling::accel::testing
