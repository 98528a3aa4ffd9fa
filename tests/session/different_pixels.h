// Counts the pixels by which images differ beyond rounding.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace kindling::test {

// Returns the number of pixels of two RGBA images whose red differs by more than rounding: their
// paths took another branch.
inline size_t different_pixels(const std::vector<float>& image, const std::vector<float>& oracle) {
  size_t different = 0;
  for (size_t i = 0; i < oracle.size(); i += 4)
    different += std::abs(image[i] - oracle[i]) > 1e-3f * (1.0f + oracle[i]) ? 1 : 0;
  return different;
}

} // namespace kindling::test
