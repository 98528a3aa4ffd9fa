// Orthonormal frame around a normal, which is its local +z axis.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

#include <cassert>

namespace kindling {

// One frame, or eight in lanes.
template <typename Real>
struct FrameOf {
  using Vector = Imath::Vec3<Real>;

  Vector tangent;   // unit, local +x
  Vector bitangent; // unit, local +y
  Vector normal;    // unit, local +z

  // Returns a frame with arbitrary tangents around the unit normal n. It is continuous in n except
  // at n.z = 0 (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
  [[nodiscard]] static FrameOf around(const Vector& n) {
    assert(!any(absolute(Real(n.x * n.x + n.y * n.y + n.z * n.z - 1.0f)) > 1e-2f));
    const Real sign = with_sign_of(Real(1.0f), n.z);
    const Real a = -1.0f / (sign + n.z);
    const Real b = n.x * n.y * a;
    return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }

  // Returns the frame whose local +x axis is `tangent` projected onto the plane of the unit normal
  // n; any frame if the two are parallel. `tangent` need not be a unit vector.
  [[nodiscard]] static FrameOf with_tangent(const Vector& n, const Vector& tangent) {
    assert(!any(absolute(Real(n.length2() - 1.0f)) > 1e-2f));
    const Vector x = tangent - n * n.dot(tangent);
    const Real length = length_of(x);
    const auto turned = length > 1e-6f * length_of(tangent);
    if (!any(turned)) return around(n);
    const Vector unit = x / length;
    const Vector beside = n.cross(unit);
    if (all(turned)) return {unit, beside, n};
    const FrameOf other = around(n);
    return {select(turned, unit, other.tangent), select(turned, beside, other.bitangent), n};
  }

  // Returns the local coordinates of one vector, or of several in lanes.
  template <typename R>
  [[nodiscard]] Imath::Vec3<R> to_local(const Imath::Vec3<R>& v) const {
    const auto dot = [&v](const Vector& axis) { return R(v.x * axis.x + v.y * axis.y + v.z * axis.z); };
    return {dot(tangent), dot(bitangent), dot(normal)};
  }
  [[nodiscard]] Vector to_world(const Vector& v) const { return tangent * v.x + bitangent * v.y + normal * v.z; }
};
using Frame = FrameOf<float>;

} // namespace kindling
