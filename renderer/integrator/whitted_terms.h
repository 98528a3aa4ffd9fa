// What local illumination repeats at every hit of a surface with the same parameters, and the cache that keeps it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/world.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace kindling {

// A function of a surface's BSDF parameters (and layers) and of the ambient light alone.
struct WhittedTerms {
  Rgb ambient{0.0f};   // ambient light times the material's ambient color: radiance towards anybody
  Rgb mirror_f0{0.0f}; // of the plain model's reflection that rays follow, its share included; black: rays follow none
  Rgb mirror_slope{0.0f};         // F = mirror_f0 + mirror_slope (1 - cos)^5
  float mirror_share = 0.0f;      // of the base's glossy reflection, followed by rays, in [0, 1]
  float coat_mirror_share = 0.0f; // the same for a coat
  float glass_share = 0.0f;       // and for transmission and reflection of glass
  bool smooth = false;            // the base: mirrored in one direction
  bool coat_smooth = false;
  bool traced = false; // any share is above 0
};

// Ambient color: the mean albedo of what no ray follows. Shares fall from 1 at a roughness of 0.3 to 0 at 0.6; glass has 1.
[[nodiscard]] WhittedTerms whitted_terms(const SurfacePoint& surface, const Rgb& ambient);

// Terms by material, of those whose parameters are the same everywhere (World::is_uniform()). Filled while rendering, by whoever
// comes first; as a value depends on its key alone, it does not matter who that is. Thread-safe, without locks: a slot that is just
// being written counts as empty.
class WhittedCache {
 public:
  explicit WhittedCache(size_t material_count) : count_(material_count), slots_(new Slot[material_count]) {}

  // Null: not there yet.
  [[nodiscard]] const WhittedTerms* find(uint32_t material) const {
    const Slot& slot = slots_[material];
    return slot.state.load(std::memory_order_acquire) == kFull ? &slot.terms : nullptr;
  }
  void keep(uint32_t material, const WhittedTerms& terms) {
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
