// The angular distribution of a luminaire: intensity by direction, from measured angles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <vector>

namespace kindling {

// Intensity is interpolated bilinearly in the two angles of the photometric web, as between the measurements of IES LM-63. Vertical
// angles that the table does not reach are dark; horizontal ones are those that symmetry tells:
// kind c: one angle, all around; 0 to 90, each quarter; 0 to 180, both halves; 90 to 270 the same about the other plane; 0 to 360.
// kinds a and b: from 0, both sides; likewise the vertical angles.
class LightProfile {
 public:
  enum class Kind : uint8_t { a, b, c }; // of the angles: directions are those of direction()

  // Angles in degrees, increasing, neither list empty; as many candela as angles multiplied, all vertical ones of the first horizontal
  // angle first.
  LightProfile(Kind kind, std::vector<float> vertical_deg, std::vector<float> horizontal_deg,
               std::vector<float> candela);

  // Candela towards `direction` (unit, the light's frame).
  [[nodiscard]] float intensity(const V3f& direction) const;
  // The mean of the intensity over directions, weighted by itself: what a point that is lit may expect. 0: dark.
  [[nodiscard]] float typical_intensity() const { return typical_; }
  // Integral over the sphere, lumen.
  [[nodiscard]] float flux() const { return flux_; }

  // The direction that a pair of angles names; (0, 0) is -z.
  [[nodiscard]] static V3f direction(Kind kind, float vertical_deg, float horizontal_deg);

  [[nodiscard]] size_t memory_bytes() const {
    return sizeof(*this) + (vertical_.size() + horizontal_.size() + candela_.size()) * sizeof(float);
  }

 private:
  [[nodiscard]] float fold_horizontal(float degrees) const;
  void integrate();

  Kind kind_;
  bool mirrored_vertical_ = false; // kinds a and b that start at 0
  std::vector<float> vertical_;
  std::vector<float> horizontal_;
  std::vector<float> candela_;
  float typical_ = 0.0f;
  float flux_ = 0.0f;
};

} // namespace kindling
