// The memory of a wave of the path tracer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/device/kernels/wave.h"
#include "renderer/integrator/stages/path_stages.h"
#include "renderer/integrator/stages/path_state.h"

#include <cstdint>

namespace kindling {

// A list that kernels append to, in any order.
struct WaveQueue {
  uint32_t* count = nullptr;
  uint32_t* paths = nullptr;

  // Returns the first place of new entries.
  [[nodiscard]] uint32_t take_places(uint32_t entries) const {
    return __atomic_fetch_add(count, entries, __ATOMIC_RELAXED);
  }
  void append(uint32_t path) const { paths[take_places(1)] = path; }
};

// A shadow ray's light. One thread traces all shadow rays of a path in this bounce, so that their
// sum has one order.
struct WaveShadow {
  ShadowRecord record;
  uint32_t count = 0; // of the path's rays from this one on; 0: none, or they belong to one before
};

// The argument of the kernels of path_kernels.h. A path keeps its number, its slot, until the end
// of the wave: that of its sample.
struct PathWave : Wave {
  // By path.
  PathState* states = nullptr;
  MediumStack* media = nullptr; // where the state is in_medium
  accel::Ray* path_rays = nullptr;
  accel::Hit* hits = nullptr;
  // Paths that continue, and those of the next bounce.
  WaveQueue active, next;
  // Shadow rays of this bounce: consecutive places for each path, as many as it has light samples.
  WaveQueue shadows; // without `paths`
  accel::Ray* shadow_rays = nullptr;
  WaveShadow* shadow_records = nullptr;
};

} // namespace kindling
