// Derivatives of reflected and refracted rays, compared with differences of rays.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/frame.h"
#include "renderer/integrator/manifolds/ray_differentials.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

// A triangle with normals that turn, tilted against all axes.
struct Triangle {
  std::array<V3f, 3> corners{V3f(-1.0f, 0.1f, -1.2f), V3f(1.5f, -0.2f, -0.8f), V3f(-0.3f, 0.4f, 1.4f)};
  std::array<V3f, 3> normals{V3f(-0.3f, 1.0f, -0.2f), V3f(0.5f, 1.2f, 0.1f), V3f(0.1f, 0.9f, 0.6f)}; // not unit

  [[nodiscard]] V3f plane_normal() const { return (corners[1] - corners[0]).cross(corners[2] - corners[0]); }
  // Returns the distance at which a ray meets the plane, and the face there.
  [[nodiscard]] float hit(const V3f& origin, const V3f& direction, SpecularFace& face) const {
    const V3f n = plane_normal();
    const float distance = (corners[0] - origin).dot(n) / direction.dot(n);
    const V3f at = origin + direction * distance - corners[0];
    const V3f edge1 = corners[1] - corners[0], edge2 = corners[2] - corners[0];
    face.plane_normal = n;
    face.barycentric_change[1] = edge2.cross(n) / n.length2();
    face.barycentric_change[2] = n.cross(edge1) / n.length2();
    face.barycentric_change[0] = -(face.barycentric_change[1] + face.barycentric_change[2]);
    const float b1 = face.barycentric_change[1].dot(at), b2 = face.barycentric_change[2].dot(at);
    face.corner_normals = normals;
    face.normal = normals[0] * (1.0f - b1 - b2) + normals[1] * b1 + normals[2] * b2;
    face.normal_length = face.normal.length();
    face.normal /= face.normal_length;
    return distance;
  }
};

DifferentialRay scattered(const V3f& direction, float eta) {
  const V3f origin(0.2f, 2.0f, -0.3f);
  const Frame around = Frame::around(direction);
  DifferentialRay ray{origin, direction, {V3f(0.0f), V3f(0.0f)}, {around.tangent, around.bitangent}};
  SpecularFace face;
  const float distance = Triangle().hit(origin, direction, face);
  ray.transfer(face, origin + direction * distance, distance);
  if (eta == 0.0f)
    ray.reflect(face);
  else
    EXPECT_TRUE(ray.refract(face, eta));
  return ray;
}

TEST(RayDifferentials, AreThoseOfNeighboringRays) {
  const V3f direction = V3f(-0.15f, -1.0f, 0.2f).normalized();
  const Frame around = Frame::around(direction);
  constexpr float kStep = 2e-3f;
  for (const float eta : {0.0f, 1.5f, 1.0f / 1.33f}) {
    const DifferentialRay ray = scattered(direction, eta);
    for (size_t i = 0; i < 2; ++i) {
      const V3f step = (i == 0 ? around.tangent : around.bitangent) * kStep;
      const DifferentialRay after = scattered((direction + step).normalized(), eta);
      const DifferentialRay before = scattered((direction - step).normalized(), eta);
      const V3f moved = (after.origin - before.origin) / (2.0f * kStep);
      const V3f turned = (after.direction - before.direction) / (2.0f * kStep);
      // Rounding of 1e-7 over the step, and the third derivatives.
      EXPECT_LT((moved - ray.origin_change[i]).length(), 3e-4f) << eta;
      EXPECT_LT((turned - ray.direction_change[i]).length(), 3e-4f) << eta;
      EXPECT_GT(ray.direction_change[i].length(), 0.1f) << eta;
    }
  }
}

TEST(RayDifferentials, RefuseTotalReflection) {
  const V3f direction = V3f(1.0f, -0.35f, 0.0f).normalized();
  SpecularFace face;
  face.normal = face.plane_normal = V3f(0.0f, 1.0f, 0.0f);
  DifferentialRay ray{V3f(0.0f, 1.0f, 0.0f), direction, {}, {}};
  EXPECT_FALSE(ray.refract(face, 1.0f / 1.5f));
  EXPECT_TRUE(ray.refract(face, 1.5f));
}

} // namespace
} // namespace kindling::test
