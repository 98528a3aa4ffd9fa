// The guides of eight surfaces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/integrator/stages/guide_mixture.h"
#include "renderer/integrator/stages/path_stages.h"

#include <array>
#include <bit>
#include <cstdint>
#include <new>

namespace kindling {

// One mixture for each lane. It is valid where guide() has set it, and else not initialized.
class GuideLanes {
 public:
  GuideLanes() { clear(); }

  // Leaves all surfaces to their BSDFs.
  void clear() { guided_ = 0; }
  // Mixes the guides into the BSDF of one surface.
  void guide(uint32_t lane, const PathStages& stages, const V3f& position, const V3f& shading_normal,
             const GuidableLobes& lobes) {
    new (&mixtures_[lane]) GuideMixture; // not cleared
    stages.guide(mixtures_[lane], position, shading_normal, lobes);
    if (mixtures_[lane].is_guided()) guided_ |= 1U << lane;
  }

  [[nodiscard]] const GuideMixture& operator[](uint32_t lane) const { return mixtures_[lane]; }
  [[nodiscard]] uint32_t guided() const { return guided_; } // a bit for each lane that is
  // Returns the densities of the BSDFs as guides mix them, in those of `lanes` that are guided; 0
  // stays. `cosine`: of GuideMixture::mixed().
  [[nodiscard]] Lanes mixed(const Lanes& pdf, const Lanes& cosine, const Imath::Vec3<Lanes>& wi, uint32_t lanes) const {
    lanes &= guided_;
    if (lanes == 0) return pdf;
    LaneNumbers result, cosines;
    LaneVectors directions;
    result.store(pdf), cosines.store(cosine), directions.store(wi);
    for (uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
      if (result[lane] > 0.0f) result[lane] = mixtures_[lane].mixed(result[lane], cosines[lane], directions[lane]);
    }
    return result.load();
  }

 private:
  uint32_t guided_;
  union {
    std::array<GuideMixture, Lanes::kCount> mixtures_;
  };
};

} // namespace kindling
