// The first surface of the sample nearest to a pixel's center.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/aov.h"

#include <cstdint>

namespace kindling {

// A record of the Film. Of two samples the one closer to the center remains, of two as close the
// one with the smaller number: the remaining one does not depend on the order of samples.
struct NearestSample {
  uint32_t number = 0;      // of the sample in its pixel, from 1; 0: no sample yet
  float distance2 = 0.0f;   // from the pixel's center, square pixels
  uint32_t object_id = 0;   // number of the node in the file, from 1; 0: a miss, and all but the motion is 0
  uint32_t material_id = 0; // number of the material, from 1; that without a material is last
  float depth = 0.0f;       // along the camera's axis, meters
  float position[3] = {};   // world space, meters
  float uv[2] = {};         // texture coordinates of set 0
  // Position in the previous frame minus that in this one, and position in the next one minus that
  // in this one: pixels, x to the right, y upwards. 0 if it cannot be seen there, in the plane of
  // the camera or behind it.
  float to_previous[2] = {}, to_next[2] = {};

  // True if a sample with this number (from 1) and distance replaces this one.
  [[nodiscard]] bool yields_to(uint32_t other_number, float other_distance2) const {
    if (number == 0 || other_distance2 < distance2) return true;
    return other_distance2 == distance2 && other_number < number;
  }
  void add(const NearestSample& other) {
    if (other.number != 0 && yields_to(other.number, other.distance2)) *this = other;
  }

  // Writes the channels of an AOV of the nearest sample.
  void resolve(Aov aov, float* out) const {
    switch (aov) {
    case Aov::object_id: out[0] = static_cast<float>(object_id); return;
    case Aov::material_id: out[0] = static_cast<float>(material_id); return;
    case Aov::depth_nearest: out[0] = depth; return;
    case Aov::position_nearest:
      for (int c = 0; c < 3; ++c) out[c] = position[c];
      return;
    case Aov::uv:
      out[0] = uv[0];
      out[1] = uv[1];
      out[2] = object_id != 0 ? 1.0f : 0.0f;
      return;
    case Aov::vector: // as in Blender: both are the way that the surface goes backwards in time
      for (int c = 0; c < 2; ++c) {
        out[c] = to_previous[c];
        out[2 + c] = 0.0f - to_next[c]; // no negative zero
      }
      return;
    case Aov::motion: // as in Nuke
      for (int c = 0; c < 2; ++c) {
        out[c] = to_next[c];
        out[2 + c] = to_previous[c];
      }
      return;
    default: return;
    }
  }
};
static_assert(sizeof(NearestSample) == 56);

} // namespace kindling
