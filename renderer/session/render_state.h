// All that a render has so far: what it goes on from after an interruption, and what parts of an image are merged from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/coverage.h"

#include <cstdint>

namespace kindling {

// What was spent on it, over all runs and parts.
struct RenderWork {
  double render_s = 0.0; // wall seconds of the render phase, added up
  double thread_s = 0.0; // the same times the threads
  RayCounters rays;      // without those of training
  uint32_t runs = 0;     // processes that had a part in it
};

struct RenderState {
  Film film; // of coverage.area(): the crop or a part of it; with adaptive sampling whole blocks
  Coverage coverage;
  AdaptiveState adaptive; // empty without adaptive sampling
  RenderWork work;
};

} // namespace kindling
