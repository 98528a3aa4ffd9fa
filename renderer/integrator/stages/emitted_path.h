// The first ray of a path that begins at a light.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"
#include "renderer/base/hash.h"
#include "renderer/light/emission_view.h"
#include "renderer/sampling/sampler.h"
#include "renderer/world/world_view.h"

#include <cstdint>
#include <optional>

namespace kindling {

// Dimensions that start_emitted_path() draws.
inline constexpr uint32_t kEmittedChoice = 0, kEmittedPosition = 1, kEmittedDirection = 2;
inline constexpr uint32_t kAfterEmission = 3; // the first one that is free
inline constexpr uint32_t kEmittedTime = 255; // drawn if anything moves

struct EmittedPath {
  EmittedRay emitted;
  accel::Ray ray;
};

// Samples a light's ray by the random numbers of (key, index), at time 0 or any time of the
// shutter. Empty: it carries no light.
[[nodiscard]] inline std::optional<EmittedPath> start_emitted_path(const EmissionView& emission, uint32_t key,
                                                                   uint32_t index, bool shutter_open) {
  const V2f choice = Sampler::sample_2d(key, index, kEmittedChoice);
  const std::optional<EmittedRay> emitted =
      emission.sample({choice.x, choice.y, Sampler::sample_2d(key, index, kEmittedPosition),
                       Sampler::sample_2d(key, index, kEmittedDirection),
                       shutter_open ? Sampler::sample_1d(key, index, kEmittedTime) : 0.0f});
  if (!emitted) return std::nullopt;
  // Emitters with a surface are not hit again from just above it.
  const float lift =
      emitted->emitter < emission.lights->triangles.size() ? 1e-5f * (max_abs(emitted->origin) + 1e-3f) : 0.0f;
  return EmittedPath{*emitted,
                     {.origin = emitted->origin + emitted->direction * lift,
                      .t_min = 0.0f,
                      .direction = emitted->direction,
                      .t_max = kInfinity,
                      .key = hash_combine(key, index),
                      .time = emitted->time,
                      .index = index,
                      .flags = kHitPartlyTransparent}};
}

} // namespace kindling
