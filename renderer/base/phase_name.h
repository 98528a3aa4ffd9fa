// Names of the phases of a render, for progress reports.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"

namespace kindling {

// Returns e.g. "render".
[[nodiscard]] constexpr const char* phase_name(Phase phase) {
  switch (phase) {
  case Phase::load: return "load";
  case Phase::textures: return "textures";
  case Phase::build: return "build";
  case Phase::render: return "render";
  case Phase::denoise: return "denoise";
  case Phase::write: return "write";
  }
  return "?";
}

} // namespace kindling
