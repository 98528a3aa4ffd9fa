// Orthonormal frame around a normal, which is its local +z axis.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cassert>

namespace kindling {

struct Frame {
  V3f tangent;   // unit, local +x
  V3f bitangent; // unit, local +y
  V3f normal;    // unit, local +z

  // Returns a frame with arbitrary tangents around the unit normal n. It is continuous in n except
  // at n.z = 0 (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
  [[nodiscard]] static Frame around(const V3f& n) {
    assert(!(std::abs(n.length2() - 1.0f) > 1e-2f));
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }

  // Returns the frame whose local +x axis is `tangent` projected onto the plane of the unit normal
  // n; any frame if the two are parallel. `tangent` need not be a unit vector.
  [[nodiscard]] static Frame with_tangent(const V3f& n, const V3f& tangent) {
    assert(!(std::abs(n.length2() - 1.0f) > 1e-2f));
    const V3f x = tangent - n * n.dot(tangent);
    const float length = x.length();
    if (!(length > 1e-6f * tangent.length())) return around(n);
    const V3f unit = x / length;
    return {unit, n.cross(unit), n};
  }

  // Returns the local coordinates of one vector, or of several in lanes.
  template <typename Real>
  [[nodiscard]] Imath::Vec3<Real> to_local(const Imath::Vec3<Real>& v) const {
    const auto dot = [&v](const V3f& axis) { return Real(v.x * axis.x + v.y * axis.y + v.z * axis.z); };
    return {dot(tangent), dot(bitangent), dot(normal)};
  }
  [[nodiscard]] V3f to_world(const V3f& v) const { return tangent * v.x + bitangent * v.y + normal * v.z; }
};

} // namespace kindling
