// Origins of rays at edges: on the inner side of every wall that meets there.
//
// The origin of a new ray is a rounded point off the surface. Near an edge it may lie beyond the
// other wall at that edge, which the arriving ray has not crossed, and the new ray would leave a
// closed box. So there the segment from the arriving ray to the origin is traced: it must cross
// nothing. If it does, the origin moves back along the segment, in front of what it crosses. For
// rays through the surface the segment must cross the surface alone.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/ray_origins.h"

#include "renderer/world/world_view.h"

#include <array>
#include <cassert>
#include <optional>

namespace kindling {
namespace {

// Lengths are multiples of SurfacePoint::position_error, see ray_origins.h.
//
// The probe leaves the arriving ray this far before its hit. A point of that ray is off by less
// than a fifth of the error, so it can lie beyond a wall only if the ray comes along the wall at an
// angle below 2e-4.
constexpr float kProbe = 1024.0f;
// A second probe judges what the first has found, from the ray's own origin if that is not farther
// away; the rounding of its direction moves its end by less than a fifth of the error.
constexpr float kLongProbe = 1048576.0f;
// The probe continues beyond the origin that it tests. Less than the distance to the surface
// itself.
constexpr float kReach = 0.5f;
// Distance of a moved origin to the wall in front of it.
constexpr float kClearance = 2.0f;
// A point that is closer to a wall is no origin, since its coordinates are rounded by up to 0.05.
constexpr float kMinClearance = 0.25f;
// Aims beside an origin that was moved are closer to it, by this factor: it may be kMinClearance
// off.
constexpr float kMovedAim = 0.25f;
constexpr int kMaxAttempts = 4; // to find an origin, until the path ends

// Triangles on a surface: the cosine between their normals and its, and the maximum number of them
// in one place.
constexpr float kParallel = 0.999f;
constexpr int kMaxLayers = 8;

// The edges of a triangle that a point is near to: unit vectors in its plane, away from the
// triangle and across the edge.
struct NearEdges {
  std::array<V3f, 3> outwards;
  unsigned count = 0;
};

// Returns the edges that are closer to the point than `margin`.
NearEdges near_edges(const std::array<V3f, 3>& p, const V3f& barycentric, float margin) {
  NearEdges near;
  const V3f normal = (p[1] - p[0]).cross(p[2] - p[0]);
  const float area = normal.length();
  for (unsigned i = 0; i < 3; ++i) {
    const V3f edge = p[(i + 2) % 3] - p[(i + 1) % 3];
    if (barycentric[i] * area < margin * edge.length()) near.outwards[near.count++] = edge.cross(normal).normalized();
  }
  return near;
}

// Where probes aim beside an origin, in meters. Accelerators round an origin once more, to the
// space of an instance. There it may lie on a wall that rises from an edge, so that no ray from it
// hits the wall, and a probe along the wall ends before it. So in instances probes aim beyond each
// edge.
struct Aims {
  std::array<V3f, 3> offsets = {V3f(0.0f), V3f(0.0f), V3f(0.0f)};
  unsigned count = 1;

  Aims(const NearEdges& edges, bool transformed, float distance_m) {
    if (!transformed || edges.count == 0) return;
    count = edges.count;
    for (unsigned i = 0; i < count; ++i) offsets[i] = edges.outwards[i] * distance_m;
  }
  [[nodiscard]] V3f beside(const V3f& origin, unsigned aim, bool moved) const {
    return origin + offsets[aim] * (moved ? kMovedAim : 1.0f);
  }
};

// Returns the unit normal; zero for a triangle without area.
V3f normal_of(const std::array<V3f, 3>& p) { return (p[1] - p[0]).cross(p[2] - p[0]).normalized(); }

bool is_same_triangle(const accel::Hit& a, const accel::Hit& b) {
  return a.instance == b.instance && a.mesh == b.mesh && a.triangle == b.triangle;
}

// A segment from a point of the arriving ray to a possible origin and a little farther; t is 1 at
// the origin.
struct Probe {
  accel::Ray ray;
  float length_m;

  Probe(const accel::Ray& arriving, float from_t, const V3f& to, float reach_m) : ray(arriving) {
    if (from_t > 0.0f) ray.origin += ray.direction * from_t;
    ray.direction = to - ray.origin;
    length_m = ray.direction.length();
    ray.t_min = 0.0f;
    ray.t_max = length_m > 0.0f ? 1.0f + reach_m / length_m : 0.0f;
  }
  [[nodiscard]] V3f at(float t) const { return ray.origin + ray.direction * t; }
};

// Makes the probes of a hit.
struct Prober {
  const WorldView& world;
  const accel::Ray& arriving;
  float hit_t;
  float error;

  [[nodiscard]] float start(float length) const { return std::max(hit_t - length * error, 0.0f); }
  [[nodiscard]] Probe probe_to(const V3f& to, float length) const {
    return {arriving, start(length), to, kReach * error};
  }
  [[nodiscard]] bool is_free(const V3f& to) const {
    if (!world.probe_is_blocked(probe_to(to, kProbe).ray)) return true;
    return start(kProbe) > 0.0f && !world.probe_is_blocked(probe_to(to, kLongProbe).ray);
  }
};

// True if rays can continue through the surface.
bool lets_light_pass(const SurfacePoint& surface) {
  return surface.alpha < 1.0f ||
         (surface.layered && (surface.layers.boundary || surface.layers.thin_wall || surface.layers.transmits));
}

} // namespace

void WorldView::guard(const accel::Ray& ray, const accel::Hit& hit, SurfacePoint& surface) const {
  const float error = surface.position_error;
  const std::array<V3f, 3> corners = face_at(ray, hit).corners;
  const NearEdges edges = near_edges(corners, V3f(1.0f - hit.u - hit.v, hit.u, hit.v), kEdgeMargin * error);
  if (edges.count == 0 && !(!contacts.empty() && contacts.at(hit))) {
    surface.guarded = false;
    return;
  }
  const Aims aims(edges, !instances[hit.instance].identity, kReach * error);
  const Prober prober{*this, ray, hit.t, error};

  // Returns the point of the probe that is off the wall which it crosses at `wall`, at most in the
  // middle between that and `after`, where the probe starts or crosses the surface at the cosine
  // `cosine_after`. Empty if there is no room: the probe comes along the wall, or the gap is
  // narrow.
  const auto in_front_of = [&](const Probe& probe, const accel::Hit& wall, float after,
                               float cosine_after) -> std::optional<V3f> {
    const float gap_m = (wall.t - after) * probe.length_m;
    const V3f n = normal_of(face_at(ray, wall).corners);
    const float cosine = std::abs(n.dot(probe.ray.direction)) / std::max(probe.length_m, 1e-30f);
    const float clearance_m = std::min(kClearance * error / std::max(cosine, 1e-6f), 0.5f * gap_m);
    if (!(clearance_m * cosine >= kMinClearance * error) ||
        !((gap_m - clearance_m) * cosine_after >= kMinClearance * error))
      return std::nullopt;
    return probe.at(wall.t - clearance_m / probe.length_m);
  };
  // Returns `point` moved off the plane of the wall that the probe crosses, to the side from which
  // the probe comes.
  const auto pushed_off = [&](const Probe& probe, const accel::Hit& wall, const V3f& point) {
    const std::array<V3f, 3> p = face_at(ray, wall).corners;
    const V3f n = normal_of(p);
    const V3f inner = n.dot(probe.ray.direction) > 0.0f ? -n : n;
    return point + inner * (kClearance * error - (point - p[0]).dot(inner));
  };

  const auto find_front = [&]() -> std::optional<V3f> {
    V3f point = origin_beside(surface, false);
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      unsigned aim = 0;
      while (aim < aims.count && prober.is_free(aims.beside(point, aim, attempt > 0))) ++aim;
      if (aim == aims.count) return point;
      const Probe probe = prober.probe_to(aims.beside(point, aim, attempt > 0), kProbe);
      const accel::Hit wall = probe_hit(probe.ray);
      if (!wall.is_hit()) return std::nullopt;
      const std::optional<V3f> before = in_front_of(probe, wall, 0.0f, 1.0f);
      if (before && aims.count == 1) return before;
      point = before ? *before : pushed_off(probe, wall, point); // in a corner it may lie on another wall
    }
    return std::nullopt;
  };

  // True for the surface itself, and for triangles that lie on it or continue it.
  const auto is_on_surface = [&](const Probe& probe, const accel::Hit& crossed) {
    if (is_same_triangle(crossed, hit)) return true;
    const V3f n = normal_of(face_at(ray, crossed).corners);
    const float height = (probe.at(crossed.t) - surface.position).dot(surface.geometric_normal);
    return std::abs(n.dot(surface.geometric_normal)) >= kParallel && std::abs(height) <= error;
  };

  const auto find_back = [&](V3f point) -> std::optional<V3f> {
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      Probe probe = prober.probe_to(point, kProbe);
      accel::Hit crossed = probe_hit(probe.ray);
      float after = -1.0f; // the probe has crossed the surface there
      for (int layer = 0; layer < kMaxLayers && crossed.is_hit() && is_on_surface(probe, crossed); ++layer) {
        probe.ray.t_min = after = crossed.t;
        crossed = probe_hit(probe.ray);
      }
      if (after < 0.0f) return std::nullopt;
      if (!crossed.is_hit()) return point;
      const float cosine =
          std::abs(surface.geometric_normal.dot(probe.ray.direction)) / std::max(probe.length_m, 1e-30f);
      if (const std::optional<V3f> between = in_front_of(probe, crossed, after, cosine)) return between;
      point = pushed_off(probe, crossed, point);
    }
    return std::nullopt;
  };

  std::optional<V3f> front = find_front();
  surface.origins[1] = origin_beside(surface, true);
  if (front && lets_light_pass(surface)) {
    std::optional<V3f> back = find_back(surface.origins[1]);
    if (!back) { // the probe passes beside the triangle: aims farther inside
      SurfacePoint inner = surface;
      const V3f inwards = (corners[0] + corners[1] + corners[2]) / 3.0f - surface.position;
      const float distance = inwards.length();
      if (distance > 0.0f) inner.position += inwards * std::min(kEdgeMargin * error / distance, 0.5f);
      back = find_back(origin_beside(inner, true));
    }
    if (back)
      surface.origins[1] = *back;
    else
      front.reset();
  }
  if (front) {
    surface.origins[0] = *front;
    return;
  }
  // No room within rounding, as in the tip of a wedge: the path ends here.
  surface.unlit = true;
  surface.layered = false;
  surface.alpha = 1.0f;
  surface.guarded = false;
}

} // namespace kindling
