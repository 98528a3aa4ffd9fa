// Ray loads as SIMD vectors, and instance transforms: rays to object space, boxes to world space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "accel/vectors.h"

#include <ImathBox.h>
#include <ImathMatrix.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>

namespace kindling::accel {

// A ray begins with two 16-byte vectors: (origin, t_min) and (direction, t_max). Each is read by
// one wide load, since narrow stores followed by a wide load of the same bytes stall.
static_assert(offsetof(Ray, t_min) == 12 && offsetof(Ray, direction) == 16 && offsetof(Ray, t_max) == 28);
[[nodiscard]] inline Float4 load_origin(const Ray& ray) {
  Float4 vector;
  std::memcpy(&vector, reinterpret_cast<const char*>(&ray), sizeof(Float4));
  return vector;
}
[[nodiscard]] inline Float4 load_direction(const Ray& ray) {
  Float4 vector;
  std::memcpy(&vector, reinterpret_cast<const char*>(&ray) + offsetof(Ray, direction), sizeof(Float4));
  return vector;
}

[[nodiscard]] inline bool is_identity(const Imath::M44f& m) { return m == Imath::M44f(); }

// Transforms a world ray into the object space of an instance. The direction is not normalized, so
// t means the same in both spaces.
class RayToObject {
 public:
  // Inverts in double precision. Returns false if the matrix is not finite, singular, or shrinks by
  // more than 1e12; nothing of that instance can be hit.
  [[nodiscard]] bool set_inverse_of(const Imath::M44f& object_to_world) {
    const Imath::M44d m(object_to_world);
    const double c00 = m[1][1] * m[2][2] - m[1][2] * m[2][1], c01 = m[0][2] * m[2][1] - m[0][1] * m[2][2],
                 c02 = m[0][1] * m[1][2] - m[0][2] * m[1][1], c10 = m[1][2] * m[2][0] - m[1][0] * m[2][2],
                 c11 = m[0][0] * m[2][2] - m[0][2] * m[2][0], c12 = m[0][2] * m[1][0] - m[0][0] * m[1][2],
                 c20 = m[1][0] * m[2][1] - m[1][1] * m[2][0], c21 = m[0][1] * m[2][0] - m[0][0] * m[2][1],
                 c22 = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    const double determinant = m[0][0] * c00 + m[0][1] * c10 + m[0][2] * c20;
    if (!std::isfinite(determinant) || determinant == 0.0) return false;
    const double inverse[3][3] = {{c00, c01, c02}, {c10, c11, c12}, {c20, c21, c22}};
    bool finite = true;
    for (int column = 0; column < 3; ++column) {
      double origin = 0.0;
      for (int row = 0; row < 3; ++row) {
        const double value = inverse[row][column] / determinant;
        rows_[static_cast<size_t>(3 * row + column)] = static_cast<float>(value);
        origin -= m[3][row] * value;
        finite = finite && std::fabs(value) <= 1e12;
      }
      float& translation = rows_[static_cast<size_t>(9 + column)];
      translation = static_cast<float>(origin);
      finite = finite && std::isfinite(translation);
    }
    return finite;
  }

  [[nodiscard]] Ray operator()(const Ray& ray) const { return (*this)(ray, ray.t_max); }
  // The same with another end.
  [[nodiscard]] Ray operator()(const Ray& ray, float t_max) const {
    Ray out = ray;
    Float4 origin = ray.origin.x * row(0) + ray.origin.y * row(1) + ray.origin.z * row(2) + row(3);
    Float4 direction = ray.direction.x * row(0) + ray.direction.y * row(1) + ray.direction.z * row(2);
    origin[3] = ray.t_min;
    direction[3] = t_max;
    std::memcpy(reinterpret_cast<char*>(&out), &origin, sizeof(Float4));
    std::memcpy(reinterpret_cast<char*>(&out) + offsetof(Ray, direction), &direction, sizeof(Float4));
    return out;
  }

  // Returns an entry of the inverse; row 3 is the translation.
  [[nodiscard]] float entry(int row, int column) const { return rows_[static_cast<size_t>(3 * row + column)]; }

 private:
  // The fourth lane is the first float of the next row: finite and never used.
  [[nodiscard]] Float4 row(size_t number) const {
    assert(number < 4);
    Float4 vector;
    std::memcpy(&vector, rows_.data() + 3 * number, sizeof(Float4));
    return vector;
  }

  std::array<float, 13> rows_{}; // rows of the inverse for row vectors, three floats each, then a zero
};
static_assert(sizeof(RayToObject) == 52);

// Returns how much larger, in world space, the rounding of a ray's transform to object space may be
// than that of its world coordinates: the largest row sum of |inverse| |matrix|, 1 to 3 for
// rotations and uniform scales; at most 1e6. `inverse` is that of the matrix.
[[nodiscard]] inline float rounding_growth(const Imath::M44f& object_to_world, const RayToObject& inverse) {
  float growth = 1.0f;
  for (int to = 0; to < 3; ++to) {
    float sum = 0.0f;
    for (int from = 0; from < 3; ++from)
      for (int k = 0; k < 3; ++k) sum += std::fabs(inverse.entry(from, k)) * std::fabs(object_to_world[k][to]);
    growth = std::max(growth, sum);
  }
  return std::min(growth, 1e6f);
}
// Bound of the world-space rounding error of a transformed ray where it is within `magnitude` of
// the world's origin and began there too: five roundings of entries and sums, on either side.
[[nodiscard]] inline float transform_error(float growth, float magnitude) {
  return 6.0f * std::numeric_limits<float>::epsilon() * growth * magnitude;
}

// Returns the bounds of a transformed box, a few rounding errors larger than exact. Empty stays
// empty.
[[nodiscard]] inline Imath::Box3f transform_bounds(const Imath::M44f& m, const Imath::Box3f& box) {
  Imath::Box3f out;
  if (box.isEmpty()) return out;
  float largest = 0.0f;
  for (int corner = 0; corner < 8; ++corner) {
    const double p[3] = {(corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                         (corner & 4) ? box.max.z : box.min.z};
    Imath::V3f q;
    for (int k = 0; k < 3; ++k) {
      q[k] = static_cast<float>(p[0] * m[0][k] + p[1] * m[1][k] + p[2] * m[2][k] + m[3][k]);
      largest = std::max(largest, std::fabs(q[k]));
    }
    out.extendBy(q);
  }
  const float margin = 8.0f * std::numeric_limits<float>::epsilon() * largest;
  out.min -= Imath::V3f(margin);
  out.max += Imath::V3f(margin);
  return out;
}

// Returns a box widened by transform_error() for rays that reach it from the world's origin; those
// from elsewhere need the error for their own origin as well.
[[nodiscard]] inline Imath::Box3f widened(const Imath::Box3f& box, float growth, const Imath::V3f& translation) {
  float largest = 0.0f;
  for (int k = 0; k < 3; ++k)
    largest = std::max({largest, std::fabs(box.min[k]), std::fabs(box.max[k]), std::fabs(translation[k])});
  const Imath::V3f margin(transform_error(growth, largest));
  return {box.min - margin, box.max + margin};
}

// Returns bounds that hold at all times for a box moving with a matrix interpolated between keys, a
// few rounding errors larger than exact. Points move along straight lines between keys, so the
// bounds at the keys enclose all positions. The keys must be finite.
[[nodiscard]] inline Imath::Box3f transform_bounds(std::span<const Imath::M44f> keys, const Imath::Box3f& box) {
  Imath::Box3f out;
  if (box.isEmpty()) return out;
  double largest = 0.0; // of the sums of magnitudes: terms may cancel, their rounding errors do not
  for (const Imath::M44f& m : keys)
    for (int k = 0; k < 3; ++k) {
      double low = m[3][k], high = m[3][k], magnitude = std::fabs(m[3][k]);
      for (int row = 0; row < 3; ++row) {
        const double a = static_cast<double>(m[row][k]) * box.min[row],
                     b = static_cast<double>(m[row][k]) * box.max[row];
        low += std::min(a, b);
        high += std::max(a, b);
        magnitude += std::max(std::fabs(a), std::fabs(b));
      }
      out.min[k] = std::min(out.min[k], static_cast<float>(low));
      out.max[k] = std::max(out.max[k], static_cast<float>(high));
      largest = std::max(largest, magnitude);
    }
  const auto margin = static_cast<float>(16.0 * std::numeric_limits<float>::epsilon() * largest);
  out.min -= Imath::V3f(margin);
  out.max += Imath::V3f(margin);
  return out;
}

} // namespace kindling::accel
