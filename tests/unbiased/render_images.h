// Renders images of one strategy with many seeds, and trains a guide for it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide.h"
#include "tests/unbiased/comparison.h"
#include "tests/unbiased/strategies.h"

#include <memory>

namespace kindling::test {

// Renders one image for each seed on one thread. The sides of the camera's image must be multiples
// of 8. `guide` may be null.
[[nodiscard]] Images render_images(const World& world, const Camera& camera, RenderSettings settings,
                                   uint32_t first_seed, uint32_t seeds, const Guide* guide);

// Trains one guide for all seeds, with the budget of a long render. Null if there is nothing to
// learn.
[[nodiscard]] std::unique_ptr<const Guide> train_one_guide(const World& world, const Camera& camera,
                                                           RenderSettings settings);

} // namespace kindling::test
