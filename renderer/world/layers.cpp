// Evaluates the layer parameters of a surface at a hit, which plain materials skip.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/normal_map.h"
#include "renderer/world/shading_normal.h"
#include "renderer/world/texture_lookup.h"
#include "renderer/world/world_view.h"

namespace kindling {

void WorldView::layers_at(const TextureLookup& texels, const VertexFrame& vertex, const V3f& wo,
                          SurfacePoint& surface) const {
  const ShadingMaterial& shading = materials[surface.material];
  const LayerMaterial& material = layer_materials[static_cast<size_t>(shading.layers)];
  SurfaceLayers& layers = surface.layers;
  const auto rgb = [&](const TextureBinding& binding) {
    return binding.present() ? texels.sample_rgb(binding) : Rgb(1.0f);
  };
  const auto channel = [&](const TextureBinding& binding, int index) {
    return binding.present() ? texels.sample_channel(binding, index) : 1.0f;
  };

  // Inside of a medium coat and sheen are skipped, since they are beyond the interface. A film is
  // part of it: light leaves through what it came in by.
  layers.boundary = material.volume;
  layers.entering = vertex.front;
  const bool inside = material.volume && !vertex.front;

  layers.bsdf.clearcoat = inside ? 0.0f : material.clearcoat_factor * channel(material.clearcoat, 0);
  if (layers.bsdf.clearcoat > 0.0f) {
    layers.bsdf.clearcoat_roughness = material.clearcoat_roughness_factor * channel(material.clearcoat_roughness, 1);
    V3f normal = vertex.normal;
    if (material.clearcoat_normal.present() && vertex.has_tangent) {
      const V3f mapped = normal_from_map(rgb(material.clearcoat_normal), material.clearcoat_normal_scale,
                                         vertex.tangent, vertex.bitangent, normal);
      const float length = mapped.length();
      if (length > 0.0f && std::isfinite(length)) normal = mapped / length;
    }
    layers.clearcoat_normal = with_valid_reflection(vertex.front ? normal : -normal, surface.geometric_normal, wo);
  }

  layers.bsdf.sheen_color = inside ? Rgb(0.0f) : material.sheen_color_factor * rgb(material.sheen_color);
  layers.bsdf.sheen_roughness = material.sheen_roughness_factor * channel(material.sheen_roughness, 3);

  layers.bsdf.iridescence = material.iridescence_factor * channel(material.iridescence, 0);
  layers.bsdf.iridescence_ior = material.iridescence_ior;
  layers.bsdf.iridescence_thickness_nm = lerp(material.iridescence_minimum_nm, material.iridescence_maximum_nm,
                                              channel(material.iridescence_thickness, 1));

  // The texture rotates the direction before the rotation factor does (KHR_materials_anisotropy,
  // "Implementation").
  layers.bsdf.anisotropy = 0.0f;
  layers.tangent = V3f(0.0f);
  if (material.anisotropy_strength > 0.0f && vertex.has_tangent) {
    V2f direction(1.0f, 0.0f);
    float strength = material.anisotropy_strength;
    if (material.anisotropy.present()) {
      const Rgb texel = rgb(material.anisotropy);
      direction = V2f(texel.x * 2.0f - 1.0f, texel.y * 2.0f - 1.0f);
      strength *= texel.z;
    }
    const V2f turned(material.anisotropy_cos * direction.x - material.anisotropy_sin * direction.y,
                     material.anisotropy_sin * direction.x + material.anisotropy_cos * direction.y);
    const V3f tangent = vertex.tangent * turned.x + vertex.bitangent * turned.y;
    if (tangent.length2() > 0.0f) {
      layers.bsdf.anisotropy = strength;
      layers.tangent = tangent;
    }
  }

  layers.bsdf.transmission = material.transmission_factor * channel(material.transmission, 0);
  layers.bsdf.thin_walled = !material.volume;
  layers.bsdf.diffuse_transmission = material.diffuse_transmission_factor * channel(material.diffuse_transmission, 3);
  layers.bsdf.diffuse_transmission_color =
      material.diffuse_transmission_color_factor * rgb(material.diffuse_transmission_color);
  layers.thin_wall = false;
  if (material.thin_wall()) { // at the finest level, like shadow rays
    float roughness = shading.roughness_factor;
    if (shading.metallic_roughness.present()) roughness *= texels.sample_channel_finest(shading.metallic_roughness, 1);
    layers.thin_wall = roughness <= kStraightRoughness;
    if (layers.thin_wall) surface.bsdf.roughness = std::min(surface.bsdf.roughness, kStraightRoughness);
  }
  layers.transmits = layers.bsdf.diffuse_transmission > 0.0f ||
                     (layers.bsdf.transmission > 0.0f && surface.bsdf.roughness > kStraightRoughness);
}

} // namespace kindling
