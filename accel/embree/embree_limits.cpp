// Proven bounds for rays through Embree's single-precision instance transforms.
// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_limits.h"

#include "accel/affine.h"
#include "accel/motion.h"
#include "accel/triangle.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

namespace kindling::accel::embree {
namespace {

// Single precision overflows at 3e38 and loses bits below 1e-38; a factor of ten is left for sums.
constexpr double kMinDeterminant = 1e-37, kMaxProduct = 1e37;
constexpr double kRoundings = 1e-6;   // relative error of a sum of products of three floats: sixteen roundings of 2^-24
constexpr int kStepsBetweenKeys = 16; // cofactors are bounded per step, so that turns of a quarter circle pass
constexpr double kMinRayExtent = 1e12; // extent that instances given to Embree must allow, for scenes of usual size

// Entries of the upper 3x3 matrix, each anywhere in [middle - radius, middle + radius].
struct MatrixRange {
  std::array<std::array<double, 3>, 3> middle{}, radius{};
};

MatrixRange range_between(const Imath::M44f& a, const Imath::M44f& b) {
  MatrixRange range;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      range.middle[row][column] = 0.5 * (static_cast<double>(a[row][column]) + b[row][column]);
      range.radius[row][column] = 0.5 * std::fabs(static_cast<double>(b[row][column]) - a[row][column]);
    }
  return range;
}

// Returns an upper bound of the entries of the inverse as computed in single precision from
// cofactors and the determinant; infinity if there is none.
double inverse_bound(const MatrixRange& range) {
  const auto& m = range.middle;
  const auto magnitude = [&](int row, int column) { return std::fabs(m[row][column]) + range.radius[row][column]; };
  double determinant = 0.0, exact_terms = 0.0, all_terms = 0.0, largest_cofactor = 0.0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      const int r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = (column + 1) % 3, c2 = (column + 2) % 3;
      const double cofactor = magnitude(r1, c1) * magnitude(r2, c2) + magnitude(r1, c2) * magnitude(r2, c1);
      largest_cofactor = std::max(largest_cofactor, cofactor);
      if (row != 0) continue;
      determinant += m[0][column] * (m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]);
      exact_terms += std::fabs(m[0][column]) * (std::fabs(m[r1][c1] * m[r2][c2]) + std::fabs(m[r1][c2] * m[r2][c1]));
      all_terms += magnitude(0, column) * cofactor;
    }
  const double min_determinant = std::fabs(determinant) - (all_terms - exact_terms) - kRoundings * all_terms;
  if (!(min_determinant > kMinDeterminant) || !(all_terms < kMaxProduct) || !(largest_cofactor < kMaxProduct))
    return std::numeric_limits<double>::infinity();
  return largest_cofactor * (1.0 + kRoundings) / min_determinant;
}

double sum_of_translation(const Imath::M44f& m) {
  return std::fabs(static_cast<double>(m[3][0])) + std::fabs(static_cast<double>(m[3][1])) +
         std::fabs(static_cast<double>(m[3][2]));
}

double largest_finite(std::span<const Imath::V3f> positions) {
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, positions.size(), 65536), 0.0f,
      [&](const tbb::blocked_range<size_t>& part, float largest) {
        for (size_t i = part.begin(); i < part.end(); ++i)
          if (is_finite(positions[i]))
            largest =
                std::max({largest, std::fabs(positions[i].x), std::fabs(positions[i].y), std::fabs(positions[i].z)});
        return largest;
      },
      [](float a, float b) { return std::max(a, b); });
}

} // namespace

float safe_ray_extent(std::span<const Imath::M44f> keys) {
  assert(!keys.empty());
  double largest_inverse = 0.0, translation = sum_of_translation(keys[0]);
  if (keys.size() == 1) largest_inverse = inverse_bound(range_between(keys[0], keys[0]));
  for (size_t key = 0; key + 1 < keys.size(); ++key) {
    translation = std::max(translation, sum_of_translation(keys[key + 1]));
    for (int step = 0; step < kStepsBetweenKeys; ++step) {
      const auto at = [&](int s) {
        return between(keys[key], keys[key + 1], static_cast<float>(s) / kStepsBetweenKeys);
      };
      largest_inverse = std::max(largest_inverse, inverse_bound(range_between(at(step), at(step + 1))));
    }
  }
  // An object-space coordinate is at most the largest entry of the inverse times the sum of the
  // magnitudes. A tenth is left for rounding.
  const double extent = 0.9 * kMaxCoordinate / largest_inverse - translation;
  return static_cast<float>(std::clamp(extent, 0.0, static_cast<double>(kMaxCoordinate)));
}

double largest_coordinate(const BuildInput& input) {
  std::vector<double> group_extent(input.groups.size(), -1.0);
  double largest = 0.0;
  for (size_t i = 0; i < input.instances.size(); ++i) {
    const Instance& instance = input.instances[i];
    double& local = group_extent[instance.group];
    if (local < 0.0) {
      local = 0.0;
      const MeshGroup& group = input.groups[instance.group];
      for (const TriangleMesh& mesh : input.meshes.subspan(group.first_mesh, group.mesh_count))
        for (uint32_t key = 0; key < key_count(mesh); ++key)
          local = std::max<double>(local, largest_finite(positions_at_key(mesh, key)));
    }
    const std::span<const Imath::M44f> keys =
        instance.motion == kNoId ? std::span(&instance.object_to_world, 1) : input.motions[instance.motion];
    for (const Imath::M44f& m : keys)
      for (int column = 0; column < 3; ++column) {
        const double sum =
            (std::fabs(static_cast<double>(m[0][column])) + std::fabs(static_cast<double>(m[1][column])) +
             std::fabs(static_cast<double>(m[2][column]))) *
                local +
            std::fabs(static_cast<double>(m[3][column]));
        if (std::isfinite(sum)) largest = std::max(largest, sum);
      }
  }
  return largest;
}

// The start lies within the bounds, except for margins far smaller than the minimum extent, and the
// components of a unit direction sum to less than 2.
double required_ray_extent(double largest_coordinate) { return std::max(kMinRayExtent, 4.0 * largest_coordinate); }

float StartedRay::world_t(const Ray& world, float t) const {
  const auto exact = static_cast<float>(advance + scale * static_cast<double>(t));
  const float t_min = std::max(world.t_min, 0.0f);
  return std::min(std::max(exact, std::bit_cast<float>(std::bit_cast<uint32_t>(t_min) + 1)), world.t_max);
}

std::optional<StartedRay> start_at_bounds(const Ray& ray, const Imath::Box3f& bounds) {
  assert(ray.direction != Imath::V3f(0.0f));
  if (bounds.isEmpty()) return std::nullopt;
  double largest = 0.0;
  for (int k = 0; k < 3; ++k)
    largest = std::max(
        {largest, std::fabs(static_cast<double>(bounds.min[k])), std::fabs(static_cast<double>(bounds.max[k]))});
  const double margin = 64.0 * std::numeric_limits<float>::epsilon() * largest;
  const Imath::V3d origin(ray.origin), direction(ray.direction);
  const double length = std::sqrt(direction.dot(direction));
  // Double precision rounds too: by 100 units at a distance of 1e18.
  const double slack = 1e-15 * (std::fabs(origin.x) + std::fabs(origin.y) + std::fabs(origin.z)) / length;
  double enter = std::max(0.0, static_cast<double>(ray.t_min)), leave = ray.t_max;
  for (int k = 0; k < 3; ++k) {
    const double low = bounds.min[k] - margin - origin[k], high = bounds.max[k] + margin - origin[k], d = direction[k];
    if (d == 0.0) {
      if (low > 0.0 || high < 0.0) return std::nullopt;
      continue;
    }
    enter = std::max(enter, std::min(low / d, high / d) - slack);
    leave = std::min(leave, std::max(low / d, high / d) + slack);
  }
  if (!(enter <= leave)) return std::nullopt;

  StartedRay started{ray, enter, 0.0};
  started.scale = 1.0 / length;
  started.ray.origin = Imath::V3f(origin + direction * enter);
  started.ray.direction = Imath::V3f(direction * started.scale);
  started.ray.t_min = 0.0f; // the interval does not begin before the start
  started.ray.t_max = static_cast<float>(std::min((static_cast<double>(ray.t_max) - enter) * length,
                                                  static_cast<double>(std::numeric_limits<float>::max())));
  return started;
}

} // namespace kindling::accel::embree
