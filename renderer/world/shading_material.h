// A material prepared for lookups: bound textures, folded transforms, constant parts separated.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/scene/scene.h"

#include <cstdint>

namespace kindling {

// uv' = (m[0] u + m[1] v + m[2], m[3] u + m[4] v + m[5]).
struct TextureBinding {
  int32_t texture = kNone; // index into World's textures; below kNone: a procedural one
  uint8_t texcoord = 0;
  bool transformed = false;
  float m[6] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
  float area_scale = 1.0f; // scale of areas: the absolute determinant

  [[nodiscard]] bool present() const { return texture != kNone; }
  [[nodiscard]] bool is_procedural() const { return texture < kNone; }
  [[nodiscard]] int procedural() const { return kNone - 1 - texture; } // index into World's procedural textures
  [[nodiscard]] V2f apply(const V2f& uv) const {
    if (!transformed) return uv;
    return {m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]};
  }
};

struct ShadingMaterial {
  V4f base_color_factor{1.0f};
  float metallic_factor = 1.0f;
  float roughness_factor = 1.0f;
  float normal_scale = 1.0f;
  Rgb emission_factor{0.0f}; // includes the strength
  float ior = 1.5f;
  float specular_factor = 1.0f;
  Rgb specular_color_factor{1.0f};
  float alpha_cutoff = 0.5f;
  AlphaMode alpha_mode = AlphaMode::opaque;
  bool double_sided = false;
  bool unlit = false;
  bool emissive = false;
  bool specular_glossiness = false; // roughness is 1 - (1 - roughness_factor) * A of specular_color
  int32_t layers = kNone;           // index into World's layer materials
  bool thin_wall = false;           // thin-walled and transmissive: LayerMaterial::thin_wall()
  bool textured = false;            // some binding is present
  // The material is a BSDF without textures, equal everywhere unless there are vertex colors:
  // constant_bsdf.
  bool constant = false;
  BsdfParameters constant_bsdf;

  TextureBinding base_color;
  TextureBinding metallic_roughness;
  TextureBinding normal;
  TextureBinding emission;
  TextureBinding specular;
  TextureBinding specular_color;
};

// Returns the binding with the folded KHR_texture_transform: translation * rotation * scale (its
// README, "Overview").
[[nodiscard]] TextureBinding make_binding(const TextureSlot& slot, int32_t texture);

} // namespace kindling
