// Measures how far the backs of single-sided faces are in the way of a view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/camera/place_camera.h"
#include "renderer/world/world.h"

#include <cstddef>
#include <string>

namespace kindling {

// Counts of a grid of camera rays.
struct BackFaceCounts {
  size_t hits = 0;     // rays that hit something
  size_t backs = 0;    // of these: their first surface is such a back
  size_t revealed = 0; // of these: another surface, not such a back, is behind it

  BackFaceCounts& operator+=(const BackFaceCounts& other);
  [[nodiscard]] double back_share() const { return share(backs, hits); }
  [[nodiscard]] double revealed_share() const { return share(revealed, backs); }
  // Rooms seen from outside have shares of 0.4 and more, of which nearly all reveal their inside.
  // Objects with open backs (cloth, leaves, cups) have less; a camera in a shell whose faces look
  // outwards reveals nothing.
  [[nodiscard]] bool in_the_way() const { return back_share() >= 0.25 && revealed_share() >= 0.75; }

 private:
  [[nodiscard]] static double share(size_t part, size_t all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0.0;
  }
};

// Traces rays through a grid of 64 points on the longer side of the image, when the shutter opens,
// without a lens. A function of its arguments. Surfaces covered by less than a half are looked
// through.
[[nodiscard]] BackFaceCounts count_back_faces(const World& world, const PlacedCamera& placed, const V2i& size_px);

// Returns a sentence without the name of the file, with the flag that changes what is done.
[[nodiscard]] std::string describe(const BackFaceCounts& counts);

} // namespace kindling
