// An importance-sampled environment: an equirectangular image or a uniform color at infinity.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/base/prefetch.h"
#include "renderer/image/image.h"
#include "renderer/light/environment_levels.h"
#include "renderer/light/equirect.h"
#include "renderer/light/fp16_texels.h"
#include "renderer/light/light_sample.h"
#include "renderer/sampling/distribution_2d.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kindling {

// Radiance and density of one direction, from one lookup.
struct EnvironmentEval {
  Rgb radiance{0.0f};
  float pdf = 0.0f; // solid angle
};

// Direction d (unit, +Y up) maps to u = 0.5 + atan2(d.z, d.x) / (2 pi), v = acos(d.y) / pi; v = 0
// is the top row. A rotation by r turns the environment counterclockwise about +Y, seen from above:
// the radiance along d moves to rotate_y(d, r) = (d.x cos r + d.z sin r, d.y, d.z cos r - d.x sin
// r).
//
// Radiance is the bilinear interpolation of the texels (wrapped in u, clamped in v). The sampling
// density is interpolated likewise, not constant per texel, so a sun of a few texels is sampled
// without variance. The density is proportional to the luminance less 0.7 of its mean (at least
// 0.02 of the luminance): BSDF sampling finds the uniform part as well, so use it with multiple
// importance sampling (MIS compensation).
//
// Texels are stored as halves with one common power-of-two scale that puts the brightest at the top
// of the range: images of halves or RGBE stay exact over a dynamic range of 2^29.
struct EnvironmentView {
  // Image coordinates of a direction, or of eight.
  template <typename Real>
  struct LocationOf {
    Real u{}; // in the image, rotation applied
    Real v{};
    Real sin_theta{};
  };
  using Location = LocationOf<float>;

  [[nodiscard]] Rgb radiance(const V3f& wi) const { return radiance_at(locate(wi)); }
  // The distance is kInfinity. If the environment is black, pdf is 0 and the radiance black.
  [[nodiscard]] LightSample sample(const V2f& u) const;
  // Returns the solid-angle density of sample() for wi, computed from the exact texels. The
  // probabilities of the sampled cells are rounded to 2^-24 of their row, which shifts at most a
  // part in 2^14 of the light.
  [[nodiscard]] float pdf(const V3f& wi) const { return eval(wi).pdf; }
  // radiance() and pdf() for the cost of one of them.
  [[nodiscard]] EnvironmentEval eval(const V3f& wi) const { return eval(locate(wi)); }
  // The same in two steps, so that work between them hides memory latency.
  [[nodiscard]] Location locate(const V3f& wi) const { return width == 0 ? Location{} : coordinates_of(wi); }
  [[nodiscard]] EnvironmentEval eval(const Location& at) const;
  // The radiance of eval() alone.
  [[nodiscard]] Rgb radiance_at(const Location& at) const;
  // Returns the mean radiance of an area around a direction that is `width_turns` wide, in full
  // turns.
  [[nodiscard]] Rgb mean_radiance(const Location& at, float width_turns) const;
  // locate() for many directions, eight at a time with the same bits, and prefetch() of each.
  void locate(std::span<const V3f> directions, std::span<Location* const> locations) const;
  // locate() in an image.
  template <typename Real>
  [[nodiscard]] LocationOf<Real> coordinates_of(const Imath::Vec3<Real>& wi) const;
  // Prefetches the memory of eval(at).
  void prefetch(const Location& at) const;
  // sample() for many draws, with the same bits, in two steps, so that work between them hides
  // memory latency: finds the cells of the draws, then sets the samples. All spans have the same
  // size.
  using Cell = Distribution2DView::Cell;
  void find_cells(std::span<const V2f> draws, std::span<Cell> cells) const;
  void sample_cells(std::span<const V2f> draws, std::span<const Cell> cells,
                    std::span<LightSample* const> samples) const;
  [[nodiscard]] bool is_black() const { return constant_pdf == 0.0f && row_factors.empty(); }

  static constexpr float kMinSinTheta = 1e-6f; // keeps densities finite at the poles

  // The texel above and to the left of a point, and the point's offset from it in texels.
  struct Footprint {
    const Fp16Texel* top = nullptr; // top[width + 2] is below it
    int row = 0;
    float fx = 0.0f;
    float fy = 0.0f;
  };
  [[nodiscard]] Footprint footprint(const Location& at) const;
  // Returns the index of texel (x, y); x in [-1, width], y in [-1, height].
  [[nodiscard]] size_t texel_index(int x, int y) const {
    return static_cast<size_t>(y + 1) * (static_cast<size_t>(width) + 2) + static_cast<size_t>(x + 1);
  }

  int width = 0; // 0: uniform color
  int height = 0;
  float rotation_turns = 0.0f; // in [0, 1)
  float scale = 1.0f;          // radiance = stored value * scale
  float constant_pdf = 0.0f;   // of a uniform color that is not black
  Rgb constant{0.0f};
  // The radiance integrated over the sphere, in W/m^2 per channel; times pi it is the flux through
  // a disk per squared radius.
  Rgb total_radiance{0.0f};
  // R, G, B and weight of a texel as halves, (width + 2) * (height + 2) of them: the border repeats
  // the image (wrapped left and right, clamped at the top and bottom), so interpolation needs no
  // special cases.
  std::span<const Fp16Texel> texels;
  // Distribution over the cells between texel centers: width columns (the last one wraps), height +
  // 1 rows (half cells at the poles).
  Distribution2DView distribution;
  EnvironmentLevels levels;           // of mean_radiance()
  std::span<const float> row_factors; // per cell row: solid-angle density = weight * factor / sin(theta)
};

class Environment : public EnvironmentView {
 public:
  // Immutable after construction. Negative or non-finite texels are read as 0. Integer images are
  // decoded from sRGB, floating-point images are linear Rec. 709. An empty image is black.
  Environment(const std::shared_ptr<const Image>& image, float rotation_rad, float intensity);
  // A uniform environment.
  explicit Environment(const Rgb& radiance);

  // Returns the fraction of the total luminance that the density of sample() follows, in (0, 1];
  // the rest is left to BSDF sampling.
  [[nodiscard]] float sampled_fraction() const { return sampled_fraction_; }
  [[nodiscard]] size_t memory_bytes() const {
    return sizeof(*this) + arrays_.bytes() + stored_distribution_.memory_bytes();
  }

 private:
  // Returns the texels; nothing if the image is black.
  [[nodiscard]] std::vector<Fp16Texel> store_texels(const Image& image, float intensity);
  void fill_border(std::vector<Fp16Texel>& stored) const;
  void compensate_for_mis(float mean_weight, std::vector<Fp16Texel>& stored);
  void build_distribution();
  void build_levels();

  OwnedArrays arrays_;
  Distribution2D stored_distribution_; // owns `distribution`
  float sampled_fraction_ = 1.0f;
};

inline EnvironmentView::Footprint EnvironmentView::footprint(const Location& at) const {
  // Texel centers are at half-integers; the border shifts indices by one. min(1, NaN) is 1, so
  // accesses stay in bounds.
  const float x = std::min(1.0f, at.u) * static_cast<float>(width) + 0.5f;
  const float y = std::min(1.0f, at.v) * static_cast<float>(height) + 0.5f;
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const size_t stride = static_cast<size_t>(width) + 2;
  return {texels.data() + static_cast<size_t>(y0) * stride + static_cast<size_t>(x0), y0, x - static_cast<float>(x0),
          y - static_cast<float>(y0)};
}

// Inlined: most rays that escape need no density.
[[gnu::always_inline]] inline Rgb EnvironmentView::radiance_at(const Location& at) const {
  if (width == 0) return constant;
  const Footprint f = footprint(at);
  const V4f stored = interpolate(f.top, f.top + width + 2, f.fx, f.fy);
  return Rgb(stored.x, stored.y, stored.z) * scale;
}

inline EnvironmentEval EnvironmentView::eval(const Location& at) const {
  if (width == 0) return {constant, constant_pdf};
  const Footprint f = footprint(at);
  const V4f stored = interpolate(f.top, f.top + width + 2, f.fx, f.fy);
  const float to_pdf = row_factors[static_cast<size_t>(f.row)] / std::max(at.sin_theta, kMinSinTheta);
  return {Rgb(stored.x, stored.y, stored.z) * scale, stored.w * to_pdf};
}

inline Rgb EnvironmentView::mean_radiance(const Location& at, float width_turns) const {
  const float level = levels.level_of(width_turns);
  if (!(level > -1.0f)) return radiance_at(at);
  const float coarser = std::ceil(level);
  const int number = static_cast<int>(coarser);
  const Rgb coarse = levels.at(number, at.u, at.v) * scale;
  if (coarser == level) return coarse;
  const Rgb fine = number == 0 ? radiance_at(at) : levels.at(number - 1, at.u, at.v) * scale;
  return coarse + (fine - coarse) * (coarser - level);
}

template <typename Real>
inline EnvironmentView::LocationOf<Real> EnvironmentView::coordinates_of(const Imath::Vec3<Real>& wi) const {
  Real u = atan2_turns(wi.z, wi.x) + 0.5f + rotation_turns;
  u = u - select(u >= 1.0f, Real(1.0f), Real(0.0f));
  return {u, acos_half_turns(wi.y), square_root(Real(wi.x * wi.x + wi.z * wi.z))};
}

inline void EnvironmentView::prefetch(const Location& at) const {
  if (width == 0) return;
  const Fp16Texel* top = footprint(at).top;
  ::kindling::prefetch(top);
  ::kindling::prefetch(top + width + 2);
}

} // namespace kindling
