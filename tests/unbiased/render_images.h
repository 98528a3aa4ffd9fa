// Images of many seeds by one strategy, and the guide that it may follow.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide.h"
#include "tests/unbiased/comparison.h"
#include "tests/unbiased/strategies.h"

#include <memory>

namespace kindling::test {

// Settings as for a render on one thread; the sides of the camera's image are multiples of eight. `guide` may be null.
[[nodiscard]] Images render_images(const World& world, const Camera& camera, RenderSettings settings,
                                   uint32_t first_seed, uint32_t seeds, const Guide* guide);

// What a render that is worth much training would learn: one guide for all seeds. Null if there is nothing to learn.
[[nodiscard]] std::unique_ptr<const Guide> train_one_guide(const World& world, const Camera& camera,
                                                           RenderSettings settings);

} // namespace kindling::test
