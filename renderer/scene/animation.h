// Samples animation channels: the value of one animated property at one time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <span>

namespace kindling {

// True if the values are quaternions (x, y, z, w), which must stay unit.
[[nodiscard]] bool is_rotation(const AnimationChannel& channel);

// Writes the channel's value at `time_s` to `out`, which has channel.components entries (glTF 2.0,
// section 3.11 and appendix C). Times outside of the keys give the first or last key. Rotations are
// unit quaternions (x, y, z, w): LINEAR uses slerp along the shorter arc, CUBICSPLINE is
// normalized. The channel must have at least one key and all of its values.
void sample_channel(const AnimationChannel& channel, double time_s, std::span<float> out);

} // namespace kindling
