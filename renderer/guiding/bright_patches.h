// Bright rectangles in the scene as a guide: path guiding samples directions towards them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// A rectangle parallel to two coordinate axes, on or close to surfaces, or in an opening.
struct BrightPatch {
  V3f center{0.0f};
  V3f half_size{0.0f};   // in meters; 0 along the axis of the facing
  uint32_t facing = 0;   // the emitting side: see facing_of()
  float strength = 0.0f; // radiance, relative to the rest of the surroundings
};

// A density of directions defined by its targets, so that one set serves all points of the scene
// without parallax. Patch j is selected with probability P_j = s_j F_j / (1 + sum s_k F_k), where F
// is the unoccluded form factor from the point, and a point on it is sampled uniformly by area. The
// remaining probability, 1 / (1 + sum) and at least kMinRest, is left to other techniques.
//
// Immutable, thread-safe, no allocation.
class BrightPatches {
 public:
  static constexpr size_t kMax = 16;
  static constexpr float kMinRest = 0.25f;

  BrightPatches() = default;
  explicit BrightPatches(std::span<const BrightPatch> patches); // at most kMax

  struct alignas(32) Chances {
    std::array<float, kMax> of; // P_j
    float sum = 0.0f;
  };
  // Computes the selection probabilities; `normal` is unit, of the surface at `position`.
  void chances(const V3f& position, const V3f& normal, Chances& chances) const;
  // Returns the sum, over all patches that the direction crosses, of P_j times the solid-angle
  // density, occluded or not: the density of sample() times chances.sum. `wi` is unit.
  [[nodiscard]] float density(const Chances& chances, const V3f& position, const V3f& wi) const;
  // Samples a unit direction; u_patch in [0, 1), u in [0, 1)^2; chances.sum must be > 0. Empty: too
  // close to the patch.
  [[nodiscard]] std::optional<V3f> sample(const Chances& chances, const V3f& position, float u_patch,
                                          const V2f& u) const;

  [[nodiscard]] std::span<const BrightPatch> patches() const { return {patches_.data(), count_}; }
  [[nodiscard]] bool empty() const { return count_ == 0; }

 private:
  using Numbers = std::array<float, kMax>;

  size_t count_ = 0;
  size_t lanes_ = 0; // count_, rounded up to whole vectors
  std::array<BrightPatch, kMax> patches_;
  alignas(32) Numbers center_x_{}, center_y_{}, center_z_{};
  alignas(32) Numbers normal_x_{}, normal_y_{}, normal_z_{};
  alignas(32) Numbers reach_x_{}, reach_y_{}, reach_z_{};    // half sizes; infinite along the normal
  alignas(32) Numbers area_{}, inverse_area_{}, strength_{}; // strength over pi
};

} // namespace kindling
