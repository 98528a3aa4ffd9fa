// The shutter interval of a camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kindling {

// Times of the animations in seconds; in a file, relative to the time of the image. close_s ==
// open_s freezes the scene.
struct Shutter {
  double open_s = 0.0;
  double close_s = 0.0; // >= open_s
};

} // namespace kindling
