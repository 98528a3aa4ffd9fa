// Tests of frames, transforms, hashes, Result and CancelToken.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/frame.h"
#include "renderer/base/hash.h"
#include "renderer/base/math.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>

namespace kindling {
namespace {

TEST(Frame, IsOrthonormalAroundAnyNormal) {
  for (int i = 0; i < 2000; ++i) {
    const float z =
        i < 2 ? (i == 0 ? 1.0f : -1.0f) : 2.0f * to_unit_float(hash_u32(2U * static_cast<uint32_t>(i))) - 1.0f;
    const float phi = 2.0f * kPi * to_unit_float(hash_u32(2U * static_cast<uint32_t>(i) + 1U));
    const float r = safe_sqrt(1.0f - z * z);
    const V3f n(r * std::cos(phi), r * std::sin(phi), z);
    const Frame frame = Frame::around(n);
    EXPECT_NEAR(frame.tangent.length(), 1.0f, 1e-5f);
    EXPECT_NEAR(frame.tangent.dot(frame.bitangent), 0.0f, 1e-5f);
    EXPECT_NEAR(frame.tangent.cross(frame.bitangent).dot(frame.normal), 1.0f, 1e-5f); // right-handed
    const V3f v(0.3f, -0.7f, 0.2f);
    EXPECT_NEAR((frame.to_world(frame.to_local(v)) - v).length(), 0.0f, 1e-5f);
  }
}

TEST(Transform, AgreesWithImath) {
  const M44f m(1, 2, 0.5f, 0, -1, 3, 0.25f, 0, 0.1f, 0.2f, 4, 0, 7, 8, 9, 1);
  const V3f p(0.3f, -1.2f, 2.5f);
  V3f expected;
  m.multVecMatrix(p, expected);
  EXPECT_NEAR((transform_point(m, p) - expected).length(), 0.0f, 1e-5f);
  m.multDirMatrix(p, expected);
  EXPECT_NEAR((transform_vector(m, p) - expected).length(), 0.0f, 1e-5f);
  // A transformed normal is perpendicular to transformed tangents.
  const V3f tangent(1, 2, 3), normal = tangent.cross(V3f(0, 1, 0));
  EXPECT_NEAR(transform_normal(m.inverse(), normal).dot(transform_vector(m, tangent)), 0.0f, 1e-4f);
  for (const float mirror : {1.0f, -1.0f}) {
    M44f n = m;
    for (int c = 0; c < 3; ++c) n[0][c] *= mirror;
    const V3f by_inverse = transform_normal(n.inverse(), normal).normalized();
    EXPECT_NEAR((transform_normal_direction(n, normal).normalized() - by_inverse).length(), 0.0f, 1e-5f);
  }
}

TEST(Hash, SpreadsNeighbors) {
  std::set<uint32_t> seen;
  for (uint32_t i = 0; i < 4096; ++i) seen.insert(hash_combine(17, i));
  EXPECT_EQ(seen.size(), 4096U);
  EXPECT_LT(to_unit_float(0xffffffffU), 1.0f);
  EXPECT_EQ(to_unit_float(0), 0.0f);
}

TEST(Result, HoldsAValueOrAnError) {
  const Result<int> good(7);
  EXPECT_TRUE(good.ok());
  EXPECT_EQ(good.value(), 7);
  const Result<int> bad(Error{ErrorKind::usage, "why"});
  EXPECT_FALSE(bad);
  EXPECT_EQ(bad.error().kind, ErrorKind::usage);
  EXPECT_EQ(bad.error().message, "why");
  Result<std::unique_ptr<int>> owner(std::make_unique<int>(3));
  EXPECT_EQ(*std::move(owner).value(), 3);
  EXPECT_TRUE(Result<void>().ok());
  EXPECT_FALSE(Result<void>(Error{}).ok());
}

TEST(CancelToken, NowImpliesCancelled) {
  CancelToken token;
  EXPECT_FALSE(token.cancelled());
  token.cancel();
  EXPECT_TRUE(token.cancelled());
  EXPECT_FALSE(token.cancelled_now());
  token.cancel_now();
  EXPECT_TRUE(token.cancelled_now());
}

} // namespace
} // namespace kindling
