// A pilot that predicts what photons gain, and chooses how many to trace.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"

#include <cstdint>
#include <functional>
#include <string>

namespace kindling {

// The choice of the pilot; `count` has no meaning.
struct PhotonChoice : SampleChoice {
  float fraction = 0.0f; // IntegratorSettings::photons; 0: none
  std::string why_none;  // why a pilot was left out; empty: it was not, or none was asked for
};

// Returns why the scene has no use for photons, or why they must not depend on a pilot; empty: a
// pilot can choose them.
[[nodiscard]] std::string why_no_photons_in(const World& world, const Camera& camera,
                                            const SamplePilotSettings& settings);

// Renders blocks of a scene for which why_no_photons_in() is empty, all over the image, as
// settings.integrator says, which has no photons, and with photons in place of path reuse
// (block_noise.h). Chooses the fraction with the least error times cost; 0 if that is not
// kMinPhotonGain times below the product without photons. `samples_per_pixel`: planned, by which
// light that only photons bring outweighs noise. Once `stopped` returns true, the fraction is 0.
[[nodiscard]] PhotonChoice choose_photon_fraction(const World& world, const Camera& camera,
                                                  const SamplePilotSettings& settings, uint32_t samples_per_pixel,
                                                  const std::function<bool()>& stopped);

inline constexpr double kMinPhotonGain = 1.1;

// Returns the most photons for each sample of a pixel that the pilot may choose for an image of
// this size: maps of large images stay below 50 MB.
[[nodiscard]] float max_chosen_photons(const V2i& size_px);

} // namespace kindling
