// A sphere of a scattering medium under a lamp.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/test_scenes.h"

namespace kindling::test {

inline Material wax(float roughness, const Rgb& color, float g = 0.0f) {
  Material material;
  material.metallic_factor = 0.0f;
  material.roughness_factor = roughness;
  material.ior = 1.4f;
  material.transmission_factor = 1.0f;
  material.thickness_factor = 2.0f;
  material.attenuation_color = Rgb(0.5f);
  material.attenuation_distance_m = 0.2f; // three mean free paths from the center to the boundary
  material.multiscatter_color = color;
  material.scatter_anisotropy = g;
  return material;
}

// A sphere with a radius of 1 m at the origin; 3 m above it, to the left, a square lamp of 1 m.
inline Scene wax_under_a_lamp(const Material& wax) {
  return make_scene({wax, emissive_material(Rgb(40.0f))},
                    {sphere(V3f(0.0f), 1.0f, 32, 0), quad(V3f(-2.5f, 3, 0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 1)});
}

// Sees the whole sphere.
inline Camera wax_camera(const V2i& size_px) { return beam_camera(V3f(0, 0, 5), V3f(0.0f), 2.2f, size_px); }

} // namespace kindling::test
