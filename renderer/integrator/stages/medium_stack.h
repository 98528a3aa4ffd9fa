// Stack of the media that contain a path's current position, in the order of entry.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <optional>

namespace kindling {

// The medium entered last is the effective one, and media may be left in any order. So where a
// liquid slightly overlaps its glass, a path meets a single interface between glass and liquid,
// without air in between: it crosses that interface on entering the liquid, and leaving the covered
// glass is ignored; on the way back likewise. The same holds for media wholly inside others, denser
// or thinner: ice in water, bubbles in glass. (Schmidt and Budge 2002, "Simple Nested Dielectrics
// in Ray Traced Images", rank media by priorities, which glTF does not have; ranked by index of
// refraction, ice would vanish in water.)
class MediumStack {
 public:
  static constexpr size_t kMax = 7; // beyond it, the outermost medium is forgotten

  void clear() { count_ = 0; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  void enter(uint32_t material) {
    assert(count_ <= kMax);
    if (count_ == kMax) {
      std::copy(materials_.begin() + 1, materials_.end(), materials_.begin());
      --count_;
    }
    materials_[count_++] = material;
  }
  // Removes the last entry of the material, if any: open meshes and cameras inside media lead to
  // exits without an entry.
  void leave(uint32_t material) {
    for (size_t i = count_; i-- > 0;) {
      if (materials_[i] != material) continue;
      std::copy(materials_.begin() + static_cast<ptrdiff_t>(i) + 1, materials_.begin() + count_,
                materials_.begin() + static_cast<ptrdiff_t>(i));
      --count_;
      return;
    }
  }
  // Returns the material of the effective medium, or nothing for vacuum.
  [[nodiscard]] std::optional<uint32_t> innermost() const {
    return count_ == 0 ? std::nullopt : std::optional(materials_[count_ - 1]);
  }
  // Returns the effective medium after `material` has been left.
  [[nodiscard]] std::optional<uint32_t> innermost_without(uint32_t material) const {
    MediumStack rest = *this;
    rest.leave(material);
    return rest.innermost();
  }
  // True if another medium was entered after this one, so that its surface is ignored.
  [[nodiscard]] bool covered(uint32_t material) const {
    return innermost() != material &&
           std::find(materials_.begin(), materials_.begin() + count_, material) != materials_.begin() + count_;
  }

 private:
  std::array<uint32_t, kMax> materials_{};
  uint32_t count_ = 0;
};

} // namespace kindling
