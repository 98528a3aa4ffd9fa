// Tables of animatable properties in the glTF object model: path, range and location of the values.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/animated_members.h"

#include "renderer/scene/animation.h"

#include <cfloat>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

namespace kindling {
namespace {

using Owner = AnimatedMember::Owner;

template <typename Object>
struct Row {
  std::string_view path; // relative to the object
  std::span<float> (*values)(Object&);
  float min = 0.0f; // of each component
  float max = FLT_MAX;
};

template <typename T>
std::span<float> floats_of(T& value) {
  return {reinterpret_cast<float*>(&value), sizeof(T) / sizeof(float)};
}
std::span<float> floats_of(std::optional<float>& value) { return value ? floats_of(*value) : std::span<float>(); }

template <auto Member, typename Object>
std::span<float> at(Object& object) {
  return floats_of(object.*Member);
}

// Empty unless the texture exists.
template <auto Slot, auto Member>
std::span<float> at_textured(Material& material) {
  return (material.*Slot).present() ? floats_of(material.*Member) : std::span<float>();
}

// In the archived specular-glossiness workflow, base_color_factor holds the diffuse factor instead.
template <auto Member>
std::span<float> at_metallic(Material& material) {
  return material.specular_glossiness ? std::span<float>() : floats_of(material.*Member);
}
template <auto Member>
std::span<float> at_glossy(Material& material) {
  return material.specular_glossiness ? floats_of(material.*Member) : std::span<float>();
}

template <SceneCamera::Kind kKind, auto Member>
std::span<float> at_lens(SceneCamera& camera) {
  return camera.kind == kKind ? floats_of(camera.*Member) : std::span<float>();
}

template <auto Member>
std::span<float> at_spot(PunctualLight& light) {
  return light.kind == PunctualLight::Kind::spot ? floats_of(light.*Member) : std::span<float>();
}

using M = Material;

constexpr Row<Material> kMaterialRows[] = {
    {"/alphaCutoff", at<&M::alpha_cutoff>},
    {"/emissiveFactor", at<&M::emissive_factor>},
    {"/normalTexture/scale", at_textured<&M::normal_texture, &M::normal_scale>, -FLT_MAX},
    {"/pbrMetallicRoughness/baseColorFactor", at_metallic<&M::base_color_factor>, 0.0f, 1.0f},
    {"/pbrMetallicRoughness/metallicFactor", at_metallic<&M::metallic_factor>, 0.0f, 1.0f},
    {"/pbrMetallicRoughness/roughnessFactor", at_metallic<&M::roughness_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_anisotropy/anisotropyStrength", at<&M::anisotropy_strength>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_anisotropy/anisotropyRotation", at<&M::anisotropy_rotation_rad>, -FLT_MAX},
    {"/extensions/KHR_materials_clearcoat/clearcoatFactor", at<&M::clearcoat_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", at<&M::clearcoat_roughness_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale",
     at_textured<&M::clearcoat_normal_texture, &M::clearcoat_normal_scale>, -FLT_MAX},
    {"/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", at<&M::diffuse_transmission_factor>,
     0.0f, 1.0f},
    {"/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
     at<&M::diffuse_transmission_color_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_dispersion/dispersion", at<&M::dispersion>},
    {"/extensions/KHR_materials_emissive_strength/emissiveStrength", at<&M::emissive_strength>},
    {"/extensions/KHR_materials_ior/ior", at<&M::ior>},
    {"/extensions/KHR_materials_iridescence/iridescenceFactor", at<&M::iridescence_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_iridescence/iridescenceIor", at<&M::iridescence_ior>, 1.0f},
    {"/extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", at<&M::iridescence_thickness_minimum_nm>},
    {"/extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", at<&M::iridescence_thickness_maximum_nm>},
    {"/extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", at_glossy<&M::base_color_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", at_glossy<&M::specular_color_factor>, 0.0f,
     1.0f},
    {"/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", at_glossy<&M::glossiness_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_sheen/sheenColorFactor", at<&M::sheen_color_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_sheen/sheenRoughnessFactor", at<&M::sheen_roughness_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_specular/specularFactor", at<&M::specular_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_specular/specularColorFactor", at_metallic<&M::specular_color_factor>},
    {"/extensions/KHR_materials_transmission/transmissionFactor", at<&M::transmission_factor>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_volume/thicknessFactor", at<&M::thickness_factor>},
    {"/extensions/KHR_materials_volume/attenuationDistance", at<&M::attenuation_distance_m>, FLT_MIN},
    {"/extensions/KHR_materials_volume/attenuationColor", at<&M::attenuation_color>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_volume_scatter/multiscatterColor", at<&M::multiscatter_color>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_volume_scatter/multiscatterColorFactor", at<&M::multiscatter_color>, 0.0f, 1.0f},
    {"/extensions/KHR_materials_volume_scatter/scatterAnisotropy", at<&M::scatter_anisotropy>, -0.999f, 0.999f},
};

// The slot's KHR_texture_transform is at path + kTransformPath.
struct SlotRow {
  std::string_view path;
  TextureSlot Material::*slot;
};

constexpr SlotRow kSlotRows[] = {
    {"/normalTexture", &M::normal_texture},
    {"/emissiveTexture", &M::emissive_texture},
    {"/pbrMetallicRoughness/baseColorTexture", &M::base_color_texture},
    {"/pbrMetallicRoughness/metallicRoughnessTexture", &M::metallic_roughness_texture},
    {"/extensions/KHR_materials_anisotropy/anisotropyTexture", &M::anisotropy_texture},
    {"/extensions/KHR_materials_clearcoat/clearcoatTexture", &M::clearcoat_texture},
    {"/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture", &M::clearcoat_roughness_texture},
    {"/extensions/KHR_materials_clearcoat/clearcoatNormalTexture", &M::clearcoat_normal_texture},
    {"/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture", &M::diffuse_transmission_texture},
    {"/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture",
     &M::diffuse_transmission_color_texture},
    {"/extensions/KHR_materials_iridescence/iridescenceTexture", &M::iridescence_texture},
    {"/extensions/KHR_materials_iridescence/iridescenceThicknessTexture", &M::iridescence_thickness_texture},
    {"/extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture", &M::base_color_texture},
    {"/extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture", &M::specular_color_texture},
    {"/extensions/KHR_materials_sheen/sheenColorTexture", &M::sheen_color_texture},
    {"/extensions/KHR_materials_sheen/sheenRoughnessTexture", &M::sheen_roughness_texture},
    {"/extensions/KHR_materials_specular/specularTexture", &M::specular_texture},
    {"/extensions/KHR_materials_specular/specularColorTexture", &M::specular_color_texture},
    {"/extensions/KHR_materials_transmission/transmissionTexture", &M::transmission_texture},
    {"/extensions/KHR_materials_volume/thicknessTexture", &M::thickness_texture},
};
constexpr std::string_view kTransformPath = "/extensions/KHR_texture_transform";
constexpr Row<TextureSlot> kTransformRows[] = {{"/offset", at<&TextureSlot::offset>, -FLT_MAX},
                                               {"/rotation", at<&TextureSlot::rotation_rad>, -FLT_MAX},
                                               {"/scale", at<&TextureSlot::scale>, -FLT_MAX}};

constexpr auto kPerspective = SceneCamera::Kind::perspective;
constexpr auto kOrthographic = SceneCamera::Kind::orthographic;
constexpr float kMinFieldOfView = 1e-4f; // radians, of a lens

constexpr Row<SceneCamera> kCameraRows[] = {
    {"/perspective/yfov", at_lens<kPerspective, &SceneCamera::yfov_rad>, kMinFieldOfView, kPi - kMinFieldOfView},
    {"/perspective/aspectRatio", at_lens<kPerspective, &SceneCamera::aspect_ratio>, 1e-3f, 1e3f},
    {"/perspective/znear", at_lens<kPerspective, &SceneCamera::znear>},
    {"/perspective/zfar",
     [](SceneCamera& camera) { // absent in the file: not animatable
       return std::isfinite(camera.zfar) ? at_lens<kPerspective, &SceneCamera::zfar>(camera) : std::span<float>();
     }},
    {"/orthographic/xmag", at_lens<kOrthographic, &SceneCamera::xmag>, -FLT_MAX},
    {"/orthographic/ymag", at_lens<kOrthographic, &SceneCamera::ymag>, -FLT_MAX},
    {"/orthographic/znear", at_lens<kOrthographic, &SceneCamera::znear>},
    {"/orthographic/zfar", at_lens<kOrthographic, &SceneCamera::zfar>},
};

constexpr Row<PunctualLight> kLightRows[] = {
    {"/color", at<&PunctualLight::color>, 0.0f, 1.0f},
    {"/intensity", at<&PunctualLight::intensity>},
    {"/range", at<&PunctualLight::range_m>, FLT_MIN},
    {"/spot/innerConeAngle", at_spot<&PunctualLight::inner_cone_rad>, 0.0f, kPi / 2},
    {"/spot/outerConeAngle", at_spot<&PunctualLight::outer_cone_rad>, 0.0f, kPi / 2},
};

// Path below the node that carries the EXT_lights_ies light.
constexpr std::string_view kPhotometricPath = "/extensions/EXT_lights_ies";
constexpr Row<PunctualLight> kPhotometricRows[] = {
    {"/color", at<&PunctualLight::color>, 0.0f, 1.0f},
    {"/multiplier", at<&PunctualLight::intensity>},
};

// Imath stores w first; animate_members() rotates the components.
constexpr Row<ImageLight> kImageLightRows[] = {
    {"/intensity", at<&ImageLight::intensity>},
    {"/rotation", at<&ImageLight::rotation>, -FLT_MAX},
};

constexpr Row<Mesh> kMeshRows[] = {
    {"/weights", [](Mesh& mesh) { return std::span<float>(mesh.weights); }, -FLT_MAX},
};

struct Resolved {
  std::span<float> values;
  float min = -FLT_MAX;
  float max = FLT_MAX;
};

template <typename Object>
Resolved resolve(const Row<Object>& row, Object& object) {
  return {row.values(object), row.min, row.max};
}

// A material's rows are its plain values, followed by three for each texture slot.
constexpr size_t kPlainRows = std::size(kMaterialRows);

Resolved resolve(Scene& scene, const AnimatedMember& member) {
  const auto object = static_cast<size_t>(member.object);
  const size_t row = member.row;
  switch (member.owner) {
  case Owner::camera: return resolve(kCameraRows[row], scene.cameras[object]);
  case Owner::light:
    return resolve(scene.lights[object].photometry == kNone ? kLightRows[row] : kPhotometricRows[row],
                   scene.lights[object]);
  case Owner::image_light: return resolve(kImageLightRows[row], scene.image_lights[object]);
  case Owner::mesh: { // "/weights", followed by the individual weights
    const auto all = resolve(kMeshRows[0], scene.meshes[object]);
    return row == 0 ? all : Resolved{all.values.size() >= row ? all.values.subspan(row - 1, 1) : std::span<float>()};
  }
  case Owner::material: break;
  }
  Material& material = scene.materials[object];
  if (row < kPlainRows) return resolve(kMaterialRows[row], material);
  TextureSlot& slot = material.*kSlotRows[(row - kPlainRows) / 3].slot;
  return slot.present() ? resolve(kTransformRows[(row - kPlainRows) % 3], slot) : Resolved{};
}

bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (text.substr(0, prefix.size()) != prefix) return false;
  text.remove_prefix(prefix.size());
  return true;
}

std::optional<int> take_index(std::string_view& text, size_t count) {
  int index = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc() || index < 0 || static_cast<size_t>(index) >= count) return std::nullopt;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return index;
}

template <typename Rows>
std::optional<uint16_t> find_row(const Rows& rows, std::string_view path) {
  for (size_t i = 0; i < std::size(rows); ++i)
    if (rows[i].path == path) return static_cast<uint16_t>(i);
  return std::nullopt;
}

std::optional<uint16_t> find_slot_row(std::string_view path) {
  for (size_t i = 0; i < std::size(kSlotRows); ++i) {
    std::string_view rest = path;
    if (!take_prefix(rest, kSlotRows[i].path) || !take_prefix(rest, kTransformPath)) continue;
    if (const auto part = find_row(kTransformRows, rest)) return static_cast<uint16_t>(kPlainRows + 3 * i + *part);
  }
  return std::nullopt;
}

std::optional<uint16_t> find_weight_row(std::string_view path, const Mesh& mesh) {
  if (const auto all = find_row(kMeshRows, path)) return all;
  if (!take_prefix(path, "/weights/")) return std::nullopt;
  const auto index = take_index(path, std::min<size_t>(mesh.weights.size(), UINT16_MAX - 1));
  if (!index || !path.empty()) return std::nullopt;
  return static_cast<uint16_t>(1 + *index);
}

void enforce_constraints(Material& material) {
  if (material.ior > 0.0f && material.ior < 1.0f) material.ior = 1.0f; // 0 has a special meaning
}
void enforce_constraints(SceneCamera& camera) {
  camera.xmag = std::max(std::abs(camera.xmag), FLT_MIN);
  camera.ymag = std::max(std::abs(camera.ymag), FLT_MIN);
  if (!(camera.zfar > camera.znear)) camera.zfar = std::nextafter(camera.znear, FLT_MAX);
}
void enforce_constraints(PunctualLight& light) {
  if (light.outer_cone_rad > light.inner_cone_rad) return;
  light.outer_cone_rad = std::max(light.outer_cone_rad, 1e-3f);
  light.inner_cone_rad = std::min(light.inner_cone_rad, light.outer_cone_rad * 0.999f);
}
void enforce_constraints(Scene& scene, const AnimatedMember& member) {
  const auto object = static_cast<size_t>(member.object);
  switch (member.owner) {
  case Owner::material: return enforce_constraints(scene.materials[object]);
  case Owner::camera: return enforce_constraints(scene.cameras[object]);
  case Owner::light: return enforce_constraints(scene.lights[object]);
  case Owner::image_light:
  case Owner::mesh: return;
  }
}

template <typename Visit>
void for_each_member(const Scene& scene, const Visit& visit) {
  for (const Animation& animation : scene.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (channel.property == AnimatedProperty::member && !channel.times_s.empty()) visit(channel);
}

} // namespace

std::optional<AnimatedMember> find_animated_member(Scene& scene, std::string_view pointer) {
  AnimatedMember member;
  const auto begins = [&](Owner owner, std::string_view list, size_t count) {
    std::string_view rest = pointer;
    if (!take_prefix(rest, list)) return false;
    const auto index = take_index(rest, count);
    if (!index) return false;
    member.owner = owner;
    member.object = *index;
    pointer = rest;
    return true;
  };
  std::optional<uint16_t> row;
  if (begins(Owner::material, "/materials/", scene.materials.size())) {
    row = find_row(kMaterialRows, pointer);
    if (!row) row = find_slot_row(pointer);
  } else if (begins(Owner::camera, "/cameras/", scene.cameras.size())) {
    row = find_row(kCameraRows, pointer);
  } else if (begins(Owner::light, "/extensions/KHR_lights_punctual/lights/", scene.lights.size())) {
    if (scene.lights[static_cast<size_t>(member.object)].photometry == kNone) row = find_row(kLightRows, pointer);
  } else if (begins(Owner::light, "/nodes/", scene.nodes.size())) {
    member.object = scene.nodes[static_cast<size_t>(member.object)].photometric_light;
    if (member.object == kNone || !take_prefix(pointer, kPhotometricPath)) return std::nullopt;
    row = find_row(kPhotometricRows, pointer);
  } else if (begins(Owner::image_light, "/extensions/EXT_lights_image_based/lights/", scene.image_lights.size())) {
    row = find_row(kImageLightRows, pointer);
    member.quaternion = pointer == "/rotation";
  } else if (begins(Owner::mesh, "/meshes/", scene.meshes.size())) {
    row = find_weight_row(pointer, scene.meshes[static_cast<size_t>(member.object)]);
  }
  if (!row) return std::nullopt;
  member.row = *row;
  if (animated_values(scene, member).empty()) return std::nullopt;
  return member;
}

std::span<float> animated_values(Scene& scene, const AnimatedMember& member) { return resolve(scene, member).values; }

void animate_members(Scene& scene, double time_s) {
  std::vector<float> value;
  for_each_member(scene, [&](const AnimationChannel& channel) {
    const Resolved target = resolve(scene, channel.member);
    if (target.values.size() != static_cast<size_t>(channel.components)) return;
    value.resize(target.values.size());
    sample_channel(channel, time_s, value);
    if (channel.member.quaternion) std::rotate(value.begin(), value.end() - 1, value.end()); // x y z w to w x y z
    for (size_t c = 0; c < value.size(); ++c) target.values[c] = std::clamp(value[c], target.min, target.max);
  });
  // Constraints apply after all values are set: two animated values must not be checked against
  // each other's old ones.
  for_each_member(scene, [&](const AnimationChannel& channel) { enforce_constraints(scene, channel.member); });
}

} // namespace kindling
