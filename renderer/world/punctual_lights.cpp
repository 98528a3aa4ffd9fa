// Converts punctual and photometric lights of the scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/punctual_lights.h"

#include "renderer/base/elementary.h"

namespace kindling {
namespace {

V3f row(const M44f& m, int i) { return {m[i][0], m[i][1], m[i][2]}; }

LightFrame frame_of(const M44f& m) {
  return {row(m, 3), row(m, 0).normalized(), row(m, 1).normalized(), row(m, 2).normalized()};
}

std::shared_ptr<const LightProfile> make_profile(const Photometry& web) {
  const LightProfile::Kind kind = web.kind == Photometry::Kind::a   ? LightProfile::Kind::a
                                  : web.kind == Photometry::Kind::b ? LightProfile::Kind::b
                                                                    : LightProfile::Kind::c;
  return std::make_shared<LightProfile>(kind, web.vertical_deg, web.horizontal_deg, web.candela);
}

} // namespace

void add_punctual_lights(const Scene& scene, const std::vector<PosedLight>& posed_lights, LightSetInput& input) {
  std::vector<std::shared_ptr<const LightProfile>> profiles(scene.photometries.size());
  for (uint32_t source = 0; source < posed_lights.size(); ++source) {
    const PosedLight& posed = posed_lights[source];
    const PunctualLight& light = scene.lights[static_cast<size_t>(posed.light)];
    const auto [position, x, y, z] = frame_of(posed.light_to_world);
    const Rgb strength = light.color * light.intensity;
    const float radius = light.radius_m.value_or(0.0f);
    std::vector<LightFrame> later;
    for (const M44f& key : posed.later_transforms) later.push_back(frame_of(key));
    if (light.photometry != kNone) {
      auto& profile = profiles[static_cast<size_t>(light.photometry)];
      if (!profile) profile = make_profile(scene.photometries[static_cast<size_t>(light.photometry)]);
      input.profiled.push_back({position, {x, y, z}, strength, profile, light.name, radius, std::move(later), source});
      continue;
    }
    switch (light.kind) {
    case PunctualLight::Kind::point:
      input.points.push_back({position, strength, light.range_m, light.name, radius, std::move(later), source});
      break;
    case PunctualLight::Kind::directional:
      input.directionals.push_back(
          {-z, strength, light.name, light.angular_diameter_rad.value_or(0.0f), std::move(later), source});
      break;
    case PunctualLight::Kind::spot:
      input.spots.push_back({position, -z, strength, elementary::cos(light.inner_cone_rad),
                             elementary::cos(light.outer_cone_rad), light.range_m, light.name, radius, std::move(later),
                             source});
      break;
    }
  }
}

} // namespace kindling
