// Tests of animated members: every property of the object model, ranges and order.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/animated_members.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>

namespace kindling {
namespace {

constexpr const char* kExtension = "/materials/0/extensions/KHR_materials_";

// Returns a scene that has every animatable object.
Scene full_scene() {
  Scene scene;
  Material& m = scene.materials.emplace_back();
  for (TextureSlot* slot :
       {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emissive_texture,
        &m.specular_texture, &m.specular_color_texture, &m.clearcoat_texture, &m.clearcoat_roughness_texture,
        &m.clearcoat_normal_texture, &m.sheen_color_texture, &m.sheen_roughness_texture, &m.anisotropy_texture,
        &m.iridescence_texture, &m.iridescence_thickness_texture, &m.transmission_texture,
        &m.diffuse_transmission_texture, &m.diffuse_transmission_color_texture, &m.thickness_texture})
    slot->texture = 0;
  scene.cameras.push_back({.kind = SceneCamera::Kind::perspective, .aspect_ratio = 1.0f, .zfar = 100.0f});
  scene.cameras.push_back({.kind = SceneCamera::Kind::orthographic, .zfar = 100.0f});
  scene.lights.push_back({.kind = PunctualLight::Kind::spot, .range_m = 1.0f});
  scene.lights.push_back({.kind = PunctualLight::Kind::point});
  scene.meshes.push_back({.weights = {0.0f, 0.0f, 0.0f}});
  return scene;
}

AnimationChannel constant(const AnimatedMember& member, const std::vector<float>& value) {
  AnimationChannel channel;
  channel.property = AnimatedProperty::member;
  channel.member = member;
  channel.times_s = {0.0f};
  channel.values = value;
  channel.components = static_cast<int>(value.size());
  return channel;
}

// Returns the scene with each property animated to the values given.
Scene animated(Scene scene, const std::vector<std::pair<std::string, std::vector<float>>>& properties) {
  scene.animations.emplace_back();
  for (const auto& [pointer, value] : properties) {
    const auto member = find_animated_member(scene, pointer);
    EXPECT_TRUE(member) << pointer;
    if (member) scene.animations[0].channels.push_back(constant(*member, value));
  }
  animate_members(scene, 0.0);
  return scene;
}

using Read = std::function<const float*(const Scene&)>;

TEST(AnimatedMembers, EachPointerResolvesToItsProperty) {
  const std::string x = kExtension;
#define OF_MATERIAL(member) [](const Scene& s) { return reinterpret_cast<const float*>(&s.materials[0].member); }
  const std::map<std::string, std::pair<int, Read>> names = {
      {"/materials/0/alphaCutoff", {1, OF_MATERIAL(alpha_cutoff)}},
      {"/materials/0/emissiveFactor", {3, OF_MATERIAL(emissive_factor)}},
      {"/materials/0/normalTexture/scale", {1, OF_MATERIAL(normal_scale)}},
      {"/materials/0/pbrMetallicRoughness/baseColorFactor", {4, OF_MATERIAL(base_color_factor)}},
      {"/materials/0/pbrMetallicRoughness/metallicFactor", {1, OF_MATERIAL(metallic_factor)}},
      {"/materials/0/pbrMetallicRoughness/roughnessFactor", {1, OF_MATERIAL(roughness_factor)}},
      {x + "anisotropy/anisotropyStrength", {1, OF_MATERIAL(anisotropy_strength)}},
      {x + "anisotropy/anisotropyRotation", {1, OF_MATERIAL(anisotropy_rotation_rad)}},
      {x + "clearcoat/clearcoatFactor", {1, OF_MATERIAL(clearcoat_factor)}},
      {x + "clearcoat/clearcoatRoughnessFactor", {1, OF_MATERIAL(clearcoat_roughness_factor)}},
      {x + "clearcoat/clearcoatNormalTexture/scale", {1, OF_MATERIAL(clearcoat_normal_scale)}},
      {x + "diffuse_transmission/diffuseTransmissionFactor", {1, OF_MATERIAL(diffuse_transmission_factor)}},
      {x + "diffuse_transmission/diffuseTransmissionColorFactor", {3, OF_MATERIAL(diffuse_transmission_color_factor)}},
      {x + "dispersion/dispersion", {1, OF_MATERIAL(dispersion)}},
      {x + "emissive_strength/emissiveStrength", {1, OF_MATERIAL(emissive_strength)}},
      {x + "iridescence/iridescenceFactor", {1, OF_MATERIAL(iridescence_factor)}},
      {x + "iridescence/iridescenceThicknessMinimum", {1, OF_MATERIAL(iridescence_thickness_minimum_nm)}},
      {x + "iridescence/iridescenceThicknessMaximum", {1, OF_MATERIAL(iridescence_thickness_maximum_nm)}},
      {x + "sheen/sheenColorFactor", {3, OF_MATERIAL(sheen_color_factor)}},
      {x + "sheen/sheenRoughnessFactor", {1, OF_MATERIAL(sheen_roughness_factor)}},
      {x + "specular/specularFactor", {1, OF_MATERIAL(specular_factor)}},
      {x + "specular/specularColorFactor", {3, OF_MATERIAL(specular_color_factor)}},
      {x + "transmission/transmissionFactor", {1, OF_MATERIAL(transmission_factor)}},
      {x + "volume/thicknessFactor", {1, OF_MATERIAL(thickness_factor)}},
      {x + "volume/attenuationDistance", {1, OF_MATERIAL(attenuation_distance_m)}},
      {x + "volume/attenuationColor", {3, OF_MATERIAL(attenuation_color)}},
      {x + "volume_scatter/multiscatterColor", {3, OF_MATERIAL(multiscatter_color)}},
      {x + "volume_scatter/scatterAnisotropy", {1, OF_MATERIAL(scatter_anisotropy)}},
      {"/cameras/0/perspective/yfov", {1, [](const Scene& s) { return &s.cameras[0].yfov_rad; }}},
      {"/cameras/0/perspective/aspectRatio", {1, [](const Scene& s) { return &*s.cameras[0].aspect_ratio; }}},
      {"/cameras/0/perspective/znear", {1, [](const Scene& s) { return &s.cameras[0].znear; }}},
      {"/cameras/1/orthographic/xmag", {1, [](const Scene& s) { return &s.cameras[1].xmag; }}},
      {"/cameras/1/orthographic/ymag", {1, [](const Scene& s) { return &s.cameras[1].ymag; }}},
      {"/extensions/KHR_lights_punctual/lights/1/color", {3, [](const Scene& s) { return &s.lights[1].color.x; }}},
      {"/extensions/KHR_lights_punctual/lights/1/intensity",
       {1, [](const Scene& s) { return &s.lights[1].intensity; }}},
      {"/extensions/KHR_lights_punctual/lights/0/range", {1, [](const Scene& s) { return &*s.lights[0].range_m; }}},
      {"/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle",
       {1, [](const Scene& s) { return &s.lights[0].inner_cone_rad; }}},
      {"/meshes/0/weights", {3, [](const Scene& s) { return s.meshes[0].weights.data(); }}},
      {"/meshes/0/weights/2", {1, [](const Scene& s) { return &s.meshes[0].weights[2]; }}},
  };
#undef OF_MATERIAL
  const std::vector<float> values = {0.25f, 0.375f, 0.4375f, 0.46875f};
  for (const auto& [pointer, what] : names) {
    const auto& [components, read] = what;
    const Scene scene = animated(full_scene(), {{pointer, {values.begin(), values.begin() + components}}});
    for (int c = 0; c < components; ++c) EXPECT_EQ(read(scene)[c], values[static_cast<size_t>(c)]) << pointer;
  }
}

TEST(AnimatedMembers, AnimatesTransformsOfAllTextureSlots) {
  const std::string x = std::string(kExtension);
  const std::map<std::string, TextureSlot Material::*> slots = {
      {"/materials/0/normalTexture", &Material::normal_texture},
      {"/materials/0/emissiveTexture", &Material::emissive_texture},
      {"/materials/0/pbrMetallicRoughness/baseColorTexture", &Material::base_color_texture},
      {"/materials/0/pbrMetallicRoughness/metallicRoughnessTexture", &Material::metallic_roughness_texture},
      {x + "anisotropy/anisotropyTexture", &Material::anisotropy_texture},
      {x + "clearcoat/clearcoatTexture", &Material::clearcoat_texture},
      {x + "clearcoat/clearcoatRoughnessTexture", &Material::clearcoat_roughness_texture},
      {x + "clearcoat/clearcoatNormalTexture", &Material::clearcoat_normal_texture},
      {x + "diffuse_transmission/diffuseTransmissionTexture", &Material::diffuse_transmission_texture},
      {x + "diffuse_transmission/diffuseTransmissionColorTexture", &Material::diffuse_transmission_color_texture},
      {x + "iridescence/iridescenceTexture", &Material::iridescence_texture},
      {x + "iridescence/iridescenceThicknessTexture", &Material::iridescence_thickness_texture},
      {x + "sheen/sheenColorTexture", &Material::sheen_color_texture},
      {x + "sheen/sheenRoughnessTexture", &Material::sheen_roughness_texture},
      {x + "specular/specularTexture", &Material::specular_texture},
      {x + "specular/specularColorTexture", &Material::specular_color_texture},
      {x + "transmission/transmissionTexture", &Material::transmission_texture},
      {x + "volume/thicknessTexture", &Material::thickness_texture},
  };
  for (const auto& [path, member] : slots) {
    const std::string at = path + "/extensions/KHR_texture_transform";
    const Scene scene =
        animated(full_scene(), {{at + "/offset", {2, -3}}, {at + "/rotation", {4}}, {at + "/scale", {-5, 6}}});
    const TextureSlot& slot = scene.materials[0].*member;
    EXPECT_EQ(slot.offset, V2f(2, -3)) << path;
    EXPECT_EQ(slot.rotation_rad, 4.0f) << path;
    EXPECT_EQ(slot.scale, V2f(-5, 6)) << path;
    Scene without = full_scene();
    (without.materials[0].*member).texture = kNone;
    EXPECT_FALSE(find_animated_member(without, at + "/offset")) << path;
  }
}

TEST(AnimatedMembers, ResolvesSpecularGlossinessPointers) {
  const std::string diffuse = std::string(kExtension) + "pbrSpecularGlossiness/diffuseFactor";
  Scene scene = full_scene();
  EXPECT_FALSE(find_animated_member(scene, diffuse));
  scene.materials[0].specular_glossiness = true;
  EXPECT_TRUE(find_animated_member(scene, diffuse));
  EXPECT_FALSE(find_animated_member(scene, "/materials/0/pbrMetallicRoughness/baseColorFactor"));
}

TEST(AnimatedMembers, ClampsValuesToRange) {
  const std::string ior = std::string(kExtension) + "ior/ior";
  EXPECT_EQ(animated(full_scene(), {{ior, {0.5f}}}).materials[0].ior, 1.0f);
  EXPECT_EQ(animated(full_scene(), {{ior, {0.0f}}}).materials[0].ior, 0.0f);
  const Scene scene = animated(full_scene(), {{"/materials/0/pbrMetallicRoughness/roughnessFactor", {1.5f}},
                                              {"/materials/0/pbrMetallicRoughness/metallicFactor", {-0.5f}},
                                              {"/cameras/0/perspective/yfov", {7.0f}},
                                              {"/cameras/0/perspective/zfar", {-1.0f}},
                                              {"/cameras/1/orthographic/xmag", {0.0f}}});
  EXPECT_EQ(scene.materials[0].roughness_factor, 1.0f);
  EXPECT_EQ(scene.materials[0].metallic_factor, 0.0f);
  EXPECT_LT(scene.cameras[0].yfov_rad, kPi);
  EXPECT_GT(scene.cameras[0].zfar, scene.cameras[0].znear);
  EXPECT_GT(scene.cameras[1].xmag, 0.0f);
}

// Both cones change at once; the inner one moves beyond the old outer one.
TEST(AnimatedMembers, KeepsConesOrderedAfterAllChannels) {
  const std::string spot = "/extensions/KHR_lights_punctual/lights/0/spot/";
  const Scene wide = animated(full_scene(), {{spot + "innerConeAngle", {1.0f}}, {spot + "outerConeAngle", {1.25f}}});
  EXPECT_EQ(wide.lights[0].inner_cone_rad, 1.0f);
  EXPECT_EQ(wide.lights[0].outer_cone_rad, 1.25f);
  const Scene crossed = animated(full_scene(), {{spot + "innerConeAngle", {1.0f}}, {spot + "outerConeAngle", {0.5f}}});
  EXPECT_EQ(crossed.lights[0].outer_cone_rad, 0.5f);
  EXPECT_LT(crossed.lights[0].inner_cone_rad, 0.5f);
}

TEST(AnimatedMembers, LaterChannelsOverrideEarlierOnes) {
  const std::string pointer = "/materials/0/alphaCutoff";
  const Scene scene = animated(full_scene(), {{pointer, {0.25f}}, {pointer, {0.75f}}});
  EXPECT_EQ(scene.materials[0].alpha_cutoff, 0.75f);
  EXPECT_EQ(scene.materials[0].ior, Material().ior);
}

} // namespace
} // namespace kindling
