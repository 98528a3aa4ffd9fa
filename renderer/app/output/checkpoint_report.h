// Saves of a checkpoint during a render, for the summary and the statistics.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_state.h"

#include <cstdint>
#include <string>

namespace kindling::app {

struct CheckpointReport {
  std::string file;
  uint32_t saves = 0; // in this run
  uint32_t failed_saves = 0;
  double save_s = 0.0;     // wall seconds spent on both, part of the render phase
  double spp_before = 0.0; // mean samples per pixel in the file at the start
  RenderWork work;         // sum over all runs
};

} // namespace kindling::app
