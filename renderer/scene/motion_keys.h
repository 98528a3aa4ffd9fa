// How many keys a motion needs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/motion_probe.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// As many segments between keys as anything gets, in powers of two.
inline constexpr uint32_t kMaxMotionSegments = 128;

// The time of key `key` of `segments` + 1.
[[nodiscard]] inline double time_of_key(const Shutter& shutter, uint32_t key, uint32_t segments) {
  return shutter.open_s + (shutter.close_s - shutter.open_s) * (static_cast<double>(key) / segments);
}

// For each probe the number of segments between keys: 0 for what stands still, else the least power of two with which points between
// keys, interpolated linearly, stay close to where they are:
// - of meshes, within a thousandth of their radius, the largest distance of any of their points to the mean of them;
// - axes of cameras and lights within 1e-4, their positions within a thousandth of the way that they go.
// Compared are three times inside of each segment, and all keyframes of the animations inside of the shutter. What jumps (STEP) never
// is close: it gets all the keys there are, and so moves within 1/128 of the shutter.
// Sets the time of the nodes. Deterministic.
[[nodiscard]] std::vector<uint32_t> choose_motion_segments(const Scene& scene, const Shutter& shutter,
                                                           std::span<const MotionProbe> probes, AnimatedNodes& nodes);

} // namespace kindling
