// Random numbers of several light samples at one surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/sampling/bounce_draws.h"

#include <cassert>
#include <cstdint>

namespace kindling {

// Returns the address of light sample `number` of `count` that a path takes at a surface. All
// samples of the pixel's paths there, path after path, are points in a row of the path's sequence,
// so together they are as well distributed as if each belonged to a path of its own. A jittered
// sampler has one point for each of its strata; there each number has a sequence of its own.
// Indices wrap at 2^32: with a quarter of a million samples, pixels of a tile share points.
[[nodiscard]] inline SampleAddress light_sample_address(const SampleAddress& path, uint32_t number, uint32_t count) {
  assert(number < count);
  SampleAddress address = path;
  if (path.strata == 0)
    address.index = path.index * count + number;
  else if (number > 0)
    address.key = hash_combine(path.key, number);
  return address;
}

} // namespace kindling
