// Sizes pilots, and asks what light paths work with.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/choose_light_paths.h"

#include "renderer/session/check_settings.h"
#include "renderer/session/prepare/pilot_integrator.h"

#include <algorithm>

namespace kindling {
namespace {

// The render takes at least this many times the samples that a pilot may take; one that finds
// nothing to gain takes a few of those.
constexpr uint64_t kMinRenderPerPilot = 64;
constexpr uint64_t kMinPilotPaths = 1U << 14; // fewer say too little
constexpr uint64_t kMaxPilotPaths = 1U << 16;
constexpr double kPilotPathsPerSecond = 4096.0; // of a time limit: about a hundredth of it on one thread

} // namespace

uint64_t pilot_paths(const RenderSettings& settings) {
  const uint64_t pixels = static_cast<uint64_t>(settings.size_px.x) * static_cast<uint64_t>(settings.size_px.y);
  uint64_t paths = std::min(pixels * settings.planned() / kMinRenderPerPilot, kMaxPilotPaths);
  if (settings.time_limit_s) {
    const double affordable = std::min(kPilotPathsPerSecond * *settings.time_limit_s, double{kMaxPilotPaths});
    paths = std::min(paths, static_cast<uint64_t>(affordable));
  }
  return paths < kMinPilotPaths ? 0 : paths;
}

std::string why_no_light_paths(const RenderSettings& settings, const Camera& camera) {
  RenderSettings with = settings;
  with.integrator.light_paths = 1.0f;
  if (const Result<void> checked = check_light_paths(with, camera); !checked) return checked.error().message;
  const auto not_with = [](const std::string& what) { return "--light-paths auto: not with " + what; };
  if (settings.integrator.clamp_indirect < kInfinity)
    return not_with("--clamp-indirect, which hides the noise that a pilot measures");
  if (settings.integrator.photons > 0.0f) return not_with("--photons, which bring the same light");
  if (settings.integrator.manifold_samples > 0)
    return not_with("--manifold-samples, which bring some of the same light");
  if (settings.adaptive.enabled())
    return not_with("--noise-threshold, since blocks that stop end their light paths, which reach other blocks, too");
  if (pilot_paths(settings) == 0) return "--light-paths auto: the render is too short for a pilot";
  return {};
}

LightPathChoice choose_light_paths(const World& world, const Camera& camera, const RenderSettings& settings,
                                   const Guide* guide, const std::function<bool()>& stopped,
                                   ProgressListener* listener) {
  LightPathChoice choice;
  choice.why_none = why_no_light_paths(settings, camera);
  if (choice.why_none.empty())
    choice = choose_light_path_fraction(world, camera,
                                        {.integrator = pilot_integrator(settings),
                                         .filter = settings.filter,
                                         .guide = guide,
                                         .seed = settings.seed,
                                         .samples_per_pixel = settings.planned(),
                                         .paths = pilot_paths(settings)},
                                        stopped);
  if (!choice.why_none.empty() && listener != nullptr)
    listener->on_info("no light paths are traced: " + choice.why_none);
  return choice;
}

} // namespace kindling
