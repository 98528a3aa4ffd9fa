// The AgX tone curve in double precision.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/agx.h"

#include "renderer/base/elementary_double.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kindling {

namespace {

using Vec = std::array<double, 3>;
using Matrix = std::array<Vec, 3>; // rows

Vec multiply(const Matrix& m, const Vec& v) {
  Vec product{};
  for (size_t row = 0; row < 3; ++row) product[row] = m[row][0] * v[0] + m[row][1] * v[1] + m[row][2] * v[2];
  return product;
}

// Between linear Rec. 709 and linear Rec. 2020, white point D65 (ITU-R BT.2087).
constexpr Matrix kRec709To2020{
    {{0.62740192, 0.32929197, 0.04330610}, {0.06909549, 0.91954428, 0.01136023}, {0.01639371, 0.08802816, 0.89557813}}};
constexpr Matrix kRec2020To709{{{1.66049622, -0.58765644, -0.07283978},
                                {-0.12454710, 1.13289511, -0.00834801},
                                {-0.01815368, -0.10059737, 1.11875105}}};
// Primaries drawn towards white before the curve, and most of the way back after it.
constexpr Matrix kInset{{{0.856627153315983, 0.0951212405381588, 0.0482516061458583},
                         {0.137318972929847, 0.761241990602591, 0.101439036467562},
                         {0.11189821299995, 0.0767994186031903, 0.811302368396859}}};
constexpr Matrix kOutset{{{1.12710058, -0.11060664, -0.01649394},
                          {-0.14132976, 1.15782370, -0.01649394},
                          {-0.14132976, -0.11060664, 1.25193641}}};

// The curve's domain: stops around middle gray, scaled to [0, 1].
constexpr double kMiddleGray = 0.18, kMinStops = -10.0, kMaxStops = 6.5;
// The pivot of the sigmoid is middle gray; its slope there, the power of its toe and shoulder, and
// the power of its output.
constexpr double kPivotX = -kMinStops / (kMaxStops - kMinStops);
constexpr double kSlope = 2.4, kPower = 1.5, kOutputPower = 2.4;
// The part of the hue after the curve; the rest is the hue before it.
constexpr double kHueShift = 0.4;

// The scale of a toe or shoulder that ends `dy` away from the pivot at the distance `dx`.
double end_scale(double dx, double dy) {
  return elementary::pow(elementary::pow(kSlope * dx, -kPower) * (elementary::pow(kSlope * dx / dy, kPower) - 1.0),
                         -1.0 / kPower);
}

double sigmoid(double x) {
  static const double pivot_y = elementary::pow(kMiddleGray, 1.0 / kOutputPower);
  static const double toe = -end_scale(kPivotX, pivot_y), shoulder = end_scale(1.0 - kPivotX, 1.0 - pivot_y);
  const double scale = x < kPivotX ? toe : shoulder;
  const double t = kSlope * (x - kPivotX) / scale; // not negative
  return scale * t / elementary::pow(1.0 + elementary::pow(t, kPower), 1.0 / kPower) + pivot_y;
}

// Hue and saturation in [0, 1], value as the largest component.
Vec rgb_to_hsv(const Vec& rgb) {
  const double high = std::max({rgb[0], rgb[1], rgb[2]}), range = high - std::min({rgb[0], rgb[1], rgb[2]});
  if (!(range > 0.0)) return {0.0, 0.0, high};
  double hue = 4.0 + (rgb[0] - rgb[1]) / range;
  if (rgb[0] == high)
    hue = (rgb[1] - rgb[2]) / range;
  else if (rgb[1] == high)
    hue = 2.0 + (rgb[2] - rgb[0]) / range;
  hue /= 6.0;
  return {hue - std::floor(hue), range / high, high};
}

Vec hsv_to_rgb(const Vec& hsv) {
  const auto component = [&](double shift) {
    const double k = std::fmod(shift + hsv[0] * 6.0, 6.0);
    return hsv[2] * (1.0 - hsv[1] * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
  };
  return {component(5.0), component(3.0), component(1.0)};
}

// Luminance of linear Rec. 709 by the weights that the generator has for Rec. 2020.
double luminance(const Vec& rgb) {
  constexpr Vec kWeights{0.2658180370250449, 0.59846986045365, 0.1357121025213052};
  const Vec wide = multiply(kRec709To2020, rgb);
  return kWeights[0] * wide[0] + kWeights[1] * wide[1] + kWeights[2] * wide[2];
}

// Luminance made larger by that of the complement, for colors outside of the gamut, the more so the
// darker they are.
double compensated_luminance(const Vec& rgb) {
  const double high = std::max({rgb[0], rgb[1], rgb[2]});
  const Vec complement{high - rgb[0], high - rgb[1], high - rgb[2]};
  const double own = luminance(rgb);
  const double raised = std::max({complement[0], complement[1], complement[2]}) - luminance(complement) + own;
  const double weight = own > 0.0 ? std::min(elementary::pow(own, 0.08), 1.0) : 0.0;
  return raised + weight * (own - raised);
}

// Shifts what is outside of the gamut until no component is negative, and scales it back to its
// luminance.
Vec bring_into_gamut(const Vec& rgb) {
  const double offset = std::max(-std::min({rgb[0], rgb[1], rgb[2]}), 0.0);
  if (offset == 0.0) return rgb;
  Vec shifted{rgb[0] + offset, rgb[1] + offset, rgb[2] + offset};
  const double before = compensated_luminance(rgb), after = compensated_luminance(shifted);
  if (after > before)
    for (double& c : shifted) c *= before / after;
  return shifted;
}

} // namespace

Rgb tone_map_agx(const Rgb& scene) {
  constexpr float kWhite = 1e30f; // far beyond the curve's end; infinity would have no hue
  const auto positive_finite = [kWhite](float c) {
    return static_cast<double>(std::min(std::max(0.0f, c), kWhite));
  }; // NaN: 0
  const Vec positive{positive_finite(scene.x), positive_finite(scene.y), positive_finite(scene.z)};
  const Vec inset = multiply(kInset, multiply(kRec709To2020, positive));
  Vec formed{};
  for (size_t c = 0; c < 3; ++c) {
    const double stops = inset[c] > 0.0 ? elementary::log2(inset[c] / kMiddleGray) : kMinStops;
    const double x = std::max((stops - kMinStops) / (kMaxStops - kMinStops), 0.0);
    formed[c] = x > 0.0 ? elementary::pow(std::max(sigmoid(x), 0.0), kOutputPower) : 0.0;
  }
  Vec hsv = rgb_to_hsv(formed);
  hsv[0] = (1.0 - kHueShift) * rgb_to_hsv(inset)[0] + kHueShift * hsv[0];
  const Vec display = bring_into_gamut(multiply(kRec2020To709, multiply(kOutset, hsv_to_rgb(hsv))));
  const auto to_float = [&](size_t c) { return static_cast<float>(std::clamp(display[c], 0.0, 1.0)); };
  return {to_float(0), to_float(1), to_float(2)};
}

} // namespace kindling
