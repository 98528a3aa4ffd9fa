// Pixel filters: their table of names, curves, tabulated inversion and densities.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/pixel_filter.h"

#include "renderer/base/elementary_double.h"

#include <cassert>
#include <cmath>

namespace kindling {

namespace {

struct FilterEntry {
  FilterKind kind;
  std::string_view name;
  float default_width;
};
constexpr FilterEntry kFilters[] = {
    {FilterKind::blackman_harris, "blackman-harris", 1.5f},
    {FilterKind::gaussian, "gaussian", 1.5f},
    {FilterKind::box, "box", 1.0f},
    {FilterKind::mitchell, "mitchell", 4.0f},
};

double mitchell(double x) {
  constexpr double kB = 1.0 / 3.0;
  constexpr double kC = 1.0 / 3.0;
  if (x < 1.0)
    return ((12.0 - 9.0 * kB - 6.0 * kC) * x * x * x + (-18.0 + 12.0 * kB + 6.0 * kC) * x * x + (6.0 - 2.0 * kB)) / 6.0;
  return ((-kB - 6.0 * kC) * x * x * x + (6.0 * kB + 30.0 * kC) * x * x + (-12.0 * kB - 48.0 * kC) * x +
          (8.0 * kB + 24.0 * kC)) /
         6.0;
}

} // namespace

std::string_view filter_name(FilterKind kind) { return kFilters[static_cast<size_t>(kind)].name; }

std::optional<FilterKind> filter_from_name(std::string_view name) {
  for (const FilterEntry& entry : kFilters) {
    if (entry.name == name) return entry.kind;
  }
  return std::nullopt;
}

float default_filter_width(FilterKind kind) { return kFilters[static_cast<size_t>(kind)].default_width; }

double filter_value(FilterKind kind, double width, double x) {
  const double t = std::abs(x) / (0.5 * width); // 0 at the center, 1 at the edge
  if (!(t <= 1.0)) return 0.0;
  switch (kind) {
  case FilterKind::blackman_harris: {
    const double a = std::numbers::pi * t;
    return 0.35875 + 0.48829 * elementary::cos(a) + 0.14128 * elementary::cos(2.0 * a) +
           0.01168 * elementary::cos(3.0 * a);
  }
  case FilterKind::gaussian: return elementary::exp(-4.5 * t * t);
  case FilterKind::box: return 1.0;
  case FilterKind::mitchell: return mitchell(2.0 * t);
  }
  return 0.0;
}

PixelFilter::PixelFilter(const PixelFilterOptions& options)
    : kind_(options.kind), radius_(0.5f * (options.width > 0.0f ? options.width : default_filter_width(options.kind))) {
  const double step = 1.0 / kCells;
  std::array<double, kCells + 1> value;
  for (uint32_t i = 0; i <= kCells; ++i) value[i] = filter_value(kind_, 2.0, i * step);

  std::array<double, kCells + 1> running{};
  double signed_sum = 0.0;
  uint32_t first_negative = kCells;
  for (uint32_t i = 0; i < kCells; ++i) {
    // A cell has the sign of its middle, so the sign changes at a cell border.
    const bool negative = filter_value(kind_, 2.0, (i + 0.5) * step) < 0.0;
    if (negative) first_negative = std::min(first_negative, i);
    const double mass = 0.5 * step * (std::abs(value[i]) + std::abs(value[i + 1]));
    running[i + 1] = running[i] + mass;
    signed_sum += negative ? -mass : mass;
  }
  const double total = running[kCells];
  if (first_negative < kCells) {
    negative_from_ = static_cast<float>(first_negative) / kCells;
    axis_weight_ = static_cast<float>(total / signed_sum);
  }
  const auto density = [&](uint32_t i) { return static_cast<float>(std::abs(value[i]) / total); };
  for (uint32_t i = 0; i < kCells; ++i) {
    cells_[i] = {static_cast<float>(i), density(i), density(i + 1), static_cast<float>(running[i] / total)};
    ends_[i] = static_cast<float>(running[i + 1] / total);
  }
  ends_[kCells - 1] = 1.0f;
  uint32_t cell = 0;
  for (uint32_t i = 0; i < kGuideSize; ++i) {
    while (ends_[cell] <= static_cast<float>(i) / kGuideSize) ++cell;
    guide_[i] = static_cast<uint8_t>(cell);
  }
}

// Finds the cell in which the integral passes v, in [0, 1].
inline const PixelFilter::Cell<float>& PixelFilter::find_cell(float v) const {
  return find_cell(v, cell_of(v * kGuideSize, kGuideSize - 1));
}

// `entry`: of the guide for v.
inline const PixelFilter::Cell<float>& PixelFilter::find_cell(float v, uint32_t entry) const {
  uint32_t cell = guide_[entry];
  while (cell + 1 < kCells && ends_[cell] <= v) ++cell;
  return cells_[cell];
}

inline PixelFilter::Cell<Lanes> PixelFilter::find_cell(const Lanes& v) const {
  LaneNumbers values;
  values.store(v);
  const Int8 entries = __builtin_convertvector(minimum(v * kGuideSize, Lanes(kGuideSize - 1)).v, Int8);
  static_assert(sizeof(Cell<float>) == 4 * sizeof(float)); // a row of load_columns()
  std::array<const float*, Lanes::kCount> rows;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane)
    rows[lane] = &find_cell(values[lane], static_cast<uint32_t>(entries[lane])).number;
  const std::array<Lanes, 4> columns = load_columns(rows);
  return {columns[0], columns[1], columns[2], columns[3]};
}

// Samples in units of the radius, where the density of |x| is piecewise linear on [0, 1]. Values of
// u below 1/2 map to negative x.
template <typename Real>
inline PixelFilter::AxisSample<Real> PixelFilter::sample_axis(const Real& u) const {
  const Real v = absolute(Real(2.0f * u - 1.0f));
  if (kind_ == FilterKind::box) return {(2.0f * u - 1.0f) * radius_, 1.0f};
  const Cell<Real> cell = find_cell(v);
  // Solve d0 s + (d1 - d0) s^2 / 2 = rest for s in [0, 1], in the form that is stable for small
  // coefficients.
  const Real d0 = cell.density;
  const Real rest = (v - cell.below) * kCells;
  const Real root = square_root(maximum(Real(d0 * d0 + 2.0f * (cell.next_density - d0) * rest), Real(0.0f)));
  const Real denominator = d0 + root;
  const Real s = select(denominator > 0.0f, minimum(Real(2.0f * rest / denominator), Real(1.0f)), Real(0.0f));
  const Real x = (cell.number + s) * (1.0f / kCells);
  const auto negative = x >= negative_from_;
  return {with_sign_of(Real(x * radius_), Real(u - 0.5f)), select(negative, Real(-axis_weight_), Real(axis_weight_))};
}

float PixelFilter::pdf_axis(float x) const {
  const float t = std::abs(x) / radius_ * kCells;
  if (!(t <= kCells)) return 0.0f;
  const uint32_t cell = cell_of(t, kCells - 1);
  return 0.5f * lerp(cells_[cell].density, cells_[cell].next_density, t - static_cast<float>(cell)) / radius_;
}

float PixelFilter::value(const V2f& offset) const {
  const auto axis = [&](float x) {
    const bool negative = std::abs(x) >= negative_from_ * radius_;
    return negative ? -axis_weight_ * pdf_axis(x) : axis_weight_ * pdf_axis(x);
  };
  return axis(offset.x) * axis(offset.y);
}

PixelFilter::Sample PixelFilter::sample(const V2f& u) const {
  assert(u.x >= 0.0f && u.x < 1.0f && u.y >= 0.0f && u.y < 1.0f);
  const AxisSample<float> x = sample_axis(u.x), y = sample_axis(u.y);
  return {{x.offset, y.offset}, x.weight * y.weight};
}

PixelFilter::SampleOf<Lanes> PixelFilter::sample(const Imath::Vec2<Lanes>& u) const {
  const AxisSample<Lanes> x = sample_axis(u.x), y = sample_axis(u.y);
  return {{x.offset, y.offset}, x.weight * y.weight};
}

} // namespace kindling
