// Preparation of a photometric web.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_profile.h"

#include "renderer/base/elementary_double.h"

#include <cassert>

namespace kindling {
namespace {

constexpr float kDegree = kPi / 180.0f;

} // namespace

LightProfile::LightProfile(Kind convention, std::vector<float> verticals, std::vector<float> horizontals,
                           std::vector<float> intensities) {
  assert(!verticals.empty() && !horizontals.empty() && intensities.size() == verticals.size() * horizontals.size());
  kind = convention;
  mirrored_vertical = kind != Kind::c && verticals.front() >= 0.0f;
  vertical_deg = arrays_.keep(std::move(verticals));
  horizontal_deg = arrays_.keep(std::move(horizontals));
  candela = arrays_.keep(std::move(intensities));
  integrate();
}

// EXT_lights_ies, "Coordinate System Mapping": the vertical plane is x-z, the horizontal one x-y; c
// turns counterclockwise, a and b clockwise.
V3f LightProfile::direction(Kind convention, float vertical, float horizontal) {
  const float sv = elementary::sin(vertical * kDegree);
  const float cv = elementary::cos(vertical * kDegree);
  const float sh = elementary::sin(horizontal * kDegree);
  const float ch = elementary::cos(horizontal * kDegree);
  switch (convention) {
  case Kind::a: return {sv, -cv * sh, -cv * ch};
  case Kind::b: return {ch * sv, -sh, -ch * cv};
  case Kind::c: break;
  }
  return {sv * ch, sv * sh, -cv};
}

// Midpoint rule on a grid of half a degree by two: sufficient for a selection weight.
void LightProfile::integrate() {
  constexpr int kRows = 360;
  constexpr int kColumns = 180;
  double sum = 0.0;
  double sum_squares = 0.0;
  for (int row = 0; row < kRows; ++row) {
    const float vertical = (static_cast<float>(row) + 0.5f) * (180.0f / kRows);
    for (int column = 0; column < kColumns; ++column) {
      const float horizontal = (static_cast<float>(column) + 0.5f) * (360.0f / kColumns);
      const auto value = static_cast<double>(intensity(direction(Kind::c, vertical, horizontal)));
      const double weight = elementary::sin(static_cast<double>(vertical * kDegree));
      sum += value * weight;
      sum_squares += value * value * weight;
    }
  }
  flux_ = static_cast<float>(sum * 2.0 * std::numbers::pi * std::numbers::pi / (kRows * kColumns));
  typical_ = sum > 0.0 ? static_cast<float>(sum_squares / sum) : 0.0f;
}

} // namespace kindling
