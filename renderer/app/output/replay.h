// Formats the path of a replayed sample.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_session.h"

#include <string>

namespace kindling::app {

// Returns a line about the sample, then a table with one row for each vertex of the path. World
// space, meters, linear Rec. 709.
[[nodiscard]] std::string format_replay(const ReplayedSample& sample, const V2i& pixel, uint32_t sample_index);

} // namespace kindling::app
