// Asks what photons work with, and calls their pilot.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/choose_photons.h"

#include "renderer/session/check_settings.h"
#include "renderer/session/prepare/choose_light_paths.h"
#include "renderer/session/prepare/pilot_integrator.h"

namespace kindling {

RenderSettings with_photons(RenderSettings settings, float fraction) {
  settings.integrator.photons = fraction;
  if (settings.chooses_path_reuse) settings.integrator.path_reuse = 1;
  settings.chooses_photons = settings.chooses_path_reuse = false;
  return settings;
}

std::string why_no_photons(const RenderSettings& settings, const Camera& camera) {
  const auto not_with = [](const std::string& what) { return "--photons auto: not with " + what; };
  const RenderSettings with = with_photons(settings, max_chosen_photons(settings.size_px));
  if (Result<void> checked = check_combination(with, camera); !checked) return checked.error().message;
  if (settings.integrator.clamp_indirect < kInfinity)
    return not_with("--clamp-indirect, which hides the noise that a pilot measures");
  if (settings.integrator.light_paths > 0.0f || settings.chooses_light_paths)
    return not_with("--light-paths, which bring some of the same light; use 0");
  if (pilot_paths(settings) == 0) return "--photons auto: the render is too short for a pilot";
  return {};
}

std::string why_no_photons(const World& world, const Camera& camera, const RenderSettings& settings) {
  std::string why = why_no_photons(settings, camera);
  return why.empty() ? why_no_photons_in(world, camera, sample_pilot(settings, nullptr, pilot_paths(settings))) : why;
}

PhotonChoice choose_photons(const World& world, const Camera& camera, const RenderSettings& settings,
                            const std::function<bool()>& stopped, ProgressListener* listener) {
  PhotonChoice choice;
  choice.why_none = why_no_photons(world, camera, settings);
  if (choice.why_none.empty())
    choice = choose_photon_fraction(world, camera, sample_pilot(settings, nullptr, pilot_paths(settings)),
                                    settings.planned(), stopped);
  if (!choice.why_none.empty() && listener != nullptr) listener->on_info("no photons are gathered: " + choice.why_none);
  return choice;
}

} // namespace kindling
