// Converts the layer parameters and the medium of a material.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/layer_material.h"

#include "renderer/base/elementary.h"

namespace kindling {
namespace {

bool transmits(const Material& m) { return m.transmission_factor > 0.0f || m.diffuse_transmission_factor > 0.0f; }

// Returns the optical depth over the attenuation distance, clamped for opaque media where floats
// see no difference.
float optical_depth(float color) { return -elementary::log(std::clamp(color, 1e-7f, 1.0f)); }

float single_scattering_albedo(float color, float g) {
  if (!(color > 0.0f)) return 0.0f; // exactly 0: paths skip such media
  const float c = std::min(color, 1.0f);
  const float s = 4.09712f + 4.20863f * c - std::sqrt(9.59217f + 41.6808f * c + 17.7126f * c * c);
  return std::clamp((1.0f - s * s) / (1.0f - g * s * s), 0.0f, 1.0f);
}

} // namespace

bool has_layers(const Material& m) {
  return m.clearcoat_factor > 0.0f || !is_black(m.sheen_color_factor) || m.anisotropy_strength > 0.0f ||
         m.iridescence_factor > 0.0f || transmits(m);
}

LayerMaterial make_layer_material(const Material& m) {
  LayerMaterial layer;
  layer.clearcoat_factor = m.clearcoat_factor;
  layer.clearcoat_roughness_factor = m.clearcoat_roughness_factor;
  layer.clearcoat_normal_scale = m.clearcoat_normal_scale;
  layer.sheen_color_factor = m.sheen_color_factor;
  layer.sheen_roughness_factor = m.sheen_roughness_factor;
  layer.anisotropy_strength = m.anisotropy_strength;
  layer.anisotropy_cos = elementary::cos(m.anisotropy_rotation_rad);
  layer.anisotropy_sin = elementary::sin(m.anisotropy_rotation_rad);
  layer.iridescence_factor = m.iridescence_factor;
  layer.iridescence_ior = m.iridescence_ior;
  layer.iridescence_minimum_nm = m.iridescence_thickness_minimum_nm;
  layer.iridescence_maximum_nm = m.iridescence_thickness_maximum_nm;
  layer.transmission_factor = m.transmission_factor;
  layer.diffuse_transmission_factor = m.diffuse_transmission_factor;
  layer.diffuse_transmission_color_factor = m.diffuse_transmission_color_factor;
  layer.volume = m.thickness_factor > 0.0f && transmits(m);
  return layer;
}

Medium make_medium(const Material& m) {
  Medium medium;
  medium.ior = m.ior > 0.0f ? m.ior : 1.0f;
  medium.dispersion = medium.ior == 1.0f ? 0.0f : m.dispersion; // without refraction there is no dispersion
  medium.scatter_anisotropy = m.scatter_anisotropy;
  if (!(m.attenuation_distance_m > 0.0f) || !std::isfinite(m.attenuation_distance_m)) return medium;
  for (unsigned c = 0; c < 3; ++c) {
    medium.extinction[c] = optical_depth(m.attenuation_color[c]) / m.attenuation_distance_m;
    medium.scattering[c] =
        medium.extinction[c] * single_scattering_albedo(m.multiscatter_color[c], m.scatter_anisotropy);
  }
  return medium;
}

} // namespace kindling
