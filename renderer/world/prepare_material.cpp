// Binds textures and folds constants of a material.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/prepare_material.h"

#include "renderer/scene/material_slots.h"

namespace kindling {
namespace {

// Binds the texture slots of one material.
class Binder {
 public:
  explicit Binder(TextureTable& textures) : textures_(textures) {}
  TextureBinding operator()(const TextureSlot& slot, TextureContent content) {
    if (slot.procedural != kNone)
      return make_binding(slot, textures_.number_of_procedural(slot.procedural, slot.procedural_output));
    return make_binding(slot, slot.texture != kNone ? textures_.number_of(slot.texture, content) : kNone);
  }

 private:
  TextureTable& textures_;
};

LayerMaterial prepare_layers(const Material& material, Binder& bind) {
  LayerMaterial layers = make_layer_material(material);
  layers.clearcoat = bind(material.clearcoat_texture, TextureContent::data);
  layers.clearcoat_roughness = bind(material.clearcoat_roughness_texture, TextureContent::data);
  layers.clearcoat_normal = bind(material.clearcoat_normal_texture, TextureContent::tangent_normal);
  layers.sheen_color = bind(material.sheen_color_texture, TextureContent::color);
  layers.sheen_roughness = bind(material.sheen_roughness_texture, TextureContent::data);
  layers.anisotropy = bind(material.anisotropy_texture, TextureContent::data);
  layers.iridescence = bind(material.iridescence_texture, TextureContent::data);
  layers.iridescence_thickness = bind(material.iridescence_thickness_texture, TextureContent::data);
  layers.transmission = bind(material.transmission_texture, TextureContent::data);
  layers.diffuse_transmission = bind(material.diffuse_transmission_texture, TextureContent::data);
  layers.diffuse_transmission_color = bind(material.diffuse_transmission_color_texture, TextureContent::color);
  return layers;
}

} // namespace

PreparedMaterial prepare_material(const Material& material, TextureTable& textures) {
  Binder bind(textures);
  PreparedMaterial prepared;
  ShadingMaterial& shading = prepared.shading;
  shading.base_color_factor = material.base_color_factor;
  shading.metallic_factor = material.metallic_factor;
  shading.roughness_factor = material.roughness_factor;
  shading.normal_scale = material.normal_scale;
  shading.emission_factor = material.emissive_factor * material.emissive_strength;
  shading.emissive = !is_black(shading.emission_factor) && !material.unlit;
  shading.ior = material.ior;
  shading.specular_factor = material.specular_factor;
  shading.specular_color_factor = material.specular_color_factor;
  shading.alpha_cutoff = material.alpha_cutoff;
  shading.alpha_mode = material.alpha_mode;
  shading.double_sided = material.double_sided;
  shading.unlit = material.unlit;
  const TextureContent base_color_content =
      material.alpha_mode == AlphaMode::opaque ? TextureContent::color : TextureContent::cutout_color;
  shading.base_color = bind(material.base_color_texture, base_color_content);
  shading.metallic_roughness = bind(material.metallic_roughness_texture, TextureContent::data);
  shading.normal = bind(material.normal_texture, TextureContent::tangent_normal);
  shading.emission = bind(material.emissive_texture, TextureContent::color);
  shading.specular = bind(material.specular_texture, TextureContent::data);
  shading.specular_color = bind(material.specular_color_texture, TextureContent::color);
  for (const TextureSlot* slot : texture_slots(material)) shading.textured |= slot->present();
  if (material.specular_glossiness) {
    shading.specular_glossiness = true;
    shading.ior = 0.0f; // the color is F0 itself
    shading.roughness_factor = 1.0f - material.glossiness_factor;
  }
  if (has_layers(material) && !material.unlit) {
    prepared.layers = prepare_layers(material, bind);
    shading.thin_wall = prepared.layers->thin_wall();
  }
  shading.constant = !shading.textured && !shading.unlit && !shading.emissive && !prepared.layers &&
                     !shading.specular_glossiness && shading.alpha_mode != AlphaMode::blend;
  if (shading.constant) {
    const auto clamped = [](float x) { return std::clamp(x, 0.0f, 1.0f); };
    const V4f& color = shading.base_color_factor;
    shading.constant_bsdf = {.base_color = Rgb(clamped(color.x), clamped(color.y), clamped(color.z)),
                             .metallic = shading.metallic_factor,
                             .roughness = shading.roughness_factor,
                             .ior = shading.ior,
                             .specular = shading.specular_factor,
                             .specular_color = shading.specular_color_factor};
  }
  return prepared;
}

} // namespace kindling
