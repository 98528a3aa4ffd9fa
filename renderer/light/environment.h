// An importance-sampled environment: an equirectangular picture, or one colour, infinitely far away.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/image/image.h"
#include "renderer/light/equirect.h"
#include "renderer/light/half_texels.h"
#include "renderer/light/light_sample.h"
#include "renderer/sampling/distribution_2d.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace kindling {

// Radiance and density of one direction, from one look-up.
struct EnvironmentEval {
  Rgb radiance{0.0f};
  float pdf = 0.0f; // solid angle
};

// Direction d (unit, +Y up) maps to u = 0.5 + atan2(d.z, d.x) / (2 pi), v = acos(d.y) / pi; v = 0 is the top row.
// A rotation by r turns the environment counter-clockwise about +Y, seen from above: what was seen along d is then seen
// along rotate_y(d, r) = (d.x cos r + d.z sin r, d.y, d.z cos r - d.x sin r).
// Radiance is the bilinear interpolation of the texels (wrapping in u, clamped in v); sampling is by a density that is
// constant over a texel's solid angle and positive wherever the interpolated radiance is.
//
// Texels are held as halves under one common power of two, so that the brightest uses the top of the range: pictures
// that were halves or RGBE stay exact over 2^29 of dynamic range.
class Environment {
 public:
  // Immutable after construction. A picture with negative or non-finite texels is read with those as 0. Pictures of
  // integers are decoded from sRGB, floating-point ones are linear Rec. 709. An empty picture is black.
  Environment(std::shared_ptr<const Image> picture, float rotation_rad, float intensity);
  // The same radiance in every direction.
  explicit Environment(const Rgb& radiance);

  [[nodiscard]] Rgb radiance(const V3f& wi) const { return eval(wi).radiance; }
  // distance is kInfinity. pdf is 0 and the radiance black if the environment is black.
  [[nodiscard]] LightSample sample(const V2f& u) const;
  // Solid-angle density of sample() producing wi, rounded to a half: within 2^-11 of what sample() reports.
  [[nodiscard]] float pdf(const V3f& wi) const { return eval(wi).pdf; }
  // radiance() and pdf() at the price of one of them.
  [[nodiscard]] EnvironmentEval eval(const V3f& wi) const;
  // Radiance integrated over the sphere, W/m^2 per channel: pi times it is a disc's flux per unit radius squared.
  [[nodiscard]] Rgb total_radiance() const { return total_radiance_; }
  [[nodiscard]] bool is_black() const { return pdf_scale_ == 0.0f; }
  [[nodiscard]] size_t memory_bytes() const;

 private:
  // u in [0, 1] of the picture itself (rotation applied), v in [0, 1].
  [[nodiscard]] EnvironmentEval eval_uv(float u, float v) const;
  // x in [-1, width], y in [-1, height].
  [[nodiscard]] size_t texel_index(int x, int y) const {
    return static_cast<size_t>(y + 1) * (static_cast<size_t>(width_) + 2) + static_cast<size_t>(x + 1);
  }
  // False: the picture is black, and nothing was stored.
  [[nodiscard]] bool store_texels(const Image& image, float intensity);
  void fill_border();
  void build_distribution();
  void store_densities();

  int width_ = 0; // 0: one colour
  int height_ = 0;
  float rotation_turns_ = 0.0f; // in [0, 1)
  float scale_ = 1.0f;          // radiance = stored value * scale_
  float pdf_scale_ = 0.0f;      // solid-angle density = stored density * pdf_scale_; 0: black
  Rgb constant_{0.0f};
  Rgb total_radiance_{0.0f};
  // R, G, B and the sampling density of a texel as halves, (width + 2) * (height + 2) of them: the border repeats the
  // picture (wrapped left and right, clamped at the top and bottom), so that interpolation needs no special case.
  std::vector<HalfTexel> texels_;
  Distribution2D distribution_;
  std::vector<float>
      to_solid_angle_;             // for each row: solid-angle density = density over the picture's unit square * this
  std::vector<float> polar_edges_; // 1 - cos(theta) of the row borders, from the top: height + 1 of them
};

inline EnvironmentEval Environment::eval_uv(float u, float v) const {
  // Texel centres are at half-integers; the border shifts indices by one. min(1, NaN) is 1: never out of bounds.
  const float x = std::min(1.0f, u) * static_cast<float>(width_) + 0.5f;
  const float y = std::min(1.0f, v) * static_cast<float>(height_) + 0.5f;
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const size_t stride = static_cast<size_t>(width_) + 2;
  const HalfTexel* top = texels_.data() + static_cast<size_t>(y0) * stride + static_cast<size_t>(x0);
  const Rgb stored = interpolate(top, top + stride, fx, fy);
  const HalfTexel* nearest = top + (fy >= 0.5f ? stride : 0) + (fx >= 0.5f ? 1 : 0);
  return {stored * scale_, half_to_float(nearest->density) * pdf_scale_};
}

inline EnvironmentEval Environment::eval(const V3f& wi) const {
  if (width_ == 0) return {constant_, pdf_scale_};
  float u = atan2_turns(wi.z, wi.x) + 0.5f + rotation_turns_;
  u -= u >= 1.0f ? 1.0f : 0.0f;
  return eval_uv(u, acos_half_turns(wi.y));
}

} // namespace kindling
