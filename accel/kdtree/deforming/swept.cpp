// Sweeps triangles over a time slice, classifies them against moving planes, and splits them.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/deforming/swept.h"

#include "accel/motion.h"
#include "accel/triangle.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling::accel::kd {
namespace {

using Imath::V3d;
using Imath::V3f;

// The positions of a triangle at the ends of a slice and at the keys inside it.
struct Path {
  static constexpr size_t kMax = kMaxMotionKeys + 2;
  std::array<float, kMax> fraction;
  std::array<std::array<V3f, 3>, kMax> corners;
  size_t count = 0;

  Path(const Geometry& geometry, uint32_t triangle, const TimeSlice& slice) {
    const uint32_t segments = key_count(geometry.mesh) - 1;
    add_between(geometry, triangle, key_interval(slice.begin, segments), 0.0f);
    for (uint32_t key = key_interval(slice.begin, segments).first + 1; key < segments; ++key) {
      const float time = static_cast<float>(key) / static_cast<float>(segments);
      if (!(time < slice.end)) break;
      if (time > slice.begin) add_between(geometry, triangle, {key, 0.0f}, slice.fraction_of(time));
    }
    add_between(geometry, triangle, key_interval(slice.end, segments), 1.0f);
  }

 private:
  void add_between(const Geometry& geometry, uint32_t triangle, KeyInterval at, float in_slice) {
    const std::span<const V3f> first = positions_at_key(geometry.mesh, at.first),
                               second = positions_at_key(geometry.mesh, at.first + 1);
    const uint32_t* corner = &geometry.mesh.indices[3 * static_cast<size_t>(triangle)];
    fraction[count] = in_slice;
    for (size_t k = 0; k < 3; ++k) corners[count][k] = between(first[corner[k]], second[corner[k]], at.fraction);
    ++count;
  }
};

// The inputs of the margin by axis: largest coordinates, and speeds per shutter.
struct Extremes {
  V3f coordinate = V3f(0), speed = V3f(0);

  void extend(const Extremes& other) {
    for (int k = 0; k < 3; ++k) {
      coordinate[k] = std::max(coordinate[k], other.coordinate[k]);
      speed[k] = std::max(speed[k], other.speed[k]);
    }
  }
};

// Bounds the triangle by lines between its bounds at both ends, moved outwards where keys between
// require it. Between two samples the corners move along straight lines, so their minimum is above
// the chord.
void bound(const Path& path, const TimeSlice& slice, MovingReference& out, Extremes& extremes) {
  const size_t last = path.count - 1;
  float extent = 0.0f; // between two samples it is less than at one of them
  for (int axis = 0; axis < 3; ++axis) {
    const auto low_at = [&](size_t i) {
      const auto& c = path.corners[i];
      return std::min(c[0][axis], std::min(c[1][axis], c[2][axis]));
    };
    const auto high_at = [&](size_t i) {
      const auto& c = path.corners[i];
      return std::max(c[0][axis], std::max(c[1][axis], c[2][axis]));
    };
    float low0 = low_at(0), low1 = low_at(last), high0 = high_at(0), high1 = high_at(last);
    float below = 0.0f, above = 0.0f;
    for (size_t i = 1; i < last; ++i) {
      below = std::max(below, between(low0, low1, path.fraction[i]) - low_at(i));
      above = std::max(above, high_at(i) - between(high0, high1, path.fraction[i]));
    }
    for (size_t i = 0; i <= last; ++i) extent = std::max(extent, high_at(i) - low_at(i));
    out.low[0][axis] = low0 - below;
    out.low[1][axis] = low1 - below;
    out.high[0][axis] = high0 + above;
    out.high[1][axis] = high1 + above;
    for (const float value : {out.low[0][axis], out.low[1][axis], out.high[0][axis], out.high[1][axis]})
      extremes.coordinate[axis] = std::max(extremes.coordinate[axis], std::fabs(value));
    for (size_t i = 0; i < last; ++i)
      for (size_t k = 0; k < 3; ++k) {
        const float time = (path.fraction[i + 1] - path.fraction[i]) * (slice.end - slice.begin);
        const float displacement = std::fabs(path.corners[i + 1][k][axis] - path.corners[i][k][axis]);
        if (time > 0.0f) extremes.speed[axis] = std::max(extremes.speed[axis], displacement / time);
      }
  }
  out.margin = kExtentTolerance * extent;
}

// Bounds of the part of a hull on one side of a plane, in a frame in which the plane is at rest.
struct HullSide {
  V3d low = V3d(std::numeric_limits<double>::infinity()), high = -low;

  void extend(const V3d& p) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  [[nodiscard]] bool empty() const { return !(low.x <= high.x); }
};

// Replaces each face by the bound that is tighter at the middle of the slice; both are valid at all
// times.
void narrow(MovingReference& part, const HullSide& side, const V3f& displacement, const V3f& margin) {
  for (int k = 0; k < 3; ++k) {
    const auto low = static_cast<float>(side.low[k]) - margin[k], high = static_cast<float>(side.high[k]) + margin[k];
    if (low + 0.5f * displacement[k] > part.low_at_middle(k)) {
      part.low[0][k] = low;
      part.low[1][k] = low + displacement[k];
    }
    if (high + 0.5f * displacement[k] < part.high_at_middle(k)) {
      part.high[0][k] = high;
      part.high[1][k] = high + displacement[k];
    }
  }
}

constexpr size_t kMaxHullSamples = 3; // a hull of more samples has too many edges

} // namespace

std::vector<LeafReference> triangles_to_sweep(std::span<const Geometry> geometries) {
  std::vector<LeafReference> out;
  for (size_t g = 0; g < geometries.size(); ++g) {
    const TriangleMesh& mesh = geometries[g].mesh;
    for (size_t i = 0; i < mesh.triangle_count(); ++i) {
      bool finite = true;
      for (uint32_t key = 0; key < key_count(mesh); ++key)
        for (size_t k = 0; k < 3; ++k)
          finite = finite && is_finite(positions_at_key(mesh, key)[mesh.indices[3 * i + k]]);
      if (finite) out.push_back({static_cast<uint32_t>(g), static_cast<uint32_t>(i)});
    }
  }
  return out;
}

std::vector<MovingReference> swept_references(std::span<const LeafReference> triangles, SweptMeshes& meshes) {
  constexpr size_t kChunk = 4096;
  std::vector<MovingReference> references(triangles.size());
  std::vector<Extremes> extremes((triangles.size() + kChunk - 1) / kChunk);
  tbb::parallel_for(size_t{0}, extremes.size(), [&](size_t c) {
    for (size_t i = c * kChunk; i < std::min(triangles.size(), (c + 1) * kChunk); ++i) {
      references[i].geometry = triangles[i].geometry;
      references[i].triangle = triangles[i].triangle;
      const Path path(meshes.geometries[triangles[i].geometry], triangles[i].triangle, meshes.slice);
      bound(path, meshes.slice, references[i], extremes[c]);
    }
  });
  Extremes all;
  for (const Extremes& e : extremes) all.extend(e);
  // A vertex at a given time is off by 5 u of the largest coordinate, and so is a face. The
  // fraction between two keys is off by u of the elapsed time in keys, which moves the vertex by u
  // of its speed. The builder's errors are as large.
  constexpr float kEpsilon = std::numeric_limits<float>::epsilon();
  meshes.margin =
      all.coordinate * (16.0f * kEpsilon) + all.speed * (2.0f * kEpsilon) + V3f(std::numeric_limits<float>::min());
  return references;
}

Side side_of(const SweptMeshes& meshes, const MovingReference& reference, const MovingPlane& plane) {
  const int axis = plane.axis;
  const float margin = meshes.margin[axis];
  if (reference.low[0][axis] - margin >= plane.position && reference.low[1][axis] - margin >= plane.at_end())
    return Side::above;
  if (reference.high[0][axis] + margin <= plane.position && reference.high[1][axis] + margin <= plane.at_end())
    return Side::below;
  const TriangleMesh& mesh = meshes.geometries[reference.geometry].mesh;
  const uint32_t segments = key_count(mesh) - 1;
  if ((meshes.slice.end - meshes.slice.begin) * static_cast<float>(segments) != 1.0f) return Side::both;
  const uint32_t key = key_interval(meshes.slice.begin, segments).first;
  const std::span<const V3f> first = positions_at_key(mesh, key), second = positions_at_key(mesh, key + 1);
  bool above = true, below = true;
  for (size_t k = 0; k < 3; ++k) {
    const uint32_t vertex = mesh.indices[3 * static_cast<size_t>(reference.triangle) + k];
    const float position = first[vertex][axis], end = second[vertex][axis], displacement = end - position;
    above = above && ((position >= plane.position && displacement >= plane.displacement) ||
                      (position - margin >= plane.position && end - margin >= plane.at_end()));
    below = below && ((position <= plane.position && displacement <= plane.displacement) ||
                      (position + margin <= plane.position && end + margin <= plane.at_end()));
  }
  return above ? Side::above : below ? Side::below : Side::both;
}

// At every time the triangle lies in the hull of its corners at all samples, in any frame of
// constant velocity: along the plane's axis that of the plane, along the others the triangle's own.
// The part on one side is bounded by the corners there and the points where edges of the hull cross
// the plane; including diagonals does no harm.
SplitMoving split_reference(const SweptMeshes& meshes, const MovingReference& reference, const MovingPlane& plane) {
  SplitMoving parts{reference, reference, true, true};
  const int axis = plane.axis;
  if (plane.at_middle() < reference.high_at_middle(axis)) {
    parts.below.high[0][axis] = plane.position;
    parts.below.high[1][axis] = plane.at_end();
  }
  if (plane.at_middle() > reference.low_at_middle(axis)) {
    parts.above.low[0][axis] = plane.position;
    parts.above.low[1][axis] = plane.at_end();
  }
  const Path path(meshes.geometries[reference.geometry], reference.triangle, meshes.slice);
  if (path.count > kMaxHullSamples) return parts;

  V3f displacement(0);
  const auto& first = path.corners[0];
  const auto& last = path.corners[path.count - 1];
  for (size_t k = 0; k < 3; ++k) displacement += (last[k] - first[k]) * (1.0f / 3.0f);
  displacement[axis] = plane.displacement;
  std::array<V3d, 3 * kMaxHullSamples> points;
  size_t count = 0;
  for (size_t i = 0; i < path.count; ++i)
    for (const V3f& p : path.corners[i])
      points[count++] = V3d(p) - V3d(displacement) * static_cast<double>(path.fraction[i]);
  HullSide below, above;
  const double at = plane.position, slack = meshes.margin[axis];
  for (size_t i = 0; i < count; ++i) {
    const double di = points[i][axis] - at;
    if (di <= slack) below.extend(points[i]);
    if (di >= -slack) above.extend(points[i]);
    for (size_t j = 0; j < i; ++j) {
      const double dj = points[j][axis] - at;
      if ((di < 0.0) == (dj < 0.0)) continue;
      const V3d crossing = points[i] + (points[j] - points[i]) * (di / (di - dj));
      below.extend(crossing);
      above.extend(crossing);
    }
  }
  parts.in_below = !below.empty();
  parts.in_above = !above.empty();
  if (parts.in_below) narrow(parts.below, below, displacement, meshes.margin);
  if (parts.in_above) narrow(parts.above, above, displacement, meshes.margin);
  return parts;
}

} // namespace kindling::accel::kd
