// Tests of frames, transforms, hashes, Result and CancelToken.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/frame.h"
#include "renderer/base/hash.h"
#include "renderer/base/math.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/base/standard_arithmetic.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <initializer_list>
#include <limits>
#include <memory>
#include <set>
#include <utility>

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

// Returns a product that the compiler cannot compute.
float product_of(float a, float b) {
  const volatile float x = a, y = b;
  return x * y;
}

TEST(StandardArithmetic, KeepsDenormalsAndRoundsToNearest) {
#ifdef __SSE__
  const unsigned saved = _mm_getcsr();
  _mm_setcsr(saved | 1U << 15 | 1U << 6); // flushes results and operands
  ASSERT_EQ(product_of(0x1p-126f, 0.5f), 0.0f);
#endif
  ASSERT_EQ(std::fesetround(FE_UPWARD), 0);
  ASSERT_GT(product_of(0x1.000002p0f, 0x1.000002p0f), 0x1.000004p0f);
  {
    const StandardArithmetic standard;
    EXPECT_EQ(product_of(0x1p-126f, 0.5f), 0x1p-127f);
    EXPECT_EQ(product_of(0x1p-127f, 0x1p127f), 1.0f);
    EXPECT_EQ(product_of(0x1.000002p0f, 0x1.000002p0f), 0x1.000004p0f);
  }
  EXPECT_EQ(std::fegetround(), FE_UPWARD); // restored
  ASSERT_EQ(std::fesetround(FE_TONEAREST), 0);
#ifdef __SSE__
  EXPECT_EQ(product_of(0x1p-126f, 0.5f), 0.0f);
  _mm_setcsr(saved);
#endif
}

TEST(CellOf, ClampsEveryNumber) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& [x, cell] : std::initializer_list<std::pair<float, uint32_t>>{{0.0f, 0},
                                                                                 {-0.0f, 0},
                                                                                 {0.999f, 0},
                                                                                 {1.0f, 1},
                                                                                 {6.5f, 6},
                                                                                 {7.0f, 7},
                                                                                 {8.0f, 7},
                                                                                 {1e30f, 7},
                                                                                 {kInfinity, 7},
                                                                                 {-1.0f, 0},
                                                                                 {-kInfinity, 0},
                                                                                 {nan, 0},
                                                                                 {-nan, 0},
                                                                                 {0x1p-149f, 0}})
    EXPECT_EQ(cell_of(x, 7), cell) << x;
}

} // namespace
} // namespace kindling
