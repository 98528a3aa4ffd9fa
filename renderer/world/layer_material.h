// The layers of a shading material, and the medium inside of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/shading_material.h"

namespace kindling {

// Factors and bindings as in Material (scene.h); constant over the surface except for textures.
struct LayerMaterial {
  float clearcoat_factor = 0.0f;
  float clearcoat_roughness_factor = 0.0f;
  float clearcoat_normal_scale = 1.0f;
  Rgb sheen_color_factor{0.0f};
  float sheen_roughness_factor = 0.0f;
  float anisotropy_strength = 0.0f;
  float anisotropy_cos = 1.0f; // of the rotation
  float anisotropy_sin = 0.0f;
  float iridescence_factor = 0.0f;
  float iridescence_ior = 1.3f;
  float iridescence_minimum_nm = 100.0f;
  float iridescence_maximum_nm = 400.0f;
  float transmission_factor = 0.0f;
  float diffuse_transmission_factor = 0.0f;
  Rgb diffuse_transmission_color_factor{1.0f};
  bool volume = false; // the mesh bounds a medium; else it is thin-walled

  TextureBinding clearcoat;
  TextureBinding clearcoat_roughness;
  TextureBinding clearcoat_normal;
  TextureBinding sheen_color;
  TextureBinding sheen_roughness;
  TextureBinding anisotropy;
  TextureBinding iridescence;
  TextureBinding iridescence_thickness;
  TextureBinding transmission;
  TextureBinding diffuse_transmission;
  TextureBinding diffuse_transmission_color;

  // True if light may pass in a straight line where the surface is smooth enough.
  [[nodiscard]] bool thin_wall() const { return transmission_factor > 0.0f && !volume; }
};

// A homogeneous medium inside of a closed mesh (KHR_materials_volume). Coefficients are per meter
// of world space.
struct Medium {
  float ior = 1.5f;
  float dispersion = 0.0f; // 20 / Abbe number
  Rgb extinction{0.0f};    // absorption and scattering
  Rgb scattering{0.0f};
  float scatter_anisotropy = 0.0f; // g of Henyey and Greenstein
};

// True if the material needs more than the plain metallic-roughness model.
[[nodiscard]] bool has_layers(const Material& material);

// Returns everything except the bindings.
[[nodiscard]] LayerMaterial make_layer_material(const Material& material);

// Returns the medium of a material. Extinction = -ln(attenuation color) / attenuation distance
// (KHR_materials_volume, "Attenuation"). Scattering gives a half space of the medium the
// multiscatter color c: single-scattering albedo (1 - s^2) / (1 - g s^2) with s = 4.09712 + 4.20863
// c - sqrt(9.59217 + 41.6808 c + 17.7126 c^2) (Kulla and Conty 2017, "Revisiting Physically Based
// Shading at Imageworks"; KHR_materials_volume_scatter).
[[nodiscard]] Medium make_medium(const Material& material);

} // namespace kindling
