// A triangle on the texels of its texture, and the texels under its micro-triangles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/opacity/alpha_classes.h"
#include "renderer/world/shading_material.h"

#include <array>
#include <cstdint>

namespace kindling {

// One of the squares of u and v, and which half of it.
struct MicroTriangle {
  uint32_t column = 0; // along u
  uint32_t row = 0;    // along v
  bool upper = false;  // the half that is turned over
};

class TexelTriangle {
 public:
  // `texcoords` are u and v of three corners, before the binding's transform.
  TexelTriangle(const std::array<float, 6>& texcoords, const TextureBinding& binding, const V2i& size_px);

  // Returns the level, at most `max_level`, whose micro-triangles have about this area in texels.
  [[nodiscard]] int level(double texels, int max_level) const;

  // Returns what look-ups anywhere in a micro-triangle find, wherever rounding puts them.
  [[nodiscard]] Opacity opacity(const AlphaClasses& classes, int level, const MicroTriangle& micro) const;

 private:
  // In texels: number i has its center at i. `origin_` is the first corner, the others are edges.
  struct Point {
    double x = 0.0, y = 0.0;
  };
  Point origin_, along_u_, along_v_;
  Point margin_;             // bounds the distance of a look-up from its exact place
  bool is_readable_ = false; // coordinates are finite and not too large
};

} // namespace kindling
