// Selection, sampling and density of bright patches, eight at a time.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/bright_patches.h"

#include "renderer/base/lanes.h"
#include "renderer/base/on_gpu.h"
#include "renderer/guiding/guide_record.h"

#include <cassert>

namespace kindling {
namespace {

constexpr size_t kVector = Lanes::kCount;

// The numbers with which patches are computed: eight at a time, but one by one on a GPU, whose
// threads have no vectors. Sums have the order of vectors on both.
#if KINDLING_ON_GPU
using Patches = float;
constexpr size_t kStep = 1;
float load(const float* values) { return *values; }
void store(float patch, float* values) { *values = patch; }
#else
using Patches = Lanes;
constexpr size_t kStep = kVector;
Lanes load(const float* values) { return Lanes::load(values); }
void store(const Lanes& patches, float* values) { patches.store(values); }
#endif

// Sums of the patches whose numbers have the same remainder by eight, and of these sums.
class PatchSums {
 public:
#if KINDLING_ON_GPU
  void add(size_t patch, float value) { sums_[patch % kVector] += value; }
#else
  void add(size_t /*first_patch*/, const Lanes& values) { sums_ = sums_ + values; }
#endif
  [[nodiscard]] float total() const {
    return ((sums_[0] + sums_[1]) + (sums_[2] + sums_[3])) + ((sums_[4] + sums_[5]) + (sums_[6] + sums_[7]));
  }

 private:
#if KINDLING_ON_GPU
  std::array<float, kVector> sums_{};
#else
  Lanes sums_{0.0f};
#endif
};

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
  PatchSums sums;
  for (size_t j = 0; j < lanes_; j += kStep) {
    const Patches dx = load(&center_x_[j]) - position.x, dy = load(&center_y_[j]) - position.y,
                  dz = load(&center_z_[j]) - position.z, area = load(&area_[j]), zero = 0.0f;
    const Patches here = maximum(dx * normal.x + dy * normal.y + dz * normal.z, zero);
    const Patches there =
        maximum(-(dx * load(&normal_x_[j]) + dy * load(&normal_y_[j]) + dz * load(&normal_z_[j])), zero);
    const Patches distance2 = dx * dx + dy * dy + dz * dz + area * 0.25f;
    const Patches unscaled =
        select(distance2 > 0.0f, load(&strength_[j]) * area * here * there / (distance2 * distance2), zero);
    store(unscaled, out + j);
    sums.add(j, unscaled);
  }
  const float sum = sums.total();
  const float scale = 1.0f / std::max(1.0f + sum, sum * (1.0f / (1.0f - kMinRest)));
  for (size_t j = 0; j < lanes_; j += kStep) store(load(out + j) * scale, out + j);
  chances.sum = sum * scale;
}

float BrightPatches::density(const Chances& chances, const V3f& position, const V3f& wi) const {
  PatchSums sums;
  for (size_t j = 0; j < lanes_; j += kStep) {
    const Patches dx = load(&center_x_[j]) - position.x, dy = load(&center_y_[j]) - position.y,
                  dz = load(&center_z_[j]) - position.z;
    const Patches nx = load(&normal_x_[j]), ny = load(&normal_y_[j]), nz = load(&normal_z_[j]);
    const Patches across = nx * wi.x + ny * wi.y + nz * wi.z;
    const Patches distance = (nx * dx + ny * dy + nz * dz) / across;
    const auto inside = (absolute(distance * wi.x - dx) <= load(&reach_x_[j])) &
                        (absolute(distance * wi.y - dy) <= load(&reach_y_[j])) &
                        (absolute(distance * wi.z - dz) <= load(&reach_z_[j])) & (across < 0.0f) & (distance > 0.0f);
    const Patches here = load(&chances.of[j]) * distance * distance * load(&inverse_area_[j]) / -across;
    sums.add(j, select(inside, here, Patches(0.0f)));
  }
  return sums.total();
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
