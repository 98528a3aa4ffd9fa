// Rectangles in the scene that are bright by the light of others: where paths are sent on purpose.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// Parallel to a plane of the axes, at one surface or close to some.
struct BrightPatch {
  V3f center{0.0f};
  V3f half_size{0.0f};   // in meters; 0 along the axis of the facing
  uint32_t facing = 0;   // the side that shines: see facing_of()
  float strength = 0.0f; // radiance, relative to what comes from everywhere else
};

// A density of directions that knows where its goals are, so that one set serves all points of the scene without parallax:
// patch j is chosen with probability P_j = s_j F_j / (1 + sum s_k F_k), F the form factor from the point with nothing in
// between, and a point on it uniformly by area. The rest, 1 / (1 + sum), is left to others; at least kMinRest.
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
  // `normal`: unit, of the surface at `position`.
  void chances(const V3f& position, const V3f& normal, Chances& chances) const;
  // The sum over all patches that the direction passes through of P_j times density by solid angle, occluded or not: what
  // sample() has, but for the factor chances.sum. `wi` unit.
  [[nodiscard]] float density(const Chances& chances, const V3f& position, const V3f& wi) const;
  // A direction; unit. u_patch in [0, 1), u in [0, 1)^2; chances.sum > 0. Empty: too close to tell.
  [[nodiscard]] std::optional<V3f> sample(const Chances& chances, const V3f& position, float u_patch,
                                          const V2f& u) const;

  [[nodiscard]] std::span<const BrightPatch> patches() const { return {patches_.data(), count_}; }
  [[nodiscard]] bool empty() const { return count_ == 0; }

 private:
  using Lanes = std::array<float, kMax>;

  size_t count_ = 0;
  size_t lanes_ = 0; // count_, rounded up to whole vectors
  std::array<BrightPatch, kMax> patches_;
  alignas(32) Lanes center_x_{}, center_y_{}, center_z_{};
  alignas(32) Lanes normal_x_{}, normal_y_{}, normal_z_{};
  alignas(32) Lanes reach_x_{}, reach_y_{}, reach_z_{};    // half sizes; infinite along the normal
  alignas(32) Lanes area_{}, inverse_area_{}, strength_{}; // strength over pi
};

} // namespace kindling
