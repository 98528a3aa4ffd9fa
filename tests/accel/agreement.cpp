// Compares answers of accelerators in double precision, within the rounding errors of a hit.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/agreement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace kindling::accel::testing {
namespace {

// A hit evaluated in double precision.
struct Judgment {
  double t = 0.0; // distance of the plane
  double t_tolerance = 0.0;
  bool on_edge = false; // within rounding of an edge
};

Judgment judge(const TestScene& scene, const Ray& ray, const Hit& hit) {
  using Imath::V3d;
  const Imath::M44d m(scene.instances()[hit.instance].object_to_world);
  V3d p[3];
  const V3d o(ray.origin), d(ray.direction);
  double extent = 0.0;
  for (int k = 0; k < 3; ++k) {
    p[k] = V3d(scene.mesh(hit.mesh).corner(hit.triangle, k)) * m;
    // Under an instance the vertices are transformed in single precision: their own size counts
    // too.
    if (scene.instances()[hit.instance].object_to_world != M44f())
      extent = std::max({extent, p[k].length(), o.length()});
    p[k] -= o;
    extent = std::max(extent, p[k].length());
  }
  const double tolerance = 64.0 * std::numeric_limits<float>::epsilon() * extent;
  const V3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  const double cosine = std::fabs(normal.dot(d)) / d.length();
  Judgment result;
  result.t = p[0].dot(normal) / d.dot(normal);
  result.t_tolerance = tolerance / (cosine * d.length());
  // Distances of the ray from the lines of the edges, measured across the ray; a grazing triangle
  // is all edge.
  const V3d w = d.normalized();
  double nearest = cosine * std::min({(p[1] - p[0]).length(), (p[2] - p[0]).length(), (p[2] - p[1]).length()});
  for (int k = 0; k < 3; ++k) {
    const V3d a = p[k] - w * p[k].dot(w), b = p[(k + 1) % 3] - w * p[(k + 1) % 3].dot(w);
    const double length = (b - a).length();
    nearest = std::min(nearest, length == 0.0 ? 0.0 : a.cross(b).length() / length);
  }
  result.on_edge = nearest <= tolerance;
  return result;
}

} // namespace

float distance_tolerance(const TestScene& scene, const Ray& ray, const Hit& hit) {
  return static_cast<float>(judge(scene, ray, hit).t_tolerance);
}

std::string disagreement(const TestScene& scene, const Ray& ray, const Hit& expected, const Hit& hit) {
  if (!expected.is_hit() && !hit.is_hit()) return {};
  std::ostringstream out;
  out.precision(9);
  if (hit.is_hit()) {
    if (!(hit.t > ray.t_min && hit.t <= ray.t_max)) out << "t outside of the ray; ";
    if (!(hit.u >= 0.0f && hit.v >= 0.0f && hit.u + hit.v <= 1.0f + 1e-5f)) out << "u or v outside of the triangle; ";
  }
  const bool hit_nearer = hit.is_hit() && (!expected.is_hit() || hit.t < expected.t);
  const Hit& nearer = hit_nearer ? hit : expected;
  const Hit& farther = hit_nearer ? expected : hit;
  const Judgment judgment = judge(scene, ray, nearer);
  const bool same_distance = farther.is_hit() && std::fabs(static_cast<double>(farther.t) - nearer.t) <=
                                                     judgment.t_tolerance + judge(scene, ray, farther).t_tolerance;
  const bool at_end = std::fabs(judgment.t - ray.t_min) <= judgment.t_tolerance ||
                      std::fabs(judgment.t - ray.t_max) <= judgment.t_tolerance;
  if (!same_distance && !judgment.on_edge && !at_end) out << "different answers; ";
  if (out.str().empty()) return {};
  out << "ray o " << ray.origin << " d " << ray.direction << " in (" << ray.t_min << ", " << ray.t_max << "]";
  for (const Hit* h : {&expected, &hit})
    out << (h == &expected ? "; expected" : "; got") << " t " << h->t << " u " << h->u << " v " << h->v << " ids "
        << static_cast<int>(h->instance) << ' ' << static_cast<int>(h->mesh) << ' ' << static_cast<int>(h->triangle);
  return out.str();
}

std::string disagreement_any(const TestScene& scene, const Accelerator& accelerator, const Ray& ray,
                             const Hit& expected, bool blocked) {
  if (blocked == expected.is_hit()) return {};
  if (!blocked) return disagreement(scene, ray, expected, Hit()); // every hit was missed, including the nearest
  const Box3f box = scene.bounds();
  const float size = std::max((box.min - ray.origin).length(), (box.max - ray.origin).length());
  const float reach = 64.0f * std::numeric_limits<float>::epsilon() * size;
  Rng rng(1);
  for (int i = 0; i < 256; ++i) {
    Ray moved = ray;
    const V3f farthest = uniform_direction(rng) * reach;
    moved.origin += farthest * uniform(rng);
    if (accelerator.intersect(moved).is_hit()) return {};
  }
  return "blocked, but nothing is near the ray";
}

BatchAnswers::BatchAnswers(const Accelerator& accelerator, std::span<const Ray> rays) {
  Hit stale;
  stale.instance = stale.triangle = 5;
  hits.assign(rays.size(), stale);
  coherent = hits;
  blocked.assign(rays.size(), 7);
  blocked_coherent = blocked;
  accelerator.intersect(rays, hits);
  accelerator.intersect_coherent(rays, coherent);
  accelerator.occluded(rays, blocked);
  accelerator.occluded_coherent(rays, blocked_coherent);
}

} // namespace kindling::accel::testing
