// Probabilities of emitters, by the light that each sends to the targets.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/emission_sampling.h"

#include <algorithm>
#include <utility>

namespace kindling {

namespace {

// The mean over the keys of a triangle that moves.
float triangle_power(const EmissionView& emission, uint32_t number) {
  const LightSetView& lights = *emission.lights;
  // The texel in the middle may be black where others are not.
  const float bright = std::max(luminance(lights.emission_at(number, 1.0f / 3.0f, 1.0f / 3.0f)),
                                0.1f * luminance(lights.emissions[lights.triangles[number].emission].factor));
  const uint32_t last = lights.moves(number) ? lights.moving[number - lights.first_moving].count : 0;
  float sum = 0.0f;
  for (uint32_t key = 0; key <= last; ++key) {
    const LightSetView::Triangle t = lights.triangle_at_key(number, key);
    const V3f middle = (t.p0 + t.p1 + t.p2) * (1.0f / 3.0f);
    sum += bright * 0.5f * double_area_normal(t).length() * emission.solid_angle(middle);
  }
  return sum / static_cast<float>(last + 1);
}

float punctual_power(const EmissionView& emission, const LightSetView::Punctual& light) {
  const bool in_sky = light.kind == LightSetView::Punctual::Kind::directional;
  if (in_sky) return light.luminance * emission.disk_area;
  if (light.key_count == 0) return light.luminance * emission.solid_angle(light.position);
  float sum = 0.0f;
  for (const LightFrame& frame : emission.lights->frames.subspan(light.first_key, light.key_count))
    sum += emission.solid_angle(frame.position);
  return light.luminance * sum / static_cast<float>(light.key_count);
}

// Estimates the light of the bright places of the environment on the cross section of a sphere.
float bright_irradiance(const EmissionView& emission) {
  if (!emission.lights->has_environment) return 0.0f;
  constexpr int kSide = 32;
  float sum = 0.0f;
  for (int i = 0; i < kSide * kSide; ++i) {
    const V2f u((static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const LightSample sky = emission.lights->environment.sample(u);
    if (sky.pdf > 0.0f && emission.is_bright(sky.radiance)) sum += luminance(sky.radiance) / sky.pdf;
  }
  return sum / (kSide * kSide);
}

} // namespace

EmissionSampling::EmissionSampling(const LightSetView& light_set, std::vector<EmissionTarget> aims,
                                   const Box3f& scene_bounds) {
  lights = &light_set;
  targets = arrays_.keep(std::move(aims));
  for (const EmissionTarget& target : targets) disk_area += kPi * square(target.radius);
  reach = (scene_bounds.max - scene_bounds.min).length() * 1.01f;

  std::vector<double> running{0.0};
  for (uint32_t i = 0; i < lights->triangles.size(); ++i)
    running.push_back(running.back() + static_cast<double>(triangle_power(*this, i)));
  for (const LightSetView::Punctual& light : lights->punctuals)
    running.push_back(running.back() + static_cast<double>(punctual_power(*this, light)));
  // Four times the mean: lamps and the sun, but not the sky around them.
  if (lights->has_environment) bright_sky = 4.0f * lights->environment_irradiance * kInvPi;
  running.push_back(running.back() + static_cast<double>(bright_irradiance(*this) * disk_area));
  if (!(running.back() > 0.0)) return;
  std::vector<float> cumulative;
  cumulative.reserve(running.size());
  for (const double sum : running) cumulative.push_back(static_cast<float>(sum / running.back()));
  cdf = arrays_.keep(std::move(cumulative));
}

} // namespace kindling
