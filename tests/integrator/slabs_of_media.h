// Slabs of glass and of absorbing media.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/test_scenes.h"

#include <vector>

namespace kindling::test {

// Clear glass around a medium.
inline Material glass(float ior) {
  Material material;
  material.metallic_factor = 0.0f;
  material.roughness_factor = 0.0f;
  material.ior = ior;
  material.transmission_factor = 1.0f;
  material.thickness_factor = 1.0f;
  return material;
}

inline Material absorbing(float ior, const Rgb& color, float distance_m) {
  Material material = glass(ior);
  material.attenuation_color = color;
  material.attenuation_distance_m = distance_m;
  return material;
}

// A box from (-4, -4, z0) to (4, 4, z1) with outward front faces.
inline std::vector<Primitive> slab(float z0, float z1, int material) {
  const V3f a(-4, -4, z0), x(8, 0, 0), y(0, 8, 0), z(0, 0, z1 - z0);
  return {quad(a + z, x, y, material),      quad(a + x, -x, y, material),     quad(a, z, y, material),
          quad(a + x + z, -z, y, material), quad(a + y + z, x, -z, material), quad(a, x, z, material)};
}

} // namespace kindling::test
