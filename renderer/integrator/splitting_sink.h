// The sink of batches whose light is split by light group and first event.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/batch_sink.h"
#include "renderer/integrator/stages/split_sink.h"

#include <cstddef>

namespace kindling {

// Tells SplitSink its places in a batch.
struct PlacedBatchSink : BatchSink {
  [[nodiscard]] PhotonMapView photons_of(const PathInFlight& path) const {
    return context.photon_maps.empty() ? PhotonMapView{} : context.photon_maps.of_sample(path.map_sample).view();
  }
  [[nodiscard]] size_t slot_of(const PathState& state) const {
    return static_cast<size_t>(&state - context.states.data());
  }
  [[nodiscard]] size_t last_shadow() const { return context.shadow_records.size() - 1; }
};

using SplittingSink = SplitSink<PlacedBatchSink>;

} // namespace kindling
