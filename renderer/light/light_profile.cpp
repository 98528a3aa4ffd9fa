// Lookup and integration of a photometric web.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_profile.h"

#include "renderer/base/elementary_double.h"
#include "renderer/light/equirect.h"

#include <algorithm>
#include <cassert>

namespace kindling {
namespace {

constexpr float kDegree = kPi / 180.0f;

struct Place {
  size_t below = 0;
  size_t above = 0;
  float fraction = 0.0f;
};

// Returns the two angles that enclose `degrees`, clamped to the first and the last.
Place find(const std::vector<float>& angles, float degrees) {
  const auto after = static_cast<size_t>(std::upper_bound(angles.begin(), angles.end(), degrees) - angles.begin());
  if (after == 0) return {};
  if (after == angles.size()) return {after - 1, after - 1, 0.0f};
  const float from = angles[after - 1];
  return {after - 1, after, (degrees - from) / (angles[after] - from)};
}

} // namespace

LightProfile::LightProfile(Kind kind, std::vector<float> vertical_deg, std::vector<float> horizontal_deg,
                           std::vector<float> candela)
    : kind_(kind), vertical_(std::move(vertical_deg)), horizontal_(std::move(horizontal_deg)),
      candela_(std::move(candela)) {
  assert(!vertical_.empty() && !horizontal_.empty() && candela_.size() == vertical_.size() * horizontal_.size());
  mirrored_vertical_ = kind_ != Kind::c && vertical_.front() >= 0.0f;
  integrate();
}

// EXT_lights_ies, "Coordinate System Mapping": the vertical plane is x-z, the horizontal one x-y; c
// turns counterclockwise, a and b clockwise.
V3f LightProfile::direction(Kind kind, float vertical_deg, float horizontal_deg) {
  const float sv = elementary::sin(vertical_deg * kDegree);
  const float cv = elementary::cos(vertical_deg * kDegree);
  const float sh = elementary::sin(horizontal_deg * kDegree);
  const float ch = elementary::cos(horizontal_deg * kDegree);
  switch (kind) {
  case Kind::a: return {sv, -cv * sh, -cv * ch};
  case Kind::b: return {ch * sv, -sh, -ch * cv};
  case Kind::c: break;
  }
  return {sv * ch, sv * sh, -cv};
}

float LightProfile::fold_horizontal(float degrees) const {
  const float first = horizontal_.front();
  const float last = horizontal_.back();
  if (kind_ != Kind::c) return first >= 0.0f ? std::fabs(degrees) : degrees;
  if (horizontal_.size() == 1) return first;
  if (degrees < 0.0f) degrees += 360.0f; // from [-180, 180]
  constexpr float kSlack = 0.01f;
  if (first >= 90.0f - kSlack && last <= 270.0f + kSlack) // about the plane of 90 and 270 degrees
    return degrees < 90.0f ? 180.0f - degrees : degrees > 270.0f ? 540.0f - degrees : degrees;
  if (last <= 180.0f + kSlack && degrees > 180.0f) degrees = 360.0f - degrees;
  if (last <= 90.0f + kSlack && degrees > 90.0f) degrees = 180.0f - degrees;
  return degrees;
}

float LightProfile::intensity(const V3f& d) const {
  float vertical = 0.0f;
  float horizontal = 0.0f;
  switch (kind_) {
  case Kind::a:
    vertical = 90.0f - acos_half_turns(d.x) * 180.0f;
    horizontal = atan2_turns(-d.y, -d.z) * 360.0f;
    break;
  case Kind::b:
    vertical = atan2_turns(d.x, -d.z) * 360.0f;
    horizontal = 90.0f - acos_half_turns(-d.y) * 180.0f;
    break;
  case Kind::c:
    vertical = acos_half_turns(-d.z) * 180.0f;
    horizontal = atan2_turns(d.y, d.x) * 360.0f;
    break;
  }
  if (mirrored_vertical_) vertical = std::fabs(vertical);
  constexpr float kRounding = 1e-3f; // degrees, of the polynomials
  if (vertical < vertical_.front() - kRounding || vertical > vertical_.back() + kRounding) return 0.0f;
  horizontal = fold_horizontal(horizontal);
  if (kind_ != Kind::c && (horizontal < horizontal_.front() - kRounding || horizontal > horizontal_.back() + kRounding))
    return 0.0f;
  const Place v = find(vertical_, vertical);
  const Place h = find(horizontal_, horizontal);
  const float* low = candela_.data() + h.below * vertical_.size();
  const float* high = candela_.data() + h.above * vertical_.size();
  return lerp(lerp(low[v.below], low[v.above], v.fraction), lerp(high[v.below], high[v.above], v.fraction), h.fraction);
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
