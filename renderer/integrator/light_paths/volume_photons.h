// Light paths into scattering media: the training data of a volume guide.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/volume_guide.h"
#include "renderer/integrator/integrator.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace kindling {

struct VolumePhotonSettings {
  IntegratorSettings integrator; // of the path tracer that is to be guided
  uint32_t seed = 0;             // of the render
  uint64_t max_paths = 0;
  size_t enough_records = 0; // no more paths are traced once there are so many
};

// Traces light paths that lights aim at scattering media, as photon maps do (Jensen 1996, "Global
// Illumination using Photon Maps"), and returns the events of their random walks. There are none
// where no light with a size reaches such a medium. Paths have any time of the shutter. Runs on the
// threads of the current TBB arena, on which the result does not depend. `stopped` is polled and
// may be empty; once it returns true, the result is incomplete.
[[nodiscard]] std::vector<VolumeRecord> trace_volume_photons(const World& world, const VolumePhotonSettings& settings,
                                                             const std::function<bool()>& stopped,
                                                             RayCounters& counters);

} // namespace kindling
