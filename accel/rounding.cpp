// Exact triangle crossings in double precision, with error bounds of the single-precision test.
// SPDX-License-Identifier: Apache-2.0
#include "accel/rounding.h"

#include "accel/affine.h"
#include "accel/motion.h"
#include "accel/triangle.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace kindling::accel {
namespace {

constexpr double kUnit = 0x1p-24;     // half an ulp of 1
constexpr double kFlushed = 0x1p-125; // two products, each flushed to zero below the smallest normal number
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct ShearedVertex {
  double x = 0.0, y = 0.0, z = 0.0;
  double x_error = 0.0, y_error = 0.0, z_error = 0.0;
};

struct EdgeFunction {
  double value = 0.0;
  double rounding = 0.0; // error of its own operations
  double moved = 0.0;    // change due to the errors of the vertices
};

EdgeFunction edge_function(const ShearedVertex& c, const ShearedVertex& b) {
  const double first = c.x * b.y, second = c.y * b.x;
  EdgeFunction e;
  e.value = first - second;
  e.moved = std::fabs(c.x) * b.y_error + std::fabs(b.y) * c.x_error + std::fabs(c.y) * b.x_error +
            std::fabs(b.x) * c.y_error + c.x_error * b.y_error + c.y_error * b.x_error;
  e.rounding = kUnit * (std::fabs(first) + std::fabs(second) + std::fabs(e.value) + 2.0 * e.moved) + kFlushed;
  return e;
}

// Returns the largest absolute coordinate of a triangle's vertices over all keys.
double largest_at_keys(const TriangleMesh& mesh, const uint32_t* corner) {
  double largest = 0.0;
  for (uint32_t key = 0; key < key_count(mesh); ++key)
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis)
        largest = std::max<double>(largest, std::fabs(positions_at_key(mesh, key)[corner[k]][axis]));
  return largest;
}

} // namespace

TriangleJudgment judge_triangle(const Imath::V3f& origin, const Imath::V3f& direction, const Imath::V3f& p0,
                                const Imath::V3f& p1, const Imath::V3f& p2, double origin_error,
                                double direction_error) {
  const RayShear axes(origin, direction); // only for the choice of axes
  const double dz = direction[axes.kz], sx = direction[axes.kx] / dz, sy = direction[axes.ky] / dz;
  std::array<ShearedVertex, 3> v;
  double x_error = 0.0, y_error = 0.0, z_error = 0.0, low = kInfinity, high = -kInfinity;
  for (size_t i = 0; i < 3; ++i) {
    const Imath::V3f& p = i == 0 ? p0 : i == 1 ? p1 : p2;
    const double px = static_cast<double>(p[axes.kx]) - origin[axes.kx],
                 py = static_cast<double>(p[axes.ky]) - origin[axes.ky];
    ShearedVertex& s = v[i];
    s.z = static_cast<double>(p[axes.kz]) - origin[axes.kz];
    s.x = px - sx * s.z;
    s.y = py - sy * s.z;
    // A direction error e turns the shear by up to 2 e, since |sx| and |sy| are at most 1.
    const double turned = 2.0 * origin_error + 2.0 * direction_error / std::fabs(dz) * std::fabs(s.z);
    const double flushed = kFlushed * (1.0 + std::fabs(s.z));
    s.x_error = kUnit * (std::fabs(px) + 3.0 * std::fabs(sx * s.z) + std::fabs(s.x)) + turned + flushed;
    s.y_error = kUnit * (std::fabs(py) + 3.0 * std::fabs(sy * s.z) + std::fabs(s.y)) + turned + flushed;
    s.z_error = kUnit * std::fabs(s.z) + turned;
    x_error = std::max(x_error, s.x_error);
    y_error = std::max(y_error, s.y_error);
    z_error = std::max(z_error, s.z_error);
    low = std::min(low, s.z);
    high = std::max(high, s.z);
  }
  const EdgeFunction e[3] = {edge_function(v[2], v[1]), edge_function(v[0], v[2]), edge_function(v[1], v[0])};
  const double ax = v[1].x - v[0].x, ay = v[1].y - v[0].y, az = v[1].z - v[0].z, bx = v[2].x - v[0].x,
               by = v[2].y - v[0].y, bz = v[2].z - v[0].z;
  const double nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
  const double z = (nx * v[0].x + ny * v[0].y + nz * v[0].z) / nz;

  TriangleJudgment result;
  result.t = z / dz;
  bool positive = true, negative = true;
  for (const EdgeFunction& f : e) {
    positive = positive && f.value >= 0.0;
    negative = negative && f.value <= 0.0;
    result.at_edge = result.at_edge || std::fabs(f.value) <= f.rounding + f.moved;
  }
  result.inside = positive || negative;
  double rounding = 0.0, moved = 0.0, weights = 0.0;
  const double reach = (std::fabs(nx) * x_error + std::fabs(ny) * y_error) / std::fabs(nz) + z_error;
  for (size_t i = 0; i < 3; ++i) {
    rounding += e[i].rounding;
    moved += e[i].moved;
    weights += e[i].rounding * (std::fabs(v[i].z - z) + reach);
  }
  const double det = std::fabs(nz) - moved - rounding; // lower bound of the computed determinant
  const double largest = std::max(std::fabs(low), std::fabs(high));
  // A distance is edge functions times depths, divided by the direction and by det.
  const double numerator = (std::fabs(nz) + moved + rounding) * largest;
  const bool overflows = std::max(numerator, numerator / std::fabs(dz)) >= std::numeric_limits<float>::max() / 4.0;
  if (!(det > 2.0 * rounding) || overflows) {
    result.t_error = kInfinity;
    result.at_edge = true;
  } else {
    result.t_error = (reach + (weights + 2.0 * kFlushed) / (det - rounding) + 10.0 * kUnit * largest) / std::fabs(dz) +
                     kFlushed / (det - rounding) + kFlushed;
  }
  return result;
}

TriangleJudgment judge_hit(const BuildInput& input, const Ray& ray, const Hit& hit) {
  assert(hit.is_hit());
  const TriangleMesh& mesh = input.meshes[hit.mesh];
  const uint32_t* corner = &mesh.indices[3 * static_cast<size_t>(hit.triangle)];
  const PositionsAt positions(mesh, ray.time);
  const Imath::V3f p0 = positions[corner[0]], p1 = positions[corner[1]], p2 = positions[corner[2]];
  // Vertices interpolated differently count as an error of the ray.
  double origin = 0.0, direction = 0.0;
  if (deforms(mesh)) origin = largest_at_keys(mesh, corner);
  const Imath::M44f m = matrix_at(input, input.instances[hit.instance], ray.time);
  RayToObject to_object;
  if (is_identity(m) || !to_object.set_inverse_of(m))
    return judge_triangle(ray.origin, ray.direction, p0, p1, p2, 8.0 * kUnit * origin);

  const Ray transformed = to_object(ray);
  // Sums of the magnitudes of the added terms, found by transforming one component at a time.
  Ray probe;
  probe.origin = Imath::V3f(0.0f);
  probe.direction = {1, 0, 0};
  const Imath::V3f offset = to_object(probe).origin;
  for (int k = 0; k < 3; ++k) {
    probe.direction = Imath::V3f(0.0f);
    probe.direction[k] = 1.0f;
    const Imath::V3f row = to_object(probe).direction;
    for (int j = 0; j < 3; ++j) {
      origin += std::fabs(static_cast<double>(row[j]) * ray.origin[k]) + std::fabs(offset[j]) / 3.0;
      direction += std::fabs(static_cast<double>(row[j]) * ray.direction[k]);
    }
  }
  return judge_triangle(transformed.origin, transformed.direction, p0, p1, p2, 8.0 * kUnit * origin,
                        8.0 * kUnit * direction);
}

bool is_possible_hit(const BuildInput& input, const Ray& ray, const Hit& hit) {
  if (!(hit.t > std::max(ray.t_min, 0.0f) && hit.t <= ray.t_max)) return false;
  const TriangleJudgment judgment = judge_hit(input, ray, hit);
  if (!judgment.inside && !judgment.at_edge) return false;
  return judgment.t_error == kInfinity || std::fabs(hit.t - judgment.t) <= judgment.t_error;
}

bool rounding_explains(const BuildInput& input, const Ray& ray, const Hit& a, const Hit& b) {
  if (!a.is_hit() && !b.is_hit()) return true;
  const bool a_is_nearer = a.is_hit() && (!b.is_hit() || a.t < b.t);
  const Hit &nearer = a_is_nearer ? a : b, &farther = a_is_nearer ? b : a;
  if (!is_possible_hit(input, ray, nearer)) return false;
  const TriangleJudgment judgment = judge_hit(input, ray, nearer);
  const double t_min = std::max(ray.t_min, 0.0f);
  if (judgment.at_edge) return true;
  if (!(judgment.t > t_min + judgment.t_error && judgment.t < ray.t_max - judgment.t_error)) return true;
  return farther.is_hit() &&
         static_cast<double>(farther.t) - nearer.t <= judgment.t_error + judge_hit(input, ray, farther).t_error;
}

} // namespace kindling::accel
