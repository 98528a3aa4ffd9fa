// The first surface of the sample nearest to a pixel's center.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

// A record of the Film. Of two samples the one closer to the center remains, of two as close the
// one with the smaller number: the remaining one does not depend on the order of samples.
struct NearestSample {
  uint32_t number = 0;      // of the sample in its pixel, from 1; 0: no sample yet
  float distance2 = 0.0f;   // from the pixel's center, square pixels
  uint32_t object_id = 0;   // number of the node in the file, from 1; 0: a miss, and all below is 0
  uint32_t material_id = 0; // number of the material, from 1; that without a material is last
  float depth = 0.0f;       // along the camera's axis, meters
  float position[3] = {};   // world space, meters
  float uv[2] = {};         // texture coordinates of set 0

  // True if a sample with this number (from 1) and distance replaces this one.
  [[nodiscard]] bool yields_to(uint32_t other_number, float other_distance2) const {
    if (number == 0 || other_distance2 < distance2) return true;
    return other_distance2 == distance2 && other_number < number;
  }
  void add(const NearestSample& other) {
    if (other.number != 0 && yields_to(other.number, other.distance2)) *this = other;
  }
};
static_assert(sizeof(NearestSample) == 40);

} // namespace kindling
