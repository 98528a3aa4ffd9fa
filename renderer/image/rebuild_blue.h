// Normal maps that store x and y alone: their z is rebuilt.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/image.h"

namespace kindling::image_detail {

// Makes a normal map whose directions (2 v - 1, unit) have only x and y an RGB image in which blue
// is z = sqrt(1 - x^2 - y^2), 0 if x and y are too long, in the image's own precision. Leaves other
// images as they are. What the image holds follows from its channels:
//   gray and alpha                                     x in gray, y in alpha
//   blue is 0 everywhere (a z of -1), or `constant_blue`   x in red, y in green
//   red, green and blue are equal, alpha is not constant   x in red, y in alpha
// None of these is a map of directions with a z of their own, which is above 0.
void rebuild_blue(Image& image, bool constant_blue);

} // namespace kindling::image_detail
