// Agreement of two answers to one ray, with tolerances from rounding errors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/accel/accel_scenes.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kindling::accel::testing {

// Compares two nearest hits. Returns an empty string if `hit` is as valid as `expected`, else a
// description of the difference. Answers may differ
//  - in t by the rounding errors of the distance: 64 eps * (size of the coordinates relative to the
//    ray's origin) / cosine;
//  - altogether if the nearer hit lies no farther from an edge of its triangle, measured across the
//    ray, than the rounding errors of the vertices: 64 eps * the same size.
[[nodiscard]] std::string disagreement(const TestScene& scene, const Ray& ray, const Hit& expected, const Hit& hit);
// Compares an any-hit answer with `expected`, the nearest hit found by `accelerator`, whose
// arithmetic may round differently. A ray reported as blocked without a hit must have one when it
// is displaced by no more than those rounding errors.
[[nodiscard]] std::string disagreement_any(const TestScene& scene, const Accelerator& accelerator, const Ray& ray,
                                           const Hit& expected, bool blocked);
// The answers of an accelerator's four batch calls to the same rays.
struct BatchAnswers {
  std::vector<Hit> hits, coherent;
  std::vector<uint8_t> blocked, blocked_coherent; // 0 or 1

  // Answers that a call leaves out are neither misses nor valid.
  BatchAnswers(const Accelerator& accelerator, std::span<const Ray> rays);
};
// Returns the tolerance of t used by disagreement().
[[nodiscard]] float distance_tolerance(const TestScene& scene, const Ray& ray, const Hit& hit);

} // namespace kindling::accel::testing
