// Finds the texels under micro-triangles, row by row.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/opacity/micro_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling {
namespace {

// Barycentric coordinates, three products, their sums, a transform and the wrapped coordinate
// round by less than 32 units of 2^-24 of their operands in all.
constexpr double kRounding = 32 * 0x1p-24;

// Beyond this many texels from the origin nothing is known; nor for micro-triangles of more rows.
constexpr double kMaxTexels = 1 << 22;
constexpr double kMaxRows = 1024;

} // namespace

TexelTriangle::TexelTriangle(const std::array<float, 6>& texcoords, const TextureBinding& binding, const V2i& size_px) {
  std::array<double, 6> m{1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
  if (binding.transformed) std::copy(std::begin(binding.m), std::end(binding.m), m.begin());
  std::array<Point, 3> corners;
  double reach = 1.0; // of any operand
  for (size_t k = 0; k < 3; ++k) {
    const double u = texcoords[2 * k], v = texcoords[2 * k + 1];
    corners[k] = {(m[0] * u + m[1] * v + m[2]) * size_px.x - 0.5, (m[3] * u + m[4] * v + m[5]) * size_px.y - 0.5};
    reach = std::max({reach, std::abs(u) + std::abs(v), std::abs(m[0] * u) + std::abs(m[1] * v) + std::abs(m[2]),
                      std::abs(m[3] * u) + std::abs(m[4] * v) + std::abs(m[5])});
  }
  const double scale = std::max({1.0, std::abs(m[0]) + std::abs(m[1]), std::abs(m[3]) + std::abs(m[4])});
  margin_ = {kRounding * reach * scale * size_px.x, kRounding * reach * scale * size_px.y};
  is_readable_ = true;
  for (const Point& corner : corners)
    is_readable_ = is_readable_ && std::abs(corner.x) < kMaxTexels && std::abs(corner.y) < kMaxTexels;
  is_readable_ = is_readable_ && reach * scale < kMaxTexels;
  origin_ = corners[0];
  along_u_ = {corners[1].x - corners[0].x, corners[1].y - corners[0].y};
  along_v_ = {corners[2].x - corners[0].x, corners[2].y - corners[0].y};
}

int TexelTriangle::level(double texels, int max_level) const {
  if (!is_readable_) return 0;
  const double area = 0.5 * std::abs(along_u_.x * along_v_.y - along_u_.y * along_v_.x);
  int level = 0; // a level more divides by four; the nearest one on a logarithmic scale
  for (double of_micro = area; of_micro > 2.0 * texels && level < max_level; of_micro *= 0.25) ++level;
  return level;
}

Opacity TexelTriangle::opacity(const AlphaClasses& classes, int level, const MicroTriangle& micro) const {
  if (!is_readable_) return Opacity::mixed;
  const double step = 1.0 / static_cast<double>(1U << static_cast<uint32_t>(level));
  const auto at = [&](uint32_t i, uint32_t j) -> Point {
    const double u = i * step, v = j * step;
    return {origin_.x + along_u_.x * u + along_v_.x * v, origin_.y + along_u_.y * u + along_v_.y * v};
  };
  const auto [column, row, upper] = micro;
  const std::array<Point, 3> corners{at(column + 1, row), at(column, row + 1),
                                     upper ? at(column + 1, row + 1) : at(column, row)};
  const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  if (bottom - top > kMaxRows) return Opacity::mixed;

  Opacity common = Opacity::mixed;
  bool any = false;
  const auto last = static_cast<int64_t>(std::floor(bottom + margin_.y)) + 1;
  for (auto y = static_cast<int64_t>(std::floor(top - margin_.y)); y <= last; ++y) {
    // Look-ups that read this row of texels are at most one texel above or below.
    const double above = static_cast<double>(y) - 1.0 - margin_.y, below = static_cast<double>(y) + 1.0 + margin_.y;
    double left = std::numeric_limits<double>::infinity(), right = -left;
    const auto include = [&](double x) { left = std::min(left, x), right = std::max(right, x); };
    for (size_t k = 0; k < 3; ++k) {
      const Point &a = corners[k], &b = corners[(k + 1) % 3];
      if (a.y >= above && a.y <= below) include(a.x);
      for (const double border : {above, below})
        if ((a.y < border) != (b.y < border)) include(a.x + (b.x - a.x) * ((border - a.y) / (b.y - a.y)));
    }
    if (!(left <= right)) continue;
    const Opacity part = classes.of_row(y, static_cast<int64_t>(std::floor(left - margin_.x)),
                                        static_cast<int64_t>(std::floor(right + margin_.x)) + 1);
    if (part == Opacity::mixed || (any && part != common)) return Opacity::mixed;
    common = part;
    any = true;
  }
  return common;
}

} // namespace kindling
