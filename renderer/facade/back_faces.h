// Measures how far the backs of single-sided faces are in the way of a view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/camera/place_camera.h"
#include "renderer/world/world.h"

#include <string>

namespace kindling {

// Shares of a grid of camera rays.
struct BackFaceShares {
  double first = 0.0;    // of the rays that hit something: those whose first surface is such a back
  double revealed = 0.0; // of these: those that hit another surface, not such a back, behind it

  // Rooms seen from outside have shares of 0.4 and more, of which nearly all reveal their inside.
  // Objects with open backs (cloth, leaves, cups) have less; a camera in a shell whose faces look
  // outwards reveals nothing.
  [[nodiscard]] bool in_the_way() const { return first >= 0.25 && revealed >= 0.75; }
};

// Traces rays through a grid of 64 points on the longer side of the image, when the shutter opens,
// without a lens. A function of its arguments. Surfaces covered by less than a half are looked
// through.
[[nodiscard]] BackFaceShares measure_back_faces(const World& world, const PlacedCamera& placed, const V2i& size_px);

// Returns a sentence without the name of the file, with the flag that changes what is done.
[[nodiscard]] std::string describe(const BackFaceShares& shares);

} // namespace kindling
