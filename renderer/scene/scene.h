// The Scene: decoded and validated file contents as plain data; pose.h poses it in time.
// Nothing here is prepared for rendering.
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

inline constexpr int kNone = -1; // absent index

// One entry of glTF's textures: an image and its sampler. `image` is null if it could not be read;
// then the factor alone applies.
struct SceneTexture {
  std::shared_ptr<const Image> image;
  TextureWrap wrap_u = TextureWrap::repeat;
  TextureWrap wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  std::string name; // for messages: URI or image name
};

// A material's use of a texture: the named texcoord set is transformed by KHR_texture_transform.
struct TextureSlot {
  int texture = kNone; // index into Scene::textures
  int texcoord = 0;
  V2f offset{0.0f, 0.0f};
  V2f scale{1.0f, 1.0f};
  float rotation_rad = 0.0f; // counterclockwise about the origin, as in KHR_texture_transform

  // KHR_texture_procedurals replaces `texture`, which is then kNone; the transform does not affect
  // it.
  int procedural = kNone; // index into Scene::procedurals
  int procedural_output = 0;
  uint32_t procedural_texcoords = 0; // texcoord sets that the graph reads, as a bit mask

  [[nodiscard]] bool present() const { return texture != kNone || procedural != kNone; }
  // Returns the texcoord sets that the slot reads, as a bit mask.
  [[nodiscard]] uint32_t texcoord_sets() const {
    if (procedural != kNone) return procedural_texcoords;
    return texture != kNone && texcoord >= 0 && texcoord < 32 ? 1U << static_cast<unsigned>(texcoord) : 0;
  }
};

enum class AlphaMode : uint8_t { opaque, mask, blend };

// glTF 2.0 metallic-roughness and the material extensions, with their names. Factors are linear.
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
  float anisotropy_rotation_rad = 0.0f; // counterclockwise from the tangent
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
  TextureSlot thickness_texture; // G; used by `info` only: a path tracer knows the true distance
  float attenuation_distance_m = std::numeric_limits<float>::infinity();
  Rgb attenuation_color{1.0f, 1.0f, 1.0f};

  float dispersion = 0.0f; // KHR_materials_dispersion: 20 / Abbe number

  // KHR_materials_volume_scatter, KHR_materials_scatter (drafts).
  Rgb multiscatter_color{0.0f, 0.0f, 0.0f}; // multiple-scattering albedo of the medium; black: none
  float scatter_anisotropy = 0.0f;          // g of Henyey and Greenstein, in [-0.999, 0.999]

  // KHR_materials_pbrSpecularGlossiness: base_color_* hold the diffuse part, metallic is 0,
  // specular_color_* hold F0 itself, and roughness is 1 - glossiness_factor * (A of
  // specular_color_texture).
  bool specular_glossiness = false;
  float glossiness_factor = 1.0f;

  std::string light_group;     // of its emission, of Kindling's extras; empty: none
  bool shadow_catcher = false; // of Kindling's extras: its surfaces are meant to show shadows alone

  std::vector<std::string> extensions_used; // every extension object found on it, supported or not; for `info`
};

// The texture slots that a renderer reads: all except thickness_texture.
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

// Deltas of one morph target. An absent attribute is empty; others have one entry per vertex.
struct MorphTarget {
  std::vector<V3f> positions;
  std::vector<V3f> normals;
  std::vector<V3f> tangents;
};

// KHR_materials_variants: the material of a primitive in one variant.
struct VariantMaterial {
  int variant = 0;  // index into Scene::variants
  int material = 0; // index into Scene::materials
};

// Points and lines as closed bodies of triangles (strokes.h).
enum class Stroke : uint8_t {
  none,
  lit,  // with normals: shaded as the surface that these belong to
  unlit // emits base color and emission to every ray, as glTF 2.0, section 3.9.7, asks without normals
};

// One triangle list in mesh space. Absent attributes are empty; others have one entry per vertex.
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
  Stroke stroke = Stroke::none;
  bool outline = false;            // lines along edges of triangles of the same mesh
  std::vector<V3f> stroke_offsets; // unit; the bodies have no extent until size_strokes() moves vertices along them

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
  std::optional<M44f> matrix; // set: replaces `local`; such a node cannot be animated
  Transform local;
  int mesh = kNone;
  int skin = kNone;
  int camera = kNone;
  int light = kNone;
  int photometric_light = kNone;        // EXT_lights_ies: index into Scene::lights
  std::vector<float> weights;           // overrides Mesh::weights unless empty
  std::vector<Transform> gpu_instances; // EXT_mesh_gpu_instancing: the mesh is drawn once for each, in node space
  bool visible = true;                  // KHR_node_visibility; false hides the node and its descendants
  std::string light_group;              // of the light that it and its descendants emit, of Kindling's extras
  bool shadow_catcher = false;          // of Kindling's extras: it and its descendants are to show shadows alone
};

struct Skin {
  std::string name;
  std::vector<int> joints;                 // nodes
  std::vector<M44f> inverse_bind_matrices; // one per joint
};

enum class Interpolation : uint8_t { step, linear, cubic_spline };
// `member` is a property of an object other than a node; all others are properties of nodes.
enum class AnimatedProperty : uint8_t { translation, rotation, scale, weights, visible, member };

// A property of a material, camera, light or mesh: a row of the tables in animated_members.cpp.
struct AnimatedMember {
  enum class Owner : uint8_t { material, camera, light, image_light, mesh };
  Owner owner = Owner::material;
  bool quaternion = false; // interpolated as a rotation
  uint16_t row = 0;
  int object = kNone; // index into the list of the Scene that `owner` selects
};

// `values` has `components` floats per key (1 to 4, or the number of weights); CUBICSPLINE stores
// in-tangent, value and out-tangent for each key.
struct AnimationChannel {
  int node = kNone;
  AnimatedProperty property = AnimatedProperty::translation;
  int weight = kNone;    // property weights: the only target; kNone: all
  AnimatedMember member; // property member
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> times_s; // strictly increasing
  std::vector<float> values;
  int components = 3;
};

struct Animation {
  std::string name;
  std::vector<AnimationChannel> channels;
};

// A camera looks along local -z with +y up (glTF 2.0, section 3.10).
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

// KHR_lights_punctual; local -z is the axis.
struct PunctualLight {
  enum class Kind : uint8_t { directional, point, spot };
  std::string name;
  Kind kind = Kind::point;
  Rgb color{1.0f, 1.0f, 1.0f};
  float intensity = 1.0f;       // directional: lux; point and spot: candela
  std::optional<float> range_m; // cut-off hint of the file
  // Extras of Kindling; unset if absent in the file.
  std::optional<float> radius_m;             // point and spot: radius of a uniformly emitting sphere
  std::optional<float> angular_diameter_rad; // directional: angular diameter of the disk in the sky
  float inner_cone_rad = 0.0f;               // spot, half angles
  float outer_cone_rad = kPi / 4.0f;
  int photometry = kNone;  // EXT_lights_ies, with kind point: index into Scene::photometries; `intensity` scales it
  std::string light_group; // of Kindling's extras; empty: none
};

// EXT_lights_ies: the measured light distribution of a luminaire (IES LM-63).
struct Photometry {
  // Angular conventions; x, y and z are those of the light's node, and (0, 0) is -z. c: the
  // vertical angle starts at -z, the horizontal angle turns from +x to +y. a and b: the vertical
  // angle turns from -z to +x, the horizontal angle to -y; the poles of a are at +-x, those of b at
  // +-y.
  enum class Kind : uint8_t { a, b, c };
  std::string name;
  Kind kind = Kind::c;
  std::vector<float> vertical_deg;   // increasing, at least one
  std::vector<float> horizontal_deg; // likewise; less than a full circle: the distribution is symmetric
  std::vector<float> candela;        // >= 0; for each horizontal angle the values at all vertical angles
};

// EXT_lights_image_based: an environment light.
struct ImageLight {
  std::string name;
  Quatf rotation{1.0f, 0.0f, 0.0f, 0.0f}; // unit; turns the environment
  float intensity = 1.0f;
  // The irradiance on a plane with normal n is the sum of these coefficients times the real
  // spherical harmonics at n, in the order l = 0, 1, 2, m = -l to l.
  std::array<Rgb, 9> irradiance_coefficients{};
  // Linear RGB radiance as f32; the faces are square and equal in size. The order is +x, -x, +y,
  // -y, +z, -z as seen from within, with +y up for the sides (EXT_lights_image_based defines the
  // other two). Null: could not be read.
  std::array<std::shared_ptr<const Image>, 6> faces;
};

// The root nodes of one entry of glTF's scenes.
struct SceneRoot {
  std::string name;
  std::vector<int> nodes;
  int image_light = kNone; // index into Scene::image_lights
};

struct Scene {
  std::string source; // path as given by the user; prefix of all messages
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
  std::vector<PunctualLight> lights; // lights of KHR_lights_punctual, then one for each node with EXT_lights_ies
  std::vector<Photometry> photometries;
  std::vector<ImageLight> image_lights;
  std::vector<SceneRoot> scenes;
  std::vector<std::string> variants; // KHR_materials_variants names
  int default_scene = kNone;
  uint64_t content_hash = 0; // hash of all bytes read; equal for equal files
};

} // namespace kindling
