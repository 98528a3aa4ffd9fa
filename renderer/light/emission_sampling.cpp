// Probabilities of emitters, by the light that each sends to the targets.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/emission_sampling.h"

#include <algorithm>
#include <utility>

namespace kindling {

namespace {

// Sum of the targets' solid angles from a point.
float solid_angle(std::span<const EmissionTarget> targets, const V3f& from) {
  float sum = 0.0f;
  for (const EmissionTarget& target : targets) {
    const float share = std::min(square(target.radius) / std::max((target.center - from).length2(), 1e-30f), 1.0f);
    sum += 2.0f * kPi * (1.0f - safe_sqrt(1.0f - share)) * (share < 1.0f ? 1.0f : 2.0f);
  }
  return sum;
}

float emitted_power(const LightSetView& lights, uint32_t triangle, std::span<const EmissionTarget> targets) {
  const LightSetView::Triangle& t = lights.triangles[triangle];
  const Emission& emission = lights.emissions[t.emission];
  // The texel in the middle may be black where others are not.
  const float bright =
      std::max(luminance(lights.emission_at(triangle, 1.0f / 3.0f, 1.0f / 3.0f)), 0.1f * luminance(emission.factor));
  const V3f middle = (t.p0 + t.p1 + t.p2) * (1.0f / 3.0f);
  return bright * 0.5f * double_area_normal(t).length() * solid_angle(targets, middle);
}

float emitted_power(const LightSetView::Punctual& light, std::span<const EmissionTarget> targets, float disk_area) {
  if (light.kind == LightSetView::Punctual::Kind::directional) return light.luminance * disk_area;
  return light.luminance * solid_angle(targets, light.position);
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
    running.push_back(running.back() + static_cast<double>(emitted_power(*lights, i, targets)));
  for (const LightSetView::Punctual& light : lights->punctuals)
    running.push_back(running.back() + static_cast<double>(emitted_power(light, targets, disk_area)));
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
