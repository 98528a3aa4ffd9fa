// Selection, sampling and density of bright patches, in vectorizable loops.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/bright_patches.h"

#include "renderer/guiding/guide_record.h"

#include <cassert>

namespace kindling {
namespace {

constexpr size_t kVector = 8;

// Sums in an order that vectors can follow.
float sum_of(const float* lanes, size_t count) {
  std::array<float, kVector> sums{};
  for (size_t j = 0; j < count; j += kVector)
    for (size_t k = 0; k < kVector; ++k) sums[k] += lanes[j + k];
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

} // namespace

BrightPatches::BrightPatches(std::span<const BrightPatch> patches)
    : count_(std::min(patches.size(), kMax)), lanes_((count_ + kVector - 1) / kVector * kVector) {
  for (size_t j = 0; j < count_; ++j) {
    const BrightPatch& patch = patches_[j] = patches[j];
    const auto axis = static_cast<int>(patch.facing / 2);
    V3f normal(0.0f), reach = patch.half_size;
    normal[axis] = patch.facing % 2 == 0 ? 1.0f : -1.0f;
    reach[axis] = kInfinity;
    center_x_[j] = patch.center.x, center_y_[j] = patch.center.y, center_z_[j] = patch.center.z;
    normal_x_[j] = normal.x, normal_y_[j] = normal.y, normal_z_[j] = normal.z;
    reach_x_[j] = reach.x, reach_y_[j] = reach.y, reach_z_[j] = reach.z;
    area_[j] = 4.0f * patch.half_size[(axis + 1) % 3] * patch.half_size[(axis + 2) % 3];
    inverse_area_[j] = 1.0f / area_[j];
    strength_[j] = patch.strength * kInvPi;
  }
}

// Uses form factors between small elements, with a lower bound of the distance.
void BrightPatches::chances(const V3f& position, const V3f& normal, Chances& chances) const {
  float* const out = chances.of.data();
  for (size_t j = 0; j < lanes_; ++j) {
    const float dx = center_x_[j] - position.x, dy = center_y_[j] - position.y, dz = center_z_[j] - position.z;
    const float here = std::max(dx * normal.x + dy * normal.y + dz * normal.z, 0.0f);
    const float there = std::max(-(dx * normal_x_[j] + dy * normal_y_[j] + dz * normal_z_[j]), 0.0f);
    const float distance2 = dx * dx + dy * dy + dz * dz + 0.25f * area_[j];
    out[j] = distance2 > 0.0f ? strength_[j] * area_[j] * here * there / (distance2 * distance2) : 0.0f;
  }
  const float sum = sum_of(out, lanes_);
  const float scale = 1.0f / std::max(1.0f + sum, sum * (1.0f / (1.0f - kMinRest)));
  for (size_t j = 0; j < lanes_; ++j) out[j] *= scale;
  chances.sum = sum * scale;
}

float BrightPatches::density(const Chances& chances, const V3f& position, const V3f& wi) const {
  alignas(32) Lanes densities;
  for (size_t j = 0; j < lanes_; ++j) {
    const float dx = center_x_[j] - position.x, dy = center_y_[j] - position.y, dz = center_z_[j] - position.z;
    const float across = normal_x_[j] * wi.x + normal_y_[j] * wi.y + normal_z_[j] * wi.z;
    const float distance = (normal_x_[j] * dx + normal_y_[j] * dy + normal_z_[j] * dz) / across;
    const bool inside = (std::fabs(wi.x * distance - dx) <= reach_x_[j]) &
                        (std::fabs(wi.y * distance - dy) <= reach_y_[j]) &
                        (std::fabs(wi.z * distance - dz) <= reach_z_[j]) & (across < 0.0f) & (distance > 0.0f);
    densities[j] = inside ? chances.of[j] * distance * distance * inverse_area_[j] / -across : 0.0f;
  }
  return sum_of(densities.data(), lanes_);
}

std::optional<V3f> BrightPatches::sample(const Chances& chances, const V3f& position, float u_patch,
                                         const V2f& u) const {
  assert(chances.sum > 0.0f && u_patch >= 0.0f && u_patch <= 1.0f);
  float rest = u_patch * chances.sum;
  size_t chosen = 0;
  for (size_t j = 0; j < count_; ++j) {
    if (!(chances.of[j] > 0.0f)) continue;
    chosen = j;
    if (rest < chances.of[j]) break;
    rest -= chances.of[j];
  }
  const BrightPatch& patch = patches_[chosen];
  const auto axis = static_cast<int>(patch.facing / 2);
  V3f to_patch = patch.center - position;
  to_patch[(axis + 1) % 3] += (2.0f * u.x - 1.0f) * patch.half_size[(axis + 1) % 3];
  to_patch[(axis + 2) % 3] += (2.0f * u.y - 1.0f) * patch.half_size[(axis + 2) % 3];
  const float length2 = to_patch.length2();
  if (!(length2 > 0.0f)) return std::nullopt;
  return to_patch * (1.0f / std::sqrt(length2));
}

} // namespace kindling
