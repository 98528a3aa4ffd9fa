// What a render did about its checkpoint, for the summary and the statistics.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_state.h"

#include <cstdint>
#include <string>

namespace kindling::app {

struct CheckpointReport {
  std::string file;
  uint32_t saves = 0; // of this run
  uint32_t failed_saves = 0;
  double save_s = 0.0;     // wall seconds spent on both, part of the render phase
  double spp_before = 0.0; // samples of a pixel that were there at the start, in the mean
  RenderWork work;         // of all runs
};

} // namespace kindling::app
