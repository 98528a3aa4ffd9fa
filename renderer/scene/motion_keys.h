// Chooses the number of motion keys of each moving object.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/motion_probe.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// The maximum number of segments between keys; a power of two.
inline constexpr uint32_t kMaxMotionSegments = 128;

// Returns the time of key `key` of `segments` + 1 keys, in seconds.
[[nodiscard]] inline double time_of_key(const Shutter& shutter, uint32_t key, uint32_t segments) {
  return shutter.open_s + (shutter.close_s - shutter.open_s) * (static_cast<double>(key) / segments);
}

// Returns for each probe the number of segments between keys: 0 if it is static, else the smallest
// power of two for which linear interpolation between keys stays close to the true motion:
// - for meshes, within a thousandth of their radius, the maximum distance of any of their points to
// their mean;
// - for cameras and lights, axes within 1e-4 and positions within a thousandth of their
// displacement.
// Three times inside of each segment and all keyframes inside of the shutter are compared. Jumps
// (STEP) never converge: they get the maximum number of keys and so move within 1/128 of the
// shutter. Changes the time of `nodes`. Deterministic.
[[nodiscard]] std::vector<uint32_t> choose_motion_segments(const Scene& scene, const Shutter& shutter,
                                                           std::span<const MotionProbe> probes, AnimatedNodes& nodes);

} // namespace kindling
