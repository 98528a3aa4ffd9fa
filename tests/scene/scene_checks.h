// Helpers shared by tests of poses.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"

#include <gtest/gtest.h>

namespace kindling::test {

inline constexpr float kHalfRoot = 0.70710678f;

inline void expect_near(const V3f& found, const V3f& expected, float tolerance = 1e-5f) {
  EXPECT_NEAR(found.x, expected.x, tolerance);
  EXPECT_NEAR(found.y, expected.y, tolerance);
  EXPECT_NEAR(found.z, expected.z, tolerance);
}

inline V3f xyz(const V4f& v) { return {v.x, v.y, v.z}; }

inline PosedScene pose(const Scene& scene, const PoseOptions& options = {}) {
  Result<PosedScene> posed = pose_scene(scene, options);
  EXPECT_TRUE(posed.ok()) << posed.error().message;
  return posed ? posed.value() : PosedScene();
}

} // namespace kindling::test
