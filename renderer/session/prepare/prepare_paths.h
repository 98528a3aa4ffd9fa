// Finds the guide and what else pilots choose for a render before its first sample.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_session.h"

#include <cstdint>
#include <functional>

namespace kindling {

// The guide of a render and what its pilots have chosen, with how they were found.
struct PreparedPaths {
  TrainedGuide trained;
  LightPathChoice light_paths;
  SampleChoice path_reuse;
  DirectSampleChoice direct_samples;
  PhotonChoice photons;
  RateChoice sample_rates;

  [[nodiscard]] double busy_s() const {
    return trained.busy_s + light_paths.busy_s + path_reuse.busy_s + direct_samples.busy_s + photons.busy_s +
           sample_rates.busy_s;
  }
};

// Trains the guide of a render, beside photons if those are left open and some are chosen. If its
// light paths are left open, chooses them and, if there are some, trains a guide beside them; if
// path reuse, light samples and sample rates are, chooses those. Stores all of them in the
// settings, where sample rates are no longer `automatic` then.
// `stopped`, `on_done` as in train_guide(), `listener` may be null.
[[nodiscard]] PreparedPaths prepare_paths(const World& world, const Camera& camera, RenderSettings& settings,
                                          const std::function<bool()>& stopped,
                                          const std::function<void(uint64_t)>& on_done, ProgressListener* listener);

} // namespace kindling
