// A pilot that chooses the light samples and reflection samples at a path's first surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"
#include "renderer/integrator/pilots/sample_model.h"

namespace kindling {

struct DirectSampleChoice : SampleChoice { // `count`: of light samples
  int reflections = 0;                     // IntegratorSettings::reflection_samples
  SampleModel model;                       // of the numbers that were measured
  double lit = 1.0;                        // share of the pilot's blocks whose paths sample a light
  bool complete = false;                   // the model is of the whole pilot, not of its probe
};

// Renders blocks all over the image with one light sample at the first surface, and then their
// direct light alone with kMeasuredDirectSamples, and with two reflection samples as well
// (block_noise.h). Chooses the best numbers by the model that follows (sample_model.h), in which
// light samples and reflection samples have their likely shares of the noise (noise_shares.h). The
// pilot ends after a quarter of its paths where neither can gain. settings.integrator has the
// numbers that are not `open`, and always that of pixels. Once `stopped` returns true, the choice
// is 1 and 0.
[[nodiscard]] DirectSampleChoice choose_direct_samples(const World& world, const Camera& camera,
                                                       const SamplePilotSettings& settings, OpenCounts open,
                                                       const std::function<bool()>& stopped);

} // namespace kindling
