// Schema tables of glTF 2.0 (section 5) and of the supported extensions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/json_schema.h"

namespace kindling::gltf {
namespace {

using K = JsonKind;
using P = JsonProperty;
using E = JsonExtension;

constexpr double kMaxInteger = 9007199254740991.0; // 2^53 - 1: every JSON reader represents it exactly
constexpr double kMaxInt = 2147483647.0;
// The square of a larger length is not a finite float.
constexpr double kFar = 1e18;
constexpr double kMaxTexcoordSet = 31.0;

constexpr int kComponentTypes[] = {5120, 5121, 5122, 5123, 5125, 5126};
constexpr int kIndexTypes[] = {5121, 5123, 5125};
constexpr int kModes[] = {0, 1, 2, 3, 4, 5, 6};
constexpr int kMagFilters[] = {9728, 9729};
constexpr int kMinFilters[] = {9728, 9729, 9984, 9985, 9986, 9987};
constexpr int kWraps[] = {33071, 33648, 10497};
constexpr std::string_view kElementTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
constexpr std::string_view kInterpolations[] = {"LINEAR", "STEP", "CUBICSPLINE"};
constexpr std::string_view kCameraTypes[] = {"perspective", "orthographic"};
constexpr std::string_view kAlphaModes[] = {"OPAQUE", "MASK", "BLEND"};
constexpr std::string_view kLightTypes[] = {"directional", "point", "spot"};
constexpr std::string_view kMeshoptModes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
constexpr std::string_view kMeshoptFilters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"};

constexpr auto kClamp = JsonRepair::clamp;
constexpr auto kIgnore = JsonRepair::ignore;

constexpr P kName{.name = "name", .kind = K::string, .repair = kIgnore};

constexpr P kAssetProperties[] = {{.name = "version", .kind = K::string, .required = true},
                                  {.name = "minVersion", .kind = K::string},
                                  {.name = "generator", .kind = K::string, .repair = kIgnore},
                                  {.name = "copyright", .kind = K::string, .repair = kIgnore}};
constexpr JsonSchema kAsset{.properties = kAssetProperties};

constexpr P kMeshoptBufferProperties[] = {{.name = "fallback", .kind = K::boolean}};
constexpr JsonSchema kMeshoptBuffer{.properties = kMeshoptBufferProperties};
constexpr E kBufferExtensions[] = {{"EXT_meshopt_compression", &kMeshoptBuffer},
                                   {"KHR_meshopt_compression", &kMeshoptBuffer}};
constexpr P kBufferProperties[] = {{.name = "byteLength",
                                    .kind = K::integer,
                                    .required = true,
                                    .min = 1,
                                    .max = kMaxInteger,
                                    .lenient_min = 0,
                                    .lenient_max = 0},
                                   {.name = "uri", .kind = K::string}};
constexpr JsonSchema kBuffer{.properties = kBufferProperties, .extensions = kBufferExtensions};

constexpr P kMeshoptViewProperties[] = {
    {.name = "buffer", .kind = K::index, .required = true, .collection = "buffers"},
    {.name = "byteOffset", .kind = K::integer, .min = 0, .max = kMaxInteger},
    {.name = "byteLength", .kind = K::integer, .required = true, .min = 1, .max = kMaxInteger},
    {.name = "byteStride", .kind = K::integer, .required = true, .min = 1, .max = 256},
    {.name = "count", .kind = K::integer, .required = true, .min = 1, .max = kMaxInteger},
    {.name = "mode", .kind = K::choice, .required = true, .choices = kMeshoptModes},
    {.name = "filter", .kind = K::choice, .choices = kMeshoptFilters}};
constexpr JsonSchema kMeshoptView{.properties = kMeshoptViewProperties};
constexpr E kBufferViewExtensions[] = {{"EXT_meshopt_compression", &kMeshoptView},
                                       {"KHR_meshopt_compression", &kMeshoptView}};
constexpr P kBufferViewProperties[] = {{.name = "buffer", .kind = K::index, .required = true, .collection = "buffers"},
                                       {.name = "byteOffset", .kind = K::integer, .min = 0, .max = kMaxInteger},
                                       {.name = "byteLength",
                                        .kind = K::integer,
                                        .required = true,
                                        .min = 1,
                                        .max = kMaxInteger,
                                        .lenient_min = 0,
                                        .lenient_max = 0},
                                       // 0 is removed: no stride.
                                       {.name = "byteStride",
                                        .kind = K::integer,
                                        .min = 4,
                                        .max = 252,
                                        .multiple_of = 4,
                                        .repair = kIgnore,
                                        .lenient_min = 1,
                                        .lenient_max = 65536}};
constexpr JsonSchema kBufferView{.properties = kBufferViewProperties, .extensions = kBufferViewExtensions};

constexpr P kSparseIndicesProperties[] = {
    {.name = "bufferView", .kind = K::index, .required = true, .collection = "bufferViews"},
    {.name = "byteOffset", .kind = K::integer, .min = 0, .max = kMaxInt},
    {.name = "componentType", .kind = K::code, .required = true, .codes = kIndexTypes}};
constexpr JsonSchema kSparseIndices{.properties = kSparseIndicesProperties};
constexpr P kSparseValuesProperties[] = {
    {.name = "bufferView", .kind = K::index, .required = true, .collection = "bufferViews"},
    {.name = "byteOffset", .kind = K::integer, .min = 0, .max = kMaxInt}};
constexpr JsonSchema kSparseValues{.properties = kSparseValuesProperties};
constexpr P kSparseProperties[] = {{.name = "count",
                                    .kind = K::integer,
                                    .required = true,
                                    .min = 1,
                                    .max = kMaxInt,
                                    .lenient_min = 0,
                                    .lenient_max = 0},
                                   {.name = "indices", .kind = K::object, .required = true, .schema = &kSparseIndices},
                                   {.name = "values", .kind = K::object, .required = true, .schema = &kSparseValues}};
constexpr JsonSchema kSparse{.properties = kSparseProperties};
constexpr P kAccessorProperties[] = {
    {.name = "bufferView", .kind = K::index, .collection = "bufferViews"},
    {.name = "byteOffset", .kind = K::integer, .min = 0, .max = kMaxInteger},
    {.name = "componentType", .kind = K::code, .required = true, .codes = kComponentTypes},
    {.name = "normalized", .kind = K::boolean, .repair = kIgnore},
    {.name = "count",
     .kind = K::integer,
     .required = true,
     .min = 1,
     .max = kMaxInteger,
     .lenient_min = 0,
     .lenient_max = 0},
    {.name = "type", .kind = K::choice, .required = true, .choices = kElementTypes},
    {.name = "sparse", .kind = K::object, .schema = &kSparse}};

constexpr P kDracoProperties[] = {
    {.name = "bufferView", .kind = K::index, .required = true, .collection = "bufferViews"},
    // Ids within the compressed data, not indices of accessors; read by draco_mesh.cpp.
    {.name = "attributes", .kind = K::object, .required = true}};
constexpr JsonSchema kDraco{.properties = kDracoProperties};
constexpr P kMappingProperties[] = {
    kName,
    {.name = "material", .kind = K::index, .required = true, .collection = "materials"},
    // Indices of the root extension's variants; checked by variant_mappings.cpp.
    {.name = "variants", .kind = K::integer, .required = true, .array = true, .min = 0, .max = kMaxInt}};
constexpr JsonSchema kMapping{.properties = kMappingProperties};
constexpr P kMappingsProperties[] = {
    {.name = "mappings", .kind = K::object, .required = true, .array = true, .schema = &kMapping}};
constexpr JsonSchema kMappings{.properties = kMappingsProperties};
constexpr E kPrimitiveExtensions[] = {{"KHR_draco_mesh_compression", &kDraco},
                                      {"KHR_materials_variants", &kMappings, kIgnore}};
constexpr P kPrimitiveProperties[] = {
    {.name = "attributes", .kind = K::index_map, .required = true, .collection = "accessors"},
    {.name = "indices", .kind = K::index, .collection = "accessors"},
    {.name = "material", .kind = K::index, .collection = "materials"},
    {.name = "mode", .kind = K::code, .codes = kModes},
    {.name = "targets", .kind = K::index_map, .array = true, .collection = "accessors"}};
constexpr JsonSchema kPrimitive{.properties = kPrimitiveProperties, .extensions = kPrimitiveExtensions};
constexpr P kMeshProperties[] = {
    kName,
    {.name = "primitives", .kind = K::object, .required = true, .array = true, .schema = &kPrimitive},
    {.name = "weights", .array = true, .repair = kIgnore}};
constexpr JsonSchema kMesh{.properties = kMeshProperties};

constexpr P kNodeLightProperties[] = {
    {.name = "light", .kind = K::integer, .required = true, .min = 0, .max = kMaxInt}};
constexpr JsonSchema kNodeLight{.properties = kNodeLightProperties};
constexpr P kNodeVisibilityProperties[] = {{.name = "visible", .kind = K::boolean, .repair = kIgnore}};
constexpr JsonSchema kNodeVisibility{.properties = kNodeVisibilityProperties};
constexpr P kInstancingProperties[] = {
    {.name = "attributes", .kind = K::index_map, .required = true, .collection = "accessors"}};
constexpr JsonSchema kInstancing{.properties = kInstancingProperties};
constexpr P kNodePhotometryProperties[] = {
    {.name = "light", .kind = K::integer, .required = true, .min = 0, .max = kMaxInt},
    {.name = "multiplier", .min = 0, .repair = kClamp},
    {.name = "color",
     .array = true,
     .min_items = 3,
     .max_items = 3,
     .min = 0,
     .max = 1,
     .repair = kClamp,
     .lenient_min = 1,
     .lenient_max = FLT_MAX}};
constexpr JsonSchema kNodePhotometry{.properties = kNodePhotometryProperties};
constexpr E kNodeExtensions[] = {{"EXT_lights_ies", &kNodePhotometry, kIgnore},
                                 {"KHR_lights_punctual", &kNodeLight, kIgnore},
                                 {"KHR_node_visibility", &kNodeVisibility, kIgnore},
                                 {"EXT_mesh_gpu_instancing", &kInstancing}};
constexpr P kNodeProperties[] = {
    kName,
    {.name = "children", .kind = K::index, .array = true, .collection = "nodes"},
    {.name = "mesh", .kind = K::index, .collection = "meshes"},
    {.name = "skin", .kind = K::index, .collection = "skins"},
    {.name = "camera", .kind = K::index, .collection = "cameras", .repair = kIgnore},
    {.name = "matrix", .array = true, .min_items = 16, .max_items = 16, .min = -kFar, .max = kFar},
    {.name = "translation", .array = true, .min_items = 3, .max_items = 3, .min = -kFar, .max = kFar},
    // A quaternion of another length is normalized.
    {.name = "rotation",
     .array = true,
     .min_items = 4,
     .max_items = 4,
     .min = -1,
     .max = 1,
     .lenient_min = -kFar,
     .lenient_max = kFar},
    {.name = "scale", .array = true, .min_items = 3, .max_items = 3, .min = -kFar, .max = kFar},
    {.name = "weights", .array = true, .repair = kIgnore}};
constexpr JsonSchema kNode{.properties = kNodeProperties, .extensions = kNodeExtensions};

constexpr P kSceneProperties[] = {kName, {.name = "nodes", .kind = K::index, .array = true, .collection = "nodes"}};
constexpr P kSceneLightProperties[] = {
    {.name = "light", .kind = K::integer, .required = true, .min = 0, .max = kMaxInt}};
constexpr JsonSchema kSceneLight{.properties = kSceneLightProperties};
constexpr E kSceneExtensions[] = {{"EXT_lights_image_based", &kSceneLight, kIgnore}};
constexpr JsonSchema kScene{.properties = kSceneProperties, .extensions = kSceneExtensions};

constexpr P kSkinProperties[] = {
    kName,
    {.name = "joints", .kind = K::index, .required = true, .array = true, .min_items = 1, .collection = "nodes"},
    {.name = "skeleton", .kind = K::index, .collection = "nodes", .repair = kIgnore},
    {.name = "inverseBindMatrices", .kind = K::index, .collection = "accessors"}};
constexpr JsonSchema kSkin{.properties = kSkinProperties};

constexpr P kAnimationPointerProperties[] = {{.name = "pointer", .kind = K::string, .required = true}};
constexpr JsonSchema kAnimationPointer{.properties = kAnimationPointerProperties};
constexpr E kTargetExtensions[] = {{"KHR_animation_pointer", &kAnimationPointer}};
constexpr P kTargetProperties[] = {{.name = "node", .kind = K::index, .collection = "nodes"},
                                   {.name = "path", .kind = K::string, .required = true}};
constexpr P kChannelProperties[] = {
    {.name = "sampler", .kind = K::integer, .required = true, .min = 0, .max = kMaxInt},
    {.name = "target", .kind = K::object, .required = true, .schema = &kChannelTargetSchema}};
constexpr JsonSchema kChannel{.properties = kChannelProperties};
constexpr P kAnimationSamplerProperties[] = {
    {.name = "input", .kind = K::index, .required = true, .collection = "accessors"},
    {.name = "output", .kind = K::index, .required = true, .collection = "accessors"},
    {.name = "interpolation", .kind = K::choice, .choices = kInterpolations, .repair = kIgnore}};
constexpr JsonSchema kAnimationSampler{.properties = kAnimationSamplerProperties};
constexpr P kAnimationProperties[] = {kName,
                                      {.name = "channels",
                                       .kind = K::object,
                                       .required = true,
                                       .array = true,
                                       .schema = &kChannel,
                                       .repair = JsonRepair::skip},
                                      // animations.cpp drops the channels of a sampler without
                                      // accessors.
                                      {.name = "samplers",
                                       .kind = K::object,
                                       .required = true,
                                       .array = true,
                                       .schema = &kAnimationSampler,
                                       .repair = JsonRepair::replace,
                                       .stand_in = R"({"input": -1, "output": -1})"}};
constexpr JsonSchema kAnimation{.properties = kAnimationProperties};

// The renderer clips nothing, so any near and far plane will do.
constexpr P kPerspectiveProperties[] = {{.name = "aspectRatio", .min = 0, .above_min = true, .repair = kIgnore},
                                        {.name = "yfov", .required = true, .min = 0, .above_min = true},
                                        {.name = "zfar", .min = 0, .above_min = true, .repair = kIgnore},
                                        {.name = "znear",
                                         .required = true,
                                         .min = 0,
                                         .above_min = true,
                                         .repair = kIgnore,
                                         .lenient_min = -kFar,
                                         .lenient_max = 0,
                                         .stand_in = "0"}};
constexpr JsonSchema kPerspective{.properties = kPerspectiveProperties};
constexpr P kOrthographicProperties[] = {
    {.name = "xmag", .required = true},
    {.name = "ymag", .required = true},
    {.name = "zfar", .required = true, .min = 0, .above_min = true, .repair = kIgnore, .stand_in = "1e18"},
    {.name = "znear",
     .required = true,
     .min = 0,
     .repair = kIgnore,
     .lenient_min = -kFar,
     .lenient_max = 0,
     .stand_in = "0"}};
constexpr JsonSchema kOrthographic{.properties = kOrthographicProperties};
constexpr P kCameraProperties[] = {
    kName,
    {.name = "type", .kind = K::choice, .required = true, .choices = kCameraTypes, .repair = kIgnore},
    {.name = "perspective", .kind = K::object, .schema = &kPerspective},
    {.name = "orthographic", .kind = K::object, .schema = &kOrthographic}};

constexpr P kTextureTransformProperties[] = {
    {.name = "offset", .array = true, .min_items = 2, .max_items = 2, .repair = kClamp},
    {.name = "rotation", .repair = kClamp},
    {.name = "scale", .array = true, .min_items = 2, .max_items = 2, .repair = kClamp},
    {.name = "texCoord", .kind = K::integer, .min = 0, .max = kMaxTexcoordSet, .repair = kIgnore}};
constexpr JsonSchema kTextureTransform{.properties = kTextureTransformProperties};
constexpr E kTextureInfoExtensions[] = {{"KHR_texture_transform", &kTextureTransform, kIgnore}};
constexpr P kTextureIndex{.name = "index", .kind = K::index, .required = true, .collection = "textures"};
constexpr P kTexcoord{.name = "texCoord", .kind = K::integer, .min = 0, .max = kMaxTexcoordSet, .repair = kIgnore};
constexpr P kTextureInfoProperties[] = {kTextureIndex, kTexcoord};
constexpr JsonSchema kTextureInfo{.properties = kTextureInfoProperties, .extensions = kTextureInfoExtensions};
constexpr P kNormalTextureProperties[] = {kTextureIndex, kTexcoord, {.name = "scale", .repair = kClamp}};
constexpr JsonSchema kNormalTexture{.properties = kNormalTextureProperties, .extensions = kTextureInfoExtensions};
constexpr P kOcclusionTextureProperties[] = {
    kTextureIndex, kTexcoord, {.name = "strength", .min = 0, .max = 1, .repair = kClamp}};
constexpr JsonSchema kOcclusionTexture{.properties = kOcclusionTextureProperties, .extensions = kTextureInfoExtensions};
constexpr P kMetallicRoughnessProperties[] = {
    {.name = "baseColorFactor", .array = true, .min_items = 4, .max_items = 4, .min = 0, .max = 1, .repair = kClamp},
    {.name = "baseColorTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "metallicFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "roughnessFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "metallicRoughnessTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kMetallicRoughness{.properties = kMetallicRoughnessProperties};
// Material extensions, ordered by name.
constexpr P kAnisotropyProperties[] = {
    {.name = "anisotropyStrength", .min = 0, .max = 1, .repair = kClamp},
    {.name = "anisotropyRotation", .repair = kClamp},
    {.name = "anisotropyTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kAnisotropy{.properties = kAnisotropyProperties};
constexpr P kClearcoatProperties[] = {
    {.name = "clearcoatFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "clearcoatTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "clearcoatRoughnessFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "clearcoatRoughnessTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "clearcoatNormalTexture", .kind = K::object, .schema = &kNormalTexture, .repair = kIgnore}};
constexpr JsonSchema kClearcoat{.properties = kClearcoatProperties};
constexpr P kDiffuseTransmissionProperties[] = {
    {.name = "diffuseTransmissionFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "diffuseTransmissionTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "diffuseTransmissionColorFactor",
     .array = true,
     .min_items = 3,
     .max_items = 3,
     .min = 0,
     .max = 1,
     .repair = kClamp},
    {.name = "diffuseTransmissionColorTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kDiffuseTransmission{.properties = kDiffuseTransmissionProperties};
constexpr P kDispersionProperties[] = {{.name = "dispersion", .min = 0, .repair = kClamp}};
constexpr JsonSchema kDispersion{.properties = kDispersionProperties};
constexpr P kEmissiveStrengthProperties[] = {{.name = "emissiveStrength", .min = 0, .repair = kClamp}};
constexpr JsonSchema kEmissiveStrength{.properties = kEmissiveStrengthProperties};
constexpr P kIorProperties[] = {
    {.name = "ior", .min = 0, .repair = kClamp}}; // 0 or at least 1: material_extensions.cpp
constexpr JsonSchema kIor{.properties = kIorProperties};
constexpr P kIridescenceProperties[] = {
    {.name = "iridescenceFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "iridescenceTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "iridescenceIor", .min = 1, .repair = kClamp},
    {.name = "iridescenceThicknessMinimum", .min = 0, .repair = kClamp},
    {.name = "iridescenceThicknessMaximum", .min = 0, .repair = kClamp},
    {.name = "iridescenceThicknessTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kIridescence{.properties = kIridescenceProperties};
constexpr P kSpecularGlossinessProperties[] = {
    {.name = "diffuseFactor", .array = true, .min_items = 4, .max_items = 4, .min = 0, .max = 1, .repair = kClamp},
    {.name = "diffuseTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "specularFactor", .array = true, .min_items = 3, .max_items = 3, .min = 0, .max = 1, .repair = kClamp},
    {.name = "glossinessFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "specularGlossinessTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kSpecularGlossiness{.properties = kSpecularGlossinessProperties};
constexpr P kScatterAnisotropy{.name = "scatterAnisotropy", .min = -1, .max = 1, .repair = kClamp};
// The draft has used several names.
constexpr P kScatterProperties[] = {
    {.name = "scatterStrengthFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "scatterStrengthTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "scatterFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "scatterTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "multiscatterColorFactor",
     .array = true,
     .min_items = 3,
     .max_items = 3,
     .min = 0,
     .max = 1,
     .repair = kClamp},
    {.name = "multiscatterColorTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    kScatterAnisotropy};
constexpr JsonSchema kScatter{.properties = kScatterProperties};
constexpr P kSheenProperties[] = {
    {.name = "sheenColorFactor", .array = true, .min_items = 3, .max_items = 3, .min = 0, .max = 1, .repair = kClamp},
    {.name = "sheenColorTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "sheenRoughnessFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "sheenRoughnessTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kSheen{.properties = kSheenProperties};
constexpr P kSpecularProperties[] = {
    {.name = "specularFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "specularTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    {.name = "specularColorFactor", .array = true, .min_items = 3, .max_items = 3, .min = 0, .repair = kClamp},
    {.name = "specularColorTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kSpecular{.properties = kSpecularProperties};
constexpr P kTransmissionProperties[] = {
    {.name = "transmissionFactor", .min = 0, .max = 1, .repair = kClamp},
    {.name = "transmissionTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore}};
constexpr JsonSchema kTransmission{.properties = kTransmissionProperties};
constexpr JsonSchema kUnlit{};
constexpr P kVolumeProperties[] = {
    {.name = "thicknessFactor", .min = 0, .repair = kClamp},
    {.name = "thicknessTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    // The default is infinity, which JSON cannot express; values above FLT_MAX mean infinity.
    {.name = "attenuationDistance", .min = 0, .max = DBL_MAX, .repair = kClamp}, // 0: material_extensions.cpp
    {.name = "attenuationColor", .array = true, .min_items = 3, .max_items = 3, .min = 0, .max = 1, .repair = kClamp}};
constexpr JsonSchema kVolume{.properties = kVolumeProperties};
constexpr P kVolumeScatterProperties[] = {
    {.name = "multiscatterColor", .array = true, .min_items = 3, .max_items = 3, .min = 0, .max = 1, .repair = kClamp},
    {.name = "multiscatterColorFactor",
     .array = true,
     .min_items = 3,
     .max_items = 3,
     .min = 0,
     .max = 1,
     .repair = kClamp},
    kScatterAnisotropy};
constexpr JsonSchema kVolumeScatter{.properties = kVolumeScatterProperties};
constexpr E kMaterialExtensions[] = {{"KHR_materials_anisotropy", &kAnisotropy, kIgnore},
                                     {"KHR_materials_clearcoat", &kClearcoat, kIgnore},
                                     {"KHR_materials_diffuse_transmission", &kDiffuseTransmission, kIgnore},
                                     {"KHR_materials_dispersion", &kDispersion, kIgnore},
                                     {"KHR_materials_emissive_strength", &kEmissiveStrength, kIgnore},
                                     {"KHR_materials_ior", &kIor, kIgnore},
                                     {"KHR_materials_iridescence", &kIridescence, kIgnore},
                                     {"KHR_materials_pbrSpecularGlossiness", &kSpecularGlossiness, kIgnore},
                                     {"KHR_materials_scatter", &kScatter, kIgnore},
                                     {"KHR_materials_sheen", &kSheen, kIgnore},
                                     {"KHR_materials_specular", &kSpecular, kIgnore},
                                     {"KHR_materials_transmission", &kTransmission, kIgnore},
                                     {"KHR_materials_unlit", &kUnlit, kIgnore},
                                     {"KHR_materials_volume", &kVolume, kIgnore},
                                     {"KHR_materials_volume_scatter", &kVolumeScatter, kIgnore}};
constexpr P kMaterialProperties[] = {
    kName,
    {.name = "pbrMetallicRoughness", .kind = K::object, .schema = &kMetallicRoughness, .repair = kIgnore},
    {.name = "normalTexture", .kind = K::object, .schema = &kNormalTexture, .repair = kIgnore},
    {.name = "occlusionTexture", .kind = K::object, .schema = &kOcclusionTexture, .repair = kIgnore},
    {.name = "emissiveTexture", .kind = K::object, .schema = &kTextureInfo, .repair = kIgnore},
    // Values above 1 violate the specification but have a clear meaning; materials.cpp warns of
    // them.
    {.name = "emissiveFactor", .array = true, .min_items = 3, .max_items = 3, .min = 0, .repair = kClamp},
    {.name = "alphaMode", .kind = K::choice, .choices = kAlphaModes, .repair = kIgnore},
    {.name = "alphaCutoff", .min = 0, .repair = kClamp},
    {.name = "doubleSided", .kind = K::boolean, .repair = kIgnore}};
constexpr JsonSchema kMaterial{.properties = kMaterialProperties, .extensions = kMaterialExtensions};

// An invalid source is a warning, like an unreadable image.
constexpr P kSource{.name = "source", .kind = K::index, .collection = "images", .soft = true};
constexpr P kOtherSourceProperties[] = {kSource};
constexpr JsonSchema kOtherSource{.properties = kOtherSourceProperties};
constexpr E kTextureExtensions[] = {{"EXT_texture_webp", &kOtherSource, kIgnore},
                                    {"KHR_texture_basisu", &kOtherSource, kIgnore}};
constexpr P kTextureProperties[] = {
    kName, {.name = "sampler", .kind = K::index, .collection = "samplers", .repair = kIgnore}, kSource};
constexpr JsonSchema kTexture{.properties = kTextureProperties, .extensions = kTextureExtensions};
constexpr P kSamplerProperties[] = {{.name = "magFilter", .kind = K::code, .codes = kMagFilters, .repair = kIgnore},
                                    {.name = "minFilter", .kind = K::code, .codes = kMinFilters, .repair = kIgnore},
                                    {.name = "wrapS", .kind = K::code, .codes = kWraps, .repair = kIgnore},
                                    {.name = "wrapT", .kind = K::code, .codes = kWraps, .repair = kIgnore}};
constexpr JsonSchema kSampler{.properties = kSamplerProperties};
constexpr P kImageProperties[] = {
    kName,
    {.name = "uri", .kind = K::string, .repair = kIgnore},
    {.name = "mimeType", .kind = K::string, .repair = kIgnore},
    {.name = "bufferView", .kind = K::index, .collection = "bufferViews", .repair = kIgnore}};
constexpr JsonSchema kImage{.properties = kImageProperties};

constexpr P kSpotProperties[] = {{.name = "innerConeAngle", .min = 0, .max = 1.5707963267948966, .repair = kClamp},
                                 {.name = "outerConeAngle",
                                  .min = 0,
                                  .max = 1.5707963267948966,
                                  .above_min = true,
                                  .repair = kClamp,
                                  .lenient_min = 0,
                                  .lenient_max = 0}};
constexpr JsonSchema kSpot{.properties = kSpotProperties};
constexpr P kLightProperties[] = {
    kName,
    {.name = "type", .kind = K::choice, .required = true, .choices = kLightTypes, .repair = kIgnore},
    {.name = "color",
     .array = true,
     .min_items = 3,
     .max_items = 3,
     .min = 0,
     .max = 1,
     .repair = kClamp,
     .lenient_min = 1,
     .lenient_max = FLT_MAX},
    {.name = "intensity", .min = 0, .repair = kClamp},
    {.name = "range", .min = 0, .above_min = true, .repair = kIgnore},
    {.name = "spot", .kind = K::object, .schema = &kSpot, .repair = kIgnore}};
constexpr JsonSchema kLight{.properties = kLightProperties};
constexpr P kLightsProperties[] = {{.name = "lights",
                                    .kind = K::object,
                                    .required = true,
                                    .array = true,
                                    .schema = &kLight,
                                    .repair = JsonRepair::replace,
                                    .stand_in = R"({"type": "point", "intensity": 0})"}};
constexpr JsonSchema kLights{.properties = kLightsProperties};
constexpr P kVariantProperties[] = {
    {.name = "name", .kind = K::string, .required = true, .repair = kIgnore, .stand_in = "\"\""}};
constexpr JsonSchema kVariant{.properties = kVariantProperties};
constexpr P kVariantsProperties[] = {
    {.name = "variants", .kind = K::object, .required = true, .array = true, .schema = &kVariant}};
constexpr JsonSchema kVariants{.properties = kVariantsProperties};
// image_lights.cpp checks its nested arrays.
constexpr P kImageLightProperties[] = {kName,
                                       {.name = "rotation",
                                        .array = true,
                                        .min_items = 4,
                                        .max_items = 4,
                                        .min = -1,
                                        .max = 1,
                                        .lenient_min = -kFar,
                                        .lenient_max = kFar},
                                       {.name = "intensity", .min = 0, .repair = kClamp}};
constexpr JsonSchema kImageLight{.properties = kImageLightProperties};
constexpr P kImageLightsProperties[] = {
    {.name = "lights", .kind = K::object, .required = true, .array = true, .schema = &kImageLight}};
constexpr JsonSchema kImageLights{.properties = kImageLightsProperties};
constexpr P kPhotometryProperties[] = {kName,
                                       {.name = "uri", .kind = K::string},
                                       {.name = "bufferView", .kind = K::index, .collection = "bufferViews"},
                                       {.name = "mimeType", .kind = K::string}};
constexpr JsonSchema kPhotometry{.properties = kPhotometryProperties};
constexpr P kPhotometriesProperties[] = {
    {.name = "lights", .kind = K::object, .required = true, .array = true, .schema = &kPhotometry}};
constexpr JsonSchema kPhotometries{.properties = kPhotometriesProperties};
constexpr E kRootExtensions[] = {{"EXT_lights_ies", &kPhotometries, kIgnore},
                                 {"EXT_lights_image_based", &kImageLights, kIgnore},
                                 {"KHR_lights_punctual", &kLights, kIgnore},
                                 {"KHR_materials_variants", &kVariants, kIgnore}};

constexpr P kRootProperties[] = {
    {.name = "asset", .kind = K::object, .required = true, .schema = &kAsset},
    {.name = "extensionsUsed", .kind = K::string, .array = true, .core = false, .repair = kIgnore},
    {.name = "extensionsRequired", .kind = K::string, .array = true, .core = false},
    {.name = "buffers", .kind = K::object, .array = true, .schema = &kBuffer, .core = false},
    {.name = "bufferViews", .kind = K::object, .array = true, .schema = &kBufferView},
    {.name = "accessors",
     .kind = K::object,
     .array = true,
     .schema = &kAccessorSchema,
     .repair = JsonRepair::replace,
     .stand_in = R"({"componentType": 5126, "count": 0, "type": "SCALAR"})"},
    {.name = "images", .kind = K::object, .array = true, .schema = &kImage, .core = false},
    {.name = "samplers",
     .kind = K::object,
     .array = true,
     .schema = &kSampler,
     .repair = JsonRepair::replace,
     .stand_in = "{}"},
    {.name = "textures", .kind = K::object, .array = true, .schema = &kTexture},
    {.name = "materials", .kind = K::object, .array = true, .schema = &kMaterial},
    {.name = "meshes",
     .kind = K::object,
     .array = true,
     .schema = &kMesh,
     .repair = JsonRepair::replace,
     .stand_in = R"({"primitives": []})"},
    {.name = "skins",
     .kind = K::object,
     .array = true,
     .schema = &kSkin,
     .repair = JsonRepair::replace,
     .stand_in = R"({"joints": []})"},
    {.name = "cameras",
     .kind = K::object,
     .array = true,
     .schema = &kCameraSchema,
     .repair = JsonRepair::replace,
     .stand_in = R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 0}})"},
    {.name = "nodes", .kind = K::object, .array = true, .schema = &kNode},
    {.name = "scenes", .kind = K::object, .array = true, .schema = &kScene},
    {.name = "scene", .kind = K::index, .collection = "scenes", .repair = kIgnore},
    {.name = "animations",
     .kind = K::object,
     .array = true,
     .schema = &kAnimation,
     .repair = JsonRepair::replace,
     .stand_in = R"({"channels": [], "samplers": []})"}};

} // namespace

const JsonSchema kAccessorSchema{.properties = kAccessorProperties};
const JsonSchema kCameraSchema{.properties = kCameraProperties};
const JsonSchema kChannelTargetSchema{.properties = kTargetProperties, .extensions = kTargetExtensions};
const JsonSchema kGltfSchema{.properties = kRootProperties, .extensions = kRootExtensions};

} // namespace kindling::gltf
