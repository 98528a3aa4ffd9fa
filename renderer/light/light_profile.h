// The angular intensity distribution of a luminaire, from photometric measurements.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/owned_arrays.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Intensity is interpolated bilinearly in the two angles of the photometric web, between the
// measurements of IES LM-63. Vertical angles beyond the table are dark. Horizontal angles are
// completed by symmetry. Kind c: a single angle is rotationally symmetric; 0 to 90 covers each
// quarter; 0 to 180 both halves; 90 to 270 likewise about the other plane; 0 to 360 has no
// symmetry. Kinds a and b: angles that start at 0 cover both sides, also for the vertical angles.
struct LightProfileView {
  enum class Kind : uint8_t { a, b, c }; // angular conventions: see LightProfile::direction()

  // Returns candela towards `direction` (unit, in the light's frame).
  [[nodiscard]] float intensity(const V3f& direction) const;
  [[nodiscard]] float fold_horizontal(float degrees) const;

  Kind kind = Kind::c;
  bool mirrored_vertical = false; // kinds a and b that start at 0
  // Angles are in degrees and increasing, neither list is empty. `candela` has one value per pair
  // of angles, all vertical angles of the first horizontal angle first.
  std::span<const float> vertical_deg;
  std::span<const float> horizontal_deg;
  std::span<const float> candela;
};

class LightProfile : public LightProfileView {
 public:
  // The arguments are those of the view.
  LightProfile(Kind convention, std::vector<float> verticals, std::vector<float> horizontals,
               std::vector<float> intensities);

  // Returns the mean intensity over directions, weighted by the intensity itself: the expected
  // intensity at a lit point. 0: dark.
  [[nodiscard]] float typical_intensity() const { return typical_; }
  // Returns the luminous flux, the integral over the sphere, in lumen.
  [[nodiscard]] float flux() const { return flux_; }

  // Returns the direction of a pair of angles in degrees; (0, 0) is -z.
  [[nodiscard]] static V3f direction(Kind convention, float vertical, float horizontal);

  [[nodiscard]] size_t memory_bytes() const { return sizeof(*this) + arrays_.bytes(); }

 private:
  void integrate();

  OwnedArrays arrays_;
  float typical_ = 0.0f;
  float flux_ = 0.0f;
};

} // namespace kindling
