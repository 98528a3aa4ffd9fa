// The media that a path is in, in the order in which it entered them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace kindling {

// The one entered last is the one that counts, and a medium may be left in any order. So where a liquid overlaps its
// glass a little, a path meets one surface between glass and liquid, not two and no air: entering the liquid is that surface, and
// leaving the glass, which is covered, is none; on the way back likewise. It also holds for what is wholly inside, denser
// or thinner: ice in water, bubbles in glass. (Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced Images", rank
// media by priorities instead, which glTF has none of; by index of refraction, ice would vanish in water.)
class MediumStack {
 public:
  static constexpr size_t kMax = 7; // entered beyond it: the outermost is forgotten

  void clear() { count_ = 0; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  void enter(uint32_t material) {
    if (count_ == kMax) {
      std::copy(materials_.begin() + 1, materials_.end(), materials_.begin());
      --count_;
    }
    materials_[count_++] = material;
  }
  // Of several entries of a material the last; nothing where there is none (an open mesh, or the camera was inside).
  void leave(uint32_t material) {
    for (size_t i = count_; i-- > 0;) {
      if (materials_[i] != material) continue;
      std::copy(materials_.begin() + static_cast<ptrdiff_t>(i) + 1, materials_.begin() + count_,
                materials_.begin() + static_cast<ptrdiff_t>(i));
      --count_;
      return;
    }
  }
  // Empty: vacuum.
  [[nodiscard]] std::optional<uint32_t> innermost() const {
    return count_ == 0 ? std::nullopt : std::optional(materials_[count_ - 1]);
  }
  // What is there once `material` has been left.
  [[nodiscard]] std::optional<uint32_t> innermost_without(uint32_t material) const {
    MediumStack rest = *this;
    rest.leave(material);
    return rest.innermost();
  }
  // It is inside another one that was entered later: its surface is not seen.
  [[nodiscard]] bool covered(uint32_t material) const {
    return innermost() != material &&
           std::find(materials_.begin(), materials_.begin() + count_, material) != materials_.begin() + count_;
  }

 private:
  std::array<uint32_t, kMax> materials_{};
  uint32_t count_ = 0;
};

} // namespace kindling
