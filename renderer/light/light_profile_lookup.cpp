// Lookup in a photometric web.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/equirect.h"
#include "renderer/light/light_profile.h"

#include <algorithm>

namespace kindling {
namespace {

struct Place {
  size_t below = 0;
  size_t above = 0;
  float fraction = 0.0f;
};

// Returns the two angles that enclose `degrees`, clamped to the first and the last.
Place find(std::span<const float> angles, float degrees) {
  const auto after = static_cast<size_t>(std::upper_bound(angles.begin(), angles.end(), degrees) - angles.begin());
  if (after == 0) return {};
  if (after == angles.size()) return {after - 1, after - 1, 0.0f};
  const float from = angles[after - 1];
  return {after - 1, after, (degrees - from) / (angles[after] - from)};
}

} // namespace

float LightProfileView::fold_horizontal(float degrees) const {
  const float first = horizontal_deg.front();
  const float last = horizontal_deg.back();
  if (kind != Kind::c) return first >= 0.0f ? std::fabs(degrees) : degrees;
  if (horizontal_deg.size() == 1) return first;
  if (degrees < 0.0f) degrees += 360.0f; // from [-180, 180]
  constexpr float kSlack = 0.01f;
  if (first >= 90.0f - kSlack && last <= 270.0f + kSlack) // about the plane of 90 and 270 degrees
    return degrees < 90.0f ? 180.0f - degrees : degrees > 270.0f ? 540.0f - degrees : degrees;
  if (last <= 180.0f + kSlack && degrees > 180.0f) degrees = 360.0f - degrees;
  if (last <= 90.0f + kSlack && degrees > 90.0f) degrees = 180.0f - degrees;
  return degrees;
}

float LightProfileView::intensity(const V3f& d) const {
  float vertical = 0.0f;
  float horizontal = 0.0f;
  switch (kind) {
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
  if (mirrored_vertical) vertical = std::fabs(vertical);
  constexpr float kRounding = 1e-3f; // degrees, of the polynomials
  if (vertical < vertical_deg.front() - kRounding || vertical > vertical_deg.back() + kRounding) return 0.0f;
  horizontal = fold_horizontal(horizontal);
  if (kind != Kind::c &&
      (horizontal < horizontal_deg.front() - kRounding || horizontal > horizontal_deg.back() + kRounding))
    return 0.0f;
  const Place v = find(vertical_deg, vertical);
  const Place h = find(horizontal_deg, horizontal);
  const float* low = candela.data() + h.below * vertical_deg.size();
  const float* high = candela.data() + h.above * vertical_deg.size();
  return lerp(lerp(low[v.below], low[v.above], v.fraction), lerp(high[v.below], high[v.above], v.fraction), h.fraction);
}

} // namespace kindling
