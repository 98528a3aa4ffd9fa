// Terms of local illumination that depend on a surface's parameters alone, and their cache.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/surface_point.h"

#include <array>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace kindling {

// The terms are a function of a surface's BSDF parameters (and layers) and of the ambient light
// alone.
struct WhittedTerms {
  Rgb ambient{0.0f};              // ambient light times the material's ambient color: radiance in every direction
  Rgb mirror_f0{0.0f};            // traced reflectance of the plain model at normal incidence, mirror_share included
  Rgb mirror_slope{0.0f};         // F = mirror_f0 + mirror_slope (1 - cos)^5
  float mirror_share = 0.0f;      // fraction of the base's glossy reflection that is traced, in [0, 1]
  float coat_mirror_share = 0.0f; // the same for a coat
  float glass_share = 0.0f;       // the same for reflection and transmission of glass
  bool smooth = false;            // the base reflects in a single direction
  bool coat_smooth = false;       // likewise the coat
  bool traced = false;            // any of the shares is above 0
};

// Computes the terms. The ambient color is the mean albedo of everything that is not traced. Shares
// fall from 1 at a roughness of 0.3 to 0 at 0.6; that of glass is 1.
[[nodiscard]] WhittedTerms whitted_terms(const SurfacePoint& surface, const Rgb& ambient);

// Terms by material, for materials whose parameters are the same everywhere
// (WorldView::is_uniform()). The first thread that needs a value stores it while rendering; values
// depend on their key alone, so it does not matter which thread that is. Thread-safe without locks:
// a slot that is being written counts as empty.
class WhittedCache {
 public:
  explicit WhittedCache(size_t material_count) : count_(material_count), slots_(new Slot[material_count]) {}

  // Returns the stored terms, or null if there are none yet.
  [[nodiscard]] const WhittedTerms* find(uint32_t material) const {
    assert(material < count_);
    const Slot& slot = slots_[material];
    return slot.state.load(std::memory_order_acquire) == kFull ? &slot.terms : nullptr;
  }
  void store(uint32_t material, const WhittedTerms& terms) {
    assert(material < count_);
    Slot& slot = slots_[material];
    uint32_t state = kEmpty;
    if (!slot.state.compare_exchange_strong(state, kBusy, std::memory_order_relaxed)) return;
    slot.terms = terms;
    slot.state.store(kFull, std::memory_order_release);
  }
  [[nodiscard]] size_t size() const { return count_; }

 private:
  enum State : uint32_t { kEmpty, kBusy, kFull };
  struct Slot {
    std::atomic<uint32_t> state{kEmpty};
    WhittedTerms terms;
  };
  size_t count_;
  std::unique_ptr<Slot[]> slots_;
};

} // namespace kindling
