// The shares of the noise that light samples and reflection samples take away, from few pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace kindling {

// Parts of the noise with one light sample and no reflection sample.
struct NoiseShares {
  double lights = 0.0, reflections = 0.0;
};

// The noise of one block of pixels, in any unit: all of it, and the parts that fall with the number
// of light samples and of reflection samples, measured as differences that may be negative.
struct BlockShares {
  double all = 0.0, lights = 0.0, reflections = 0.0;
};

// Returns the likely shares, in [0, 1] with a sum of at most 1. Much of the noise is in few pixels,
// so that measured ratios have standard errors of .05 to 1. This is the mean of the normal
// distribution that they and their covariance among the blocks leave of what scenes have: under
// environments .55 and .19, with standard deviations of .25 and .15 and a correlation of -.7
// (thirteen scenes had .56 and .14, with deviations of .19 and .08). A share that is open alone has
// .4 and .3, and one that is not open is 0. `blocks` have some noise in all.
[[nodiscard]] NoiseShares likely_shares(std::span<const BlockShares> blocks, bool lights_open, bool reflections_open);

} // namespace kindling
