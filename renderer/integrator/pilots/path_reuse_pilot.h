// A pilot that chooses the number of pixels that share their paths.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/pilots/block_noise.h"
#include "renderer/integrator/pilots/sample_model.h"

namespace kindling {

struct PathReuseChoice {
  SampleChoice sharing; // `count`: of pixels
  SampleCounts counts;  // with the samples that are best beside so many pixels
};

// Renders blocks all over the image without path reuse and with groups of the largest size, at the
// light samples and reflection samples of settings.integrator (block_noise.h). Adds to `model`, in
// which these are possible numbers, and chooses the best numbers of all that are open
// (sample_model.h). Nothing is rendered where model.of_indirect is too small for any gain. Once
// `stopped` returns true, the choice is 1, and the samples are those of the settings.
[[nodiscard]] PathReuseChoice choose_path_reuse(const World& world, const Camera& camera,
                                                const SamplePilotSettings& settings, SampleModel model, OpenCounts open,
                                                const std::function<bool()>& stopped);

} // namespace kindling
