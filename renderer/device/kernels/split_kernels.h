// The kernels of waves whose light is split by light group and first event (split_view.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/kernels/path_kernels.h"
#include "renderer/device/kernels/reuse_kernels.h"
#include "renderer/integrator/stages/split_reuse.h"
#include "renderer/integrator/stages/split_sink.h"

#include <cstddef>
#include <cstdint>

namespace kindling::kernels {

// Tells SplitSink its places in a wave. One kernel serves light paths, photons and shared paths.
struct PlacedWaveSink : WaveSink<Beside::photons, true> {
  const PathStages& path_stages;

  [[nodiscard]] PhotonMapView photons_of(const PathInFlight& path) const {
    return wave.photons.views != nullptr ? wave.photons.of_sample(path.map_sample) : PhotonMapView{};
  }
  [[nodiscard]] size_t slot_of(const PathState& state) const { return static_cast<size_t>(&state - wave.states); }
  [[nodiscard]] size_t last_shadow() const { return first_shadow + shadow_count - 1; }
};

struct SplitWaveSink : SplitSink<PlacedWaveSink> {
  [[nodiscard]] static SplitWaveSink of(const PathWave& wave) {
    SplitWaveSink sink{{{{wave}, wave.scene->stages}, wave.split}};
    sink.split.groups = &wave.scene->groups;
    return sink;
  }
};

// By path, after begin_path().
inline void begin_split(const PathWave& wave, uint32_t slot) { wave.split.start(slot); }

// By active path, in place of shade().
inline void shade_split(const PathWave& wave, uint32_t number) { shade_path<SplitWaveSink>(wave, number); }

// By shadow ray, after trace_shadow(): if it is its path's first one, adds the light of them all.
inline void split_shadow(const PathWave& wave, uint32_t number) {
  const uint32_t count = wave.shadow_records[number].count;
  for (uint32_t i = number; i < number + count; ++i)
    if (!is_black(wave.shadow_records[i].record.contribution))
      wave.split.add_shadow(wave.shadow_records[i].record, wave.split.shadows[i]);
}

// By path, before start_sharing() and after share_light().
inline void split_tail(const PathWave& wave, uint32_t slot) {
  take_tail(wave.split, wave.reuse, slot, wave.states[slot]);
}
inline void split_shared(const PathWave& wave, uint32_t slot) {
  split_received(wave.split, wave.reuse, slot, group_of(wave, slot));
}

// In place of finish_pixel().
inline void finish_split_pixel(const PathWave& wave, uint32_t pixel) {
  add_pixel(wave, pixel, finished_path(wave), [&](uint32_t slot, const FilmSample& sample) {
    wave.split.add_to(wave.film, pixel, slot, sample, wave.scene->stages.settings);
  });
}

} // namespace kindling::kernels
