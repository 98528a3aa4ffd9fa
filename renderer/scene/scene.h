// The Scene: plain data, what a file asked for. Nothing here is prepared for rendering; posing it in time is scene/pose.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/image/image.h"
#include "renderer/scene/camera_lens.h"
#include "renderer/scene/shutter.h"
#include "renderer/texture/procedural_graph.h"
#include "renderer/texture/texture_settings.h"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kindling {

inline constexpr int kNone = -1; // an index that is absent

// One entry of glTF's textures: an image and how to read it. `image` is null if it could not be read: use the factor alone.
struct SceneTexture {
  std::shared_ptr<const Image> image;
  TextureWrap wrap_u = TextureWrap::repeat;
  TextureWrap wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  std::string name; // for messages: URI or image name
};

// A material's use of a texture. uv' = transform applied to the named texcoord set (KHR_texture_transform folded in).
struct TextureSlot {
  int texture = kNone; // index into Scene::textures
  int texcoord = 0;
  V2f offset{0.0f, 0.0f};
  V2f scale{1.0f, 1.0f};
  float rotation_rad = 0.0f; // counter-clockwise about the origin, as KHR_texture_transform defines it

  // KHR_texture_procedurals: in place of `texture`, which is kNone then; the transform has no effect on it.
  int procedural = kNone; // index into Scene::procedurals
  int procedural_output = 0;
  uint32_t procedural_texcoords = 0; // sets that the graph reads, as bits

  [[nodiscard]] bool present() const { return texture != kNone || procedural != kNone; }
  // The sets of texture coordinates that it reads, as bits.
  [[nodiscard]] uint32_t texcoord_sets() const {
    if (procedural != kNone) return procedural_texcoords;
    return texture != kNone && texcoord >= 0 && texcoord < 32 ? 1U << static_cast<unsigned>(texcoord) : 0;
  }
};

enum class AlphaMode : uint8_t { opaque, mask, blend };

// glTF 2.0 metallic-roughness and the extensions of materials, named as they name them. Factors are linear.
struct Material {
  std::string name;
  V4f base_color_factor{1.0f, 1.0f, 1.0f, 1.0f};
  TextureSlot base_color_texture; // sRGB, alpha linear
  float metallic_factor = 1.0f;
  float roughness_factor = 1.0f;
  TextureSlot metallic_roughness_texture; // G roughness, B metallic
  TextureSlot normal_texture;
  float normal_scale = 1.0f;
  Rgb emissive_factor{0.0f, 0.0f, 0.0f}; // times emissive_strength: radiance in W / (sr m^2) per channel
  float emissive_strength = 1.0f;        // KHR_materials_emissive_strength
  TextureSlot emissive_texture;          // sRGB
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
  bool unlit = false; // KHR_materials_unlit: base color is emitted, nothing is reflected

  float ior = 1.5f;             // KHR_materials_ior
  float specular_factor = 1.0f; // KHR_materials_specular
  TextureSlot specular_texture; // A
  Rgb specular_color_factor{1.0f, 1.0f, 1.0f};
  TextureSlot specular_color_texture; // sRGB

  float clearcoat_factor = 0.0f; // KHR_materials_clearcoat
  TextureSlot clearcoat_texture; // R
  float clearcoat_roughness_factor = 0.0f;
  TextureSlot clearcoat_roughness_texture; // G
  TextureSlot clearcoat_normal_texture;    // absent: the coat has the plain normal of the mesh
  float clearcoat_normal_scale = 1.0f;

  Rgb sheen_color_factor{0.0f, 0.0f, 0.0f}; // KHR_materials_sheen
  TextureSlot sheen_color_texture;          // sRGB
  float sheen_roughness_factor = 0.0f;
  TextureSlot sheen_roughness_texture; // A

  float anisotropy_strength = 0.0f;     // KHR_materials_anisotropy
  float anisotropy_rotation_rad = 0.0f; // counter-clockwise from the tangent
  TextureSlot anisotropy_texture;       // RG direction in [-1, 1], B strength

  float iridescence_factor = 0.0f; // KHR_materials_iridescence
  TextureSlot iridescence_texture; // R
  float iridescence_ior = 1.3f;
  float iridescence_thickness_minimum_nm = 100.0f;
  float iridescence_thickness_maximum_nm = 400.0f;
  TextureSlot iridescence_thickness_texture; // G; absent: the maximum

  float transmission_factor = 0.0f; // KHR_materials_transmission
  TextureSlot transmission_texture; // R

  float diffuse_transmission_factor = 0.0f; // KHR_materials_diffuse_transmission
  TextureSlot diffuse_transmission_texture; // A
  Rgb diffuse_transmission_color_factor{1.0f, 1.0f, 1.0f};
  TextureSlot diffuse_transmission_color_texture; // sRGB

  float thickness_factor = 0.0f; // KHR_materials_volume: above 0 the mesh bounds a medium, else it is thin-walled
  TextureSlot thickness_texture; // G; a path tracer knows the true distance: kept for info alone
  float attenuation_distance_m = std::numeric_limits<float>::infinity();
  Rgb attenuation_color{1.0f, 1.0f, 1.0f};

  float dispersion = 0.0f; // KHR_materials_dispersion: 20 / Abbe number

  // KHR_materials_volume_scatter, KHR_materials_scatter (drafts).
  Rgb multiscatter_color{0.0f, 0.0f, 0.0f}; // albedo of the medium after all of its scattering; black: none
  float scatter_anisotropy = 0.0f;          // g of Henyey and Greenstein, from -0.999 to 0.999

  // KHR_materials_pbrSpecularGlossiness: base_color_* hold the diffuse part, metallic is 0, specular_color_* hold F0 itself, and
  // roughness is 1 - glossiness_factor * (A of specular_color_texture).
  bool specular_glossiness = false;
  float glossiness_factor = 1.0f;

  std::vector<std::string> extensions_used; // every extension object met on it, supported or not: for info
};

// The textures of a material that a renderer reads: all but thickness_texture.
inline constexpr std::array<TextureSlot Material::*, 17> kMaterialTextures{
    &Material::base_color_texture,
    &Material::metallic_roughness_texture,
    &Material::normal_texture,
    &Material::emissive_texture,
    &Material::specular_texture,
    &Material::specular_color_texture,
    &Material::clearcoat_texture,
    &Material::clearcoat_roughness_texture,
    &Material::clearcoat_normal_texture,
    &Material::sheen_color_texture,
    &Material::sheen_roughness_texture,
    &Material::anisotropy_texture,
    &Material::iridescence_texture,
    &Material::iridescence_thickness_texture,
    &Material::transmission_texture,
    &Material::diffuse_transmission_texture,
    &Material::diffuse_transmission_color_texture};

// Deltas of one morph target; an absent attribute is empty, others have one entry per vertex.
struct MorphTarget {
  std::vector<V3f> positions;
  std::vector<V3f> normals;
  std::vector<V3f> tangents;
};

// KHR_materials_variants: the material that a primitive has in one of the variants.
struct VariantMaterial {
  int variant = 0;  // index into Scene::variants
  int material = 0; // index into Scene::materials
};

// One triangle list in the mesh's space. Attributes are empty where absent, else one entry per vertex.
struct Primitive {
  int material = kNone;                           // kNone: glTF's default material
  std::vector<VariantMaterial> variant_materials; // each variant at most once; in others it keeps `material`
  std::vector<uint32_t> indices; // three per triangle; strips and fans are unrolled, non-indexed ones get 0, 1, 2, ...
  std::vector<V3f> positions;
  std::vector<V3f> normals;                    // empty: flat shading by the geometric normal
  std::vector<V4f> tangents;                   // xyz unit, w the sign of the bitangent
  std::vector<std::vector<V2f>> texcoords;     // by set number
  std::vector<V4f> colors;                     // COLOR_0, linear, alpha 1 where the file has RGB
  std::vector<std::array<uint16_t, 4>> joints; // sets 0 and up concatenated: vertex v, set s at [s * vertex_count + v]
  std::vector<V4f> weights;                    // like joints; normalized to sum 1 over all sets
  std::vector<MorphTarget> targets;

  [[nodiscard]] size_t triangle_count() const { return indices.size() / 3; }
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
  std::vector<float> weights; // default morph weights
};

struct Transform {
  V3f translation{0.0f, 0.0f, 0.0f};
  Quatf rotation{1.0f, 0.0f, 0.0f, 0.0f}; // unit
  V3f scale{1.0f, 1.0f, 1.0f};
};

struct Node {
  std::string name;
  std::vector<int> children;
  std::optional<M44f> matrix; // set: used in place of `local` (such a node cannot be animated)
  Transform local;
  int mesh = kNone;
  int skin = kNone;
  int camera = kNone;
  int light = kNone;
  int photometric_light = kNone;        // EXT_lights_ies: index into Scene::lights
  std::vector<float> weights;           // overrides Mesh::weights where not empty
  std::vector<Transform> gpu_instances; // EXT_mesh_gpu_instancing: the mesh is drawn once for each, in the node's space
  bool visible = true;                  // KHR_node_visibility; false hides the node and all below it
};

struct Skin {
  std::string name;
  std::vector<int> joints;                 // nodes
  std::vector<M44f> inverse_bind_matrices; // one per joint
};

enum class Interpolation : uint8_t { step, linear, cubic_spline };
// member: of an object that is no node. The others are of nodes.
enum class AnimatedProperty : uint8_t { translation, rotation, scale, weights, visible, member };

// A property of a material, camera, light or mesh: a row of the tables of animated_members.h, which resolve it to numbers.
struct AnimatedMember {
  enum class Of : uint8_t { material, camera, light, image_light, mesh };
  Of of = Of::material;
  bool quaternion = false; // interpolated as a rotation
  uint16_t row = 0;
  int object = kNone; // index into the list of the Scene that `of` names
};

// values: components per key (1 to 4 or the weight count); CUBICSPLINE has in-tangent, value, out-tangent for each key.
struct AnimationChannel {
  int node = kNone;
  AnimatedProperty property = AnimatedProperty::translation;
  int weight = kNone;    // property weights: this target alone; kNone: all
  AnimatedMember member; // property member
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> times_s; // strictly increasing, >= 0
  std::vector<float> values;
  int components = 3;
};

struct Animation {
  std::string name;
  std::vector<AnimationChannel> channels;
};

// Looks along local -z, +y up (glTF 2.0, section 3.10).
struct SceneCamera {
  enum class Kind : uint8_t { perspective, orthographic };
  std::string name;
  Kind kind = Kind::perspective;
  float yfov_rad = 0.8f;             // perspective, full angle
  std::optional<float> aspect_ratio; // width / height
  float xmag = 1.0f;                 // orthographic, half the width
  float ymag = 1.0f;                 // orthographic, half the height
  float znear = 0.0f;
  float zfar = std::numeric_limits<float>::infinity();
  CameraLens lens;
  std::optional<Shutter> shutter; // relative to the time of the image
};

// KHR_lights_punctual, local -z is the axis.
struct PunctualLight {
  enum class Kind : uint8_t { directional, point, spot };
  std::string name;
  Kind kind = Kind::point;
  Rgb color{1.0f, 1.0f, 1.0f};
  float intensity = 1.0f;       // directional: lux; point and spot: candela
  std::optional<float> range_m; // cut-off hint of the file
  // Extras of ours; unset: the file does not say.
  std::optional<float> radius_m;             // point and spot: of a sphere that shines evenly
  std::optional<float> angular_diameter_rad; // directional: of a disc in the sky
  float inner_cone_rad = 0.0f;               // spot, half angles
  float outer_cone_rad = kPi / 4.0f;
  int photometry =
      kNone; // EXT_lights_ies, with kind point: index into Scene::photometries, which `intensity` multiplies
};

// EXT_lights_ies: the light distribution of a luminaire, as measured (IES LM-63).
struct Photometry {
  // How angles name a direction; x, y, z are of the node that the light is on, and (0, 0) is -z.
  // c: vertical angle from -z, horizontal angle from +x to +y. a, b: the vertical angle turns -z to +x, the horizontal one to -y; of a the
  // poles are at +-x, of b at +-y.
  enum class Kind : uint8_t { a, b, c };
  std::string name;
  Kind kind = Kind::c;
  std::vector<float> vertical_deg;   // increasing, at least one
  std::vector<float> horizontal_deg; // likewise; fewer than all around: the distribution is symmetric
  std::vector<float> candela;        // >= 0; for each horizontal angle those of all vertical ones
};

// EXT_lights_image_based: light from all around.
struct ImageLight {
  std::string name;
  Quatf rotation{1.0f, 0.0f, 0.0f, 0.0f}; // unit; turns the environment
  float intensity = 1.0f;
  // Irradiance on a plane of normal n is the sum of these times the real spherical harmonics at n, in the order l = 0, 1, 2, m = -l to l.
  std::array<Rgb, 9> irradiance_coefficients{};
  // Radiance: linear, f32 RGB, square and all of one size; +x, -x, +y, -y, +z, -z as seen from within, with +y up for the sides (EXT_lights_image_based
  // says how for the other two). Null: could not be read.
  std::array<std::shared_ptr<const Image>, 6> faces;
};

// What a list of roots shows: one entry of glTF's scenes.
struct SceneRoot {
  std::string name;
  std::vector<int> nodes;
  int image_light = kNone; // index into Scene::image_lights
};

struct Scene {
  std::string source; // path as the user gave it: begins every message
  std::string generator;
  std::string copyright;
  std::vector<std::string> extensions_used;

  std::vector<SceneTexture> textures;
  std::vector<ProceduralGraph> procedurals;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Skin> skins;
  std::vector<Animation> animations;
  std::vector<SceneCamera> cameras;
  std::vector<PunctualLight> lights; // those of KHR_lights_punctual, then one for each node with EXT_lights_ies
  std::vector<Photometry> photometries;
  std::vector<ImageLight> image_lights;
  std::vector<SceneRoot> scenes;
  std::vector<std::string> variants; // KHR_materials_variants names
  int default_scene = kNone;
  uint64_t content_hash = 0; // of all bytes that were read: the same file gives the same number
};

} // namespace kindling
