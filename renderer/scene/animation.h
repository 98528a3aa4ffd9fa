// Samples animation channels: the value of one animated property at one time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <span>

namespace kindling {

// Whether its values are quaternions (x, y, z, w) that are to stay unit.
[[nodiscard]] bool is_rotation(const AnimationChannel& channel);

// Writes the channel's value at `time_s` (seconds) to `out`, which has channel.components entries (glTF 2.0,
// section 3.11 and appendix C). Before the first and after the last key the value is that key's. Rotations are
// quaternions (x, y, z, w), unit on return: LINEAR takes the shorter arc of the slerp, CUBICSPLINE is normalized. The
// channel needs at least one key and all of its values.
void sample_channel(const AnimationChannel& channel, double time_s, std::span<float> out);

} // namespace kindling
