// The angular intensity distribution of a luminaire, from photometric measurements.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <vector>

namespace kindling {

// Intensity is interpolated bilinearly in the two angles of the photometric web, between the
// measurements of IES LM-63. Vertical angles beyond the table are dark. Horizontal angles are
// completed by symmetry. Kind c: a single angle is rotationally symmetric; 0 to 90 covers each
// quarter; 0 to 180 both halves; 90 to 270 likewise about the other plane; 0 to 360 has no
// symmetry. Kinds a and b: angles that start at 0 cover both sides, also for the vertical angles.
class LightProfile {
 public:
  enum class Kind : uint8_t { a, b, c }; // angular conventions: see direction()

  // Angles are in degrees and increasing, both lists nonempty. `candela` has one value per pair of
  // angles, all vertical angles of the first horizontal angle first.
  LightProfile(Kind kind, std::vector<float> vertical_deg, std::vector<float> horizontal_deg,
               std::vector<float> candela);

  // Returns candela towards `direction` (unit, in the light's frame).
  [[nodiscard]] float intensity(const V3f& direction) const;
  // Returns the mean intensity over directions, weighted by the intensity itself: the expected
  // intensity at a lit point. 0: dark.
  [[nodiscard]] float typical_intensity() const { return typical_; }
  // Returns the luminous flux, the integral over the sphere, in lumen.
  [[nodiscard]] float flux() const { return flux_; }

  // Returns the direction of a pair of angles; (0, 0) is -z.
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
