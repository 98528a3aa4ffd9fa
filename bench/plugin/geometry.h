// Vectors, boxes and triangles of the compressed BVH; no code of Kindling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace compressed_bvh {

using Vec = std::array<float, 3>;

struct Box {
  Vec low{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
          std::numeric_limits<float>::infinity()};
  Vec high{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
           -std::numeric_limits<float>::infinity()};

  void add(const Vec& p) {
    for (size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  void add(const Box& box) {
    for (size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], box.low[k]);
      high[k] = std::max(high[k], box.high[k]);
    }
  }
  [[nodiscard]] bool empty() const { return !(low[0] <= high[0]); }
  // Half the surface area; 0 for an empty box. In double precision: squares of large sizes.
  [[nodiscard]] double area() const {
    if (empty()) return 0.0;
    const double x = static_cast<double>(high[0]) - low[0], y = static_cast<double>(high[1]) - low[1],
                 z = static_cast<double>(high[2]) - low[2];
    return x * y + y * z + z * x;
  }
  // Twice the center.
  [[nodiscard]] double middle(size_t axis) const { return static_cast<double>(low[axis]) + high[axis]; }
};

// Products of three larger coordinates overflow.
constexpr float kMaxCoordinate = 1.844e18f;

[[nodiscard]] inline bool is_finite(const Vec& p) {
  return std::fabs(p[0]) <= kMaxCoordinate && std::fabs(p[1]) <= kMaxCoordinate && std::fabs(p[2]) <= kMaxCoordinate;
}

// False for triangles that are never hit: without area, or not finite.
[[nodiscard]] inline bool can_be_hit(const Vec& a, const Vec& b, const Vec& c) {
  if (!is_finite(a) || !is_finite(b) || !is_finite(c)) return false;
  std::array<double, 3> p{}, q{};
  for (size_t k = 0; k < 3; ++k) {
    p[k] = static_cast<double>(b[k]) - a[k];
    q[k] = static_cast<double>(c[k]) - a[k];
  }
  return p[1] * q[2] != p[2] * q[1] || p[2] * q[0] != p[0] * q[2] || p[0] * q[1] != p[1] * q[0];
}

} // namespace compressed_bvh
