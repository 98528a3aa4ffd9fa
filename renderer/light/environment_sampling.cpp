// Samples an Environment: one draw, or many in the lanes of vectors.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/lanes.h"
#include "renderer/light/environment.h"
#include "renderer/sampling/warp.h"

#include <cassert>

namespace kindling {
namespace {

// A draw, and what its sample depends on once its cell is known: the cell between four texel
// centers and the weights of these.
template <typename Real>
struct DrawInCell {
  Imath::Vec2<Real> u;
  Imath::Vec2<Real> cell;          // column and row, whole numbers
  Imath::Vec2<Real> before, after; // cumulative values around the draw, along the row and across rows
  Real w00, w10, w01, w11;         // weights of the upper left, upper right, lower left and lower right texel
};

template <typename Real>
struct SampledPlace {
  Imath::Vec3<Real> wi;
  Real u, v, sin_theta; // EnvironmentView::Location
};

// Samples x in [0, 1) by inversion with a density that is linear from a to b, both >= 0 and not
// both 0.
template <typename Real>
Real sample_linear(const Real& u, const Real& a, const Real& b) {
  const Real a2 = a * a;
  return minimum(Real(u * (a + b) / (a + square_root(Real(a2 + (b * b - a2) * u)))), Real(kOneMinusEpsilon));
}

// Returns the position within the cell, in [0, 1), of a draw between the cumulative values; `count`
// cells are in a row. The rounding is that of Distribution2D::sample().
template <typename Real>
Real place_within(const Real& u, const Real& before, const Real& after, const Real& cell, float count) {
  const Real place = minimum(Real((cell + (u - before) / (after - before)) / count), Real(kOneMinusEpsilon));
  return minimum(maximum(Real(place * count - cell), Real(0.0f)), Real(kOneMinusEpsilon));
}

// Samples bilinearly within the cell.
template <typename Real>
SampledPlace<Real> place_in_cell(const EnvironmentView& environment, const DrawInCell<Real>& draw) {
  const auto mix = [](const Real& a, const Real& b, const Real& t) { return Real(a + (b - a) * t); };
  const auto columns = static_cast<float>(environment.width);
  const auto rows = static_cast<float>(environment.height + 1);
  const Real u_s = place_within(draw.u.x, draw.before.x, draw.after.x, draw.cell.x, columns);
  const Real u_t = place_within(draw.u.y, draw.before.y, draw.after.y, draw.cell.y, rows);
  Real t = sample_linear(u_t, Real(draw.w00 + draw.w10), Real(draw.w01 + draw.w11));
  const Real s = sample_linear(u_s, mix(draw.w00, draw.w01, t), mix(draw.w10, draw.w11, t));
  // The weights of a half cell at a pole do not vary across it.
  const auto height = static_cast<float>(environment.height);
  t = select(draw.cell.y <= 0.0f, Real(0.5f + 0.5f * t), select(draw.cell.y >= height, Real(t * 0.5f), t));

  const Real image_u = (draw.cell.x + 0.5f + s) / columns;
  SampledPlace<Real> result;
  result.u = image_u - select(image_u >= 1.0f, Real(1.0f), Real(0.0f));
  result.v = minimum(maximum(Real((draw.cell.y - 0.5f + t) / height), Real(0.0f)), Real(1.0f));
  const SinCosOf<Real> theta = sincos_turns(0.5f * result.v);
  const SinCosOf<Real> phi = sincos_turns(result.u - 0.5f - environment.rotation_turns);
  result.wi = {theta.sin * phi.cos, theta.cos, theta.sin * phi.sin};
  result.sin_theta = theta.sin;
  return result;
}

DrawInCell<float> draw_in_cell(const EnvironmentView& environment, const V2f& u, const EnvironmentView::Cell& cell) {
  const float* cdf = environment.distribution.cdf_of_row(cell.row) + cell.column;
  const float* row_cdf = environment.distribution.rows.cdf.data() + cell.row;
  const Fp16Texel* upper =
      &environment.texels[environment.texel_index(static_cast<int>(cell.column), static_cast<int>(cell.row) - 1)];
  const Fp16Texel* lower = upper + (static_cast<size_t>(environment.width) + 2);
  return {.u = u,
          .cell = {static_cast<float>(cell.column), static_cast<float>(cell.row)},
          .before = {cdf[0], row_cdf[0]},
          .after = {cdf[1], row_cdf[1]},
          .w00 = half_to_float(upper[0].weight),
          .w10 = half_to_float(upper[1].weight),
          .w01 = half_to_float(lower[0].weight),
          .w11 = half_to_float(lower[1].weight)};
}

void set_sample(const EnvironmentView& environment, const V3f& wi, const EnvironmentView::Location& at,
                LightSample& sample) {
  const EnvironmentEval evaluated = environment.eval(at);
  sample.wi = wi;
  sample.distance = kInfinity;
  sample.radiance = evaluated.radiance;
  sample.pdf = evaluated.pdf;
}

} // namespace

LightSample EnvironmentView::sample(const V2f& u) const {
  assert(u.x >= 0.0f && u.x <= 1.0f && u.y >= 0.0f && u.y <= 1.0f);
  LightSample result;
  result.distance = kInfinity;
  if (is_black()) {
    result.wi = V3f(0.0f, 1.0f, 0.0f);
    return result;
  }
  if (width == 0) {
    result.wi = sample_uniform_sphere(u);
    result.radiance = constant;
    result.pdf = constant_pdf;
    return result;
  }
  const SampledPlace<float> place = place_in_cell(*this, draw_in_cell(*this, u, distribution.find(u)));
  set_sample(*this, place.wi, {place.u, place.v, place.sin_theta}, result);
  return result;
}

void EnvironmentView::locate(std::span<const V3f> directions, std::span<Location* const> locations) const {
  assert(directions.size() == locations.size());
  if (width == 0) {
    for (Location* const location : locations) *location = {};
    return;
  }
  for (size_t first = 0; first < directions.size(); first += Lanes::kCount) {
    const size_t count = std::min(Lanes::kCount, directions.size() - first);
    LaneVectors wi;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) wi.set(lane, directions[first + std::min(lane, count - 1)]);
    const LocationOf<Lanes> at = coordinates_of(wi.load());
    LaneVectors coordinates;
    coordinates.store({at.u, at.v, at.sin_theta});
    for (size_t lane = 0; lane < count; ++lane) {
      Location& location = *locations[first + lane];
      location = {coordinates.x[lane], coordinates.y[lane], coordinates.z[lane]};
      prefetch(location);
    }
  }
}

void EnvironmentView::find_cells(std::span<const V2f> draws, std::span<Cell> cells) const {
  if (width == 0) return;
  distribution.find(draws, cells);
  for (const Cell& cell : cells) {
    const Fp16Texel* upper = &texels[texel_index(static_cast<int>(cell.column), static_cast<int>(cell.row) - 1)];
    kindling::prefetch(upper);
    kindling::prefetch(upper + width + 2);
  }
}

void EnvironmentView::sample_cells(std::span<const V2f> draws, std::span<const Cell> cells,
                                   std::span<LightSample* const> samples) const {
  assert(draws.size() == cells.size() && draws.size() == samples.size());
  if (width == 0) {
    for (size_t i = 0; i < draws.size(); ++i) *samples[i] = sample(draws[i]);
    return;
  }
  for (size_t first = 0; first < draws.size(); first += Lanes::kCount) {
    const size_t count = std::min(Lanes::kCount, draws.size() - first);
    LaneNumbers u_x, u_y, column, row, before_x, before_y, after_x, after_y, w00, w10, w01, w11;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) { // those without a draw repeat the last one
      const size_t i = first + std::min(lane, count - 1);
      const DrawInCell<float> draw = draw_in_cell(*this, draws[i], cells[i]);
      u_x[lane] = draw.u.x, u_y[lane] = draw.u.y;
      column[lane] = draw.cell.x, row[lane] = draw.cell.y;
      before_x[lane] = draw.before.x, before_y[lane] = draw.before.y;
      after_x[lane] = draw.after.x, after_y[lane] = draw.after.y;
      w00[lane] = draw.w00, w10[lane] = draw.w10, w01[lane] = draw.w01, w11[lane] = draw.w11;
    }
    const SampledPlace<Lanes> place = place_in_cell<Lanes>(*this, {.u = {u_x.load(), u_y.load()},
                                                                   .cell = {column.load(), row.load()},
                                                                   .before = {before_x.load(), before_y.load()},
                                                                   .after = {after_x.load(), after_y.load()},
                                                                   .w00 = w00.load(),
                                                                   .w10 = w10.load(),
                                                                   .w01 = w01.load(),
                                                                   .w11 = w11.load()});
    LaneVectors wi;
    wi.store(place.wi);
    u_x.store(place.u), u_y.store(place.v), w00.store(place.sin_theta);
    for (size_t lane = 0; lane < count; ++lane)
      set_sample(*this, wi[lane], {u_x[lane], u_y[lane], w00[lane]}, *samples[first + lane]);
  }
}

} // namespace kindling
