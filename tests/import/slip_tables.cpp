// The changes of the corpus, by subject.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/slips.h"

#include <limits>

namespace kindling::test {
namespace {

constexpr std::string_view kIgnored = "; it is ignored";
constexpr std::string_view kUnchanged = "; it is used unchanged";
constexpr std::string_view kAbsent = "; it is read as absent";
constexpr std::string_view kRefused = {};

constexpr Slip kSlips[] = {
    // asset
    {"version as a number", "/asset/version", "2.0", "/asset/version: 2, expected a string", "; it is read as 2.0"},
    {"version without minor", "/asset/version", R"("2")", "PATTERN_MISMATCH", "; it is read as 2.0"},
    {"version with a patch", "/asset/version", R"("2.0.1")", "PATTERN_MISMATCH", "; it is read as 2.0"},
    {"version 1", "/asset/version", R"("1.0")", "convert it with gltf-pipeline", kRefused},
    {"version 3", "/asset/version", R"("3.0")", "UNKNOWN_ASSET_MAJOR_VERSION", kRefused},
    {"minimum version 2.1", "/asset/minVersion", R"("2.1")", "UNKNOWN_ASSET_MAJOR_VERSION", "; it is read as 2.0"},
    {"minimum version 3.0", "/asset/minVersion", R"("3.0")", "UNKNOWN_ASSET_MAJOR_VERSION", kRefused},
    {"no version", "/asset/version", "", "'version' is missing", kRefused},
    {"no asset", "/asset", "", "'asset' is missing", kRefused},
    {"generator is null", "/asset/generator", "null", "/asset/generator: null", kAbsent},
    {"copyright is a number", "/asset/copyright", "2024", "/asset/copyright: 2024, expected a string", kIgnored},
    // buffers, views, accessors
    {"buffer longer than its data", "/buffers/0/byteLength", "100000", "BUFFER_BYTE_LENGTH_MISMATCH",
     "; these are read"},
    {"view of length 0", "/bufferViews/-", R"({"buffer": 0, "byteLength": 0})",
     "/bufferViews/14/byteLength: 0, expected 1 to", kUnchanged},
    {"view beyond its buffer", "/bufferViews/-", R"({"buffer": 0, "byteOffset": 8, "byteLength": 100000})",
     "BUFFER_VIEW_TOO_LONG", "; it ends with the buffer"},
    {"view that starts beyond its buffer", "/bufferViews/-", R"({"buffer": 0, "byteOffset": 90000, "byteLength": 10})",
     "BUFFER_VIEW_TOO_LONG", "; it ends with the buffer"},
    {"view of a missing buffer", "/bufferViews/0/buffer", "3", "UNRESOLVED_REFERENCE", kRefused},
    {"stride 0", "/bufferViews/0/byteStride", "0", "/bufferViews/0/byteStride: 0, expected 4 to 252", kIgnored},
    {"stride null", "/bufferViews/0/byteStride", "null", "/bufferViews/0/byteStride: null", kAbsent},
    {"stride beyond 252", "/bufferViews/13/byteStride", "256", "/bufferViews/13/byteStride: 256", kUnchanged},
    {"odd stride", "/bufferViews/4/byteStride", "2", "/bufferViews/4/byteStride: 2, expected 4 to 252", kUnchanged},
    {"stride that is no multiple of 4", "/bufferViews/13/byteStride", "6", "VALUE_MULTIPLE_OF", kUnchanged},
    {"stride below the element", "/bufferViews/0/byteStride", "8", "ACCESSOR_SMALL_BYTESTRIDE", kRefused},
    {"unused accessor of 0 elements", "/accessors/-",
     R"({"bufferView": 0, "componentType": 5126, "count": 0, "type": "VEC3"})", "/accessors/13/count: 0, expected 1 to",
     kUnchanged},
    {"unused accessor beyond its view", "/accessors/-",
     R"({"bufferView": 0, "componentType": 5126, "count": 900, "type": "VEC3"})", "ACCESSOR_TOO_LONG",
     "; the accessor is not read"},
    {"unused accessor without a type", "/accessors/-", R"({"componentType": 5126, "count": 3})",
     "/accessors/13: 'type' is missing", "; it has no effect"},
    {"unused accessor of a missing view", "/accessors/-",
     R"({"bufferView": 99, "componentType": 5126, "count": 3, "type": "VEC3"})", "UNRESOLVED_REFERENCE",
     "; it has no effect"},
    {"positions beyond their view", "/accessors/0/count", "4", "ACCESSOR_TOO_LONG", kRefused},
    {"positions of an unknown type", "/accessors/0/componentType", "5130", "VALUE_NOT_IN_LIST", kRefused},
    {"normalized floats", "/accessors/0/normalized", "true", "ACCESSOR_NORMALIZED_INVALID", kIgnored},
    {"normalized is text", "/accessors/0/normalized", R"("no")", "/accessors/0/normalized: 'no'", kIgnored},
    {"normalized indices", "/accessors/4/normalized", "true", "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
     "; 'normalized' is ignored"},
    {"sparse of 0 elements", "/accessors/0/sparse",
     R"({"count": 0, "indices": {"bufferView": 4, "componentType": 5123}, "values": {"bufferView": 0}})",
     "/accessors/0/sparse/count: 0, expected 1 to", kUnchanged},
    {"accessor without elements is used", "/accessors/4/count", "0", "/accessors/4/count: 0, expected 1 to",
     kUnchanged},
    // nodes and scenes
    {"root below another root", "/nodes/9/children", "[6]", "SCENE_NON_ROOT_NODE",
     "; it becomes a root, without the transform of its parent"},
    {"node listed twice by its scene", "/scenes/0/nodes/-", "0", "node 0 is listed twice", "; it is shown once"},
    {"child listed twice", "/nodes/4/children", "[5, 5]", "NODE_PARENT_OVERRIDE", "; it is listed once"},
    {"child of two nodes", "/nodes/9/children", "[5]", "NODE_PARENT_OVERRIDE", "; it is moved to this one"},
    {"loop of nodes", "/nodes/5/children", "[4]", "NODE_LOOP", kRefused},
    {"child that does not exist", "/nodes/4/children", "[77]", "UNRESOLVED_REFERENCE", kRefused},
    {"mesh that does not exist", "/nodes/0/mesh", "77", "UNRESOLVED_REFERENCE", kRefused},
    {"mesh -1", "/nodes/4/mesh", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"camera -1", "/nodes/4/camera", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"camera that does not exist", "/nodes/4/camera", "7", "UNRESOLVED_REFERENCE", kIgnored},
    {"camera null", "/nodes/4/camera", "null", "/nodes/4/camera: null", kAbsent},
    {"skin -1", "/nodes/0/skin", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"skin that does not exist", "/nodes/0/skin", "9", "UNRESOLVED_REFERENCE", kRefused},
    {"name is a number", "/nodes/0/name", "5", "/nodes/0/name: 5, expected a string", kIgnored},
    {"rotation of length 0", "/nodes/0/rotation", "[0, 0, 0, 0]", "ROTATION_NON_UNIT", "; the node is not rotated"},
    {"rotation of length 2", "/nodes/0/rotation", "[0, 0, 0, 2]", "/nodes/0/rotation/3: 2, expected", kUnchanged},
    {"rotation of three numbers", "/nodes/0/rotation", "[0, 0, 1]", "ARRAY_LENGTH_NOT_IN_LIST", kRefused},
    {"translation is text", "/nodes/0/translation", R"(["a", 0, 0])", "TYPE_MISMATCH", kRefused},
    {"matrix beside a translation", "/nodes/9/translation", "[0, 0, 0]", "NODE_MATRIX_TRS", "; the matrix is used"},
    {"matrix with a projection", "/nodes/9/matrix/3", "0.5", "NODE_MATRIX_NON_TRS", "; 0 is used"},
    {"matrix too short", "/nodes/9/matrix", "[1, 0, 0]", "ARRAY_LENGTH_NOT_IN_LIST", kRefused},
    {"too many weights", "/nodes/6/weights", "[0.5, 1, 1]", "NODE_WEIGHTS_INVALID",
     "; missing ones are 0, others are ignored"},
    {"weights without targets", "/nodes/0/weights", "[1]", "NODE_WEIGHTS_INVALID",
     "; missing ones are 0, others are ignored"},
    {"weights are text", "/nodes/6/weights", R"("all")", "/nodes/6/weights: 'all', expected an array", kIgnored},
    {"default scene that does not exist", "/scene", "4", "UNRESOLVED_REFERENCE", kIgnored},
    {"default scene -1", "/scene", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"scene with a missing node", "/scenes/0/nodes/-", "77", "UNRESOLVED_REFERENCE", kRefused},
    {"visibility is a number", "/nodes/0/extensions/KHR_node_visibility/visible", "1",
     "/nodes/0/extensions/KHR_node_visibility/visible: 1, expected true or false", kIgnored},
    // meshes
    {"mesh weights too many", "/meshes/2/weights", "[0, 1, 2]", "MESH_INVALID_WEIGHTS_COUNT",
     "; missing ones are 0, others are ignored"},
    {"unused mesh without primitives", "/meshes/-", "{}", "'primitives' is missing", "; it has no effect"},
    {"used mesh without primitives", "/meshes/0/primitives", "", "'primitives' is missing", kRefused},
    {"unused mesh with faulty positions", "/meshes/-", R"({"primitives": [{"attributes": {"POSITION": 2}}]})",
     "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", "; the primitive is not used"},
    {"positions of two components", "/meshes/0/primitives/0/attributes/POSITION", "2",
     "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", kRefused},
    {"normals of two components", "/meshes/0/primitives/0/attributes/NORMAL", "2", "NORMAL must be VEC3",
     "; NORMAL is ignored"},
    {"texture coordinates of three components", "/meshes/0/primitives/0/attributes/TEXCOORD_1", "0",
     "TEXCOORD_1 must be VEC2", "; TEXCOORD_1 is ignored"},
    {"colors of two components", "/meshes/0/primitives/0/attributes/COLOR_0", "2", "COLOR_0 must be",
     "; COLOR_0 is ignored"},
    {"too few normals", "/meshes/0/primitives/0/attributes/NORMAL", "9", "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
     "; NORMAL is ignored"},
    {"attribute of an application with too few elements", "/meshes/0/primitives/0/attributes/_ID", "8",
     "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", "; _ID is ignored"},
    {"joints without weights", "/meshes/1/primitives/0/attributes/WEIGHTS_0", "",
     "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", "; 0 are used"},
    {"more joints than weights", "/meshes/1/primitives/0/attributes/JOINTS_1", "5",
     "MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", "; 1 are used"},
    {"joints of floats", "/meshes/1/primitives/0/attributes/JOINTS_0", "6", "joints must be VEC4",
     "; they are read as integers"},
    {"joints of three components", "/meshes/1/primitives/0/attributes/JOINTS_0", "1", "joints must be VEC4", kRefused},
    {"indices -1", "/meshes/1/primitives/0/indices", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"indices that do not exist", "/meshes/0/primitives/0/indices", "99", "UNRESOLVED_REFERENCE", kRefused},
    {"indices of floats", "/meshes/0/primitives/0/indices", "8", "indices must be SCALAR", kRefused},
    {"material -1", "/meshes/0/primitives/0/material", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"material that does not exist", "/meshes/0/primitives/0/material", "12", "UNRESOLVED_REFERENCE", kRefused},
    {"mode that does not exist", "/meshes/0/primitives/0/mode", "9", "VALUE_NOT_IN_LIST", kRefused},
    {"target of another format", "/meshes/2/primitives/0/targets/0/POSITION", "2",
     "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", "; POSITION is ignored"},
    {"target with too few elements", "/meshes/2/primitives/0/targets/0/POSITION", "9",
     "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT", "; POSITION is ignored"},
    {"variants without mappings", "/meshes/0/primitives/0/extensions/KHR_materials_variants", "{}",
     "'mappings' is missing", kIgnored},
    {"list of variants missing", "/extensions/KHR_materials_variants", "{}", "'variants' is missing", kIgnored},
    {"variant without a name", "/extensions/KHR_materials_variants", R"({"variants": [{}]})", "'name' is missing",
     "is used"},
    // materials
    {"base color above 1", "/materials/0/pbrMetallicRoughness/baseColorFactor", "[1.2, 1, 1, 1]",
     "/materials/0/pbrMetallicRoughness/baseColorFactor/0: 1.2, expected a number from 0 to 1", "; 1 is used"},
    {"base color below 0", "/materials/0/pbrMetallicRoughness/baseColorFactor", "[1, -0.5, 1, 1]",
     "baseColorFactor/1: -0.5", "; 0 is used"},
    {"base color without alpha", "/materials/0/pbrMetallicRoughness/baseColorFactor", "[1, 0.5, 1]",
     "3 elements, expected 4", "; alpha is 1"},
    {"base color of five numbers", "/materials/0/pbrMetallicRoughness/baseColorFactor", "[1, 0.5, 1, 1, 1]",
     "5 elements, expected 4", "; the last ones are ignored"},
    {"base color of one number", "/materials/0/pbrMetallicRoughness/baseColorFactor", "[1]", "1 elements, expected 4",
     kIgnored},
    {"base color is text", "/materials/0/pbrMetallicRoughness/baseColorFactor", R"("white")", "TYPE_MISMATCH",
     kIgnored},
    {"base color with null", "/materials/0/pbrMetallicRoughness/baseColorFactor", "[1, null, 1, 1]", "TYPE_MISMATCH",
     kIgnored},
    {"metallic below 0", "/materials/0/pbrMetallicRoughness/metallicFactor", "-0.1", "-0.1, expected a number",
     "; 0 is used"},
    {"metallic above 1", "/materials/0/pbrMetallicRoughness/metallicFactor", "9", "9, expected a number",
     "; 1 is used"},
    {"metallic is null", "/materials/0/pbrMetallicRoughness/metallicFactor", "null", "metallicFactor: null", kAbsent},
    {"roughness is text", "/materials/0/pbrMetallicRoughness/roughnessFactor", R"("0.5")", "expected a number",
     kIgnored},
    {"roughness above 1", "/materials/0/pbrMetallicRoughness/roughnessFactor", "1.5", "1.5, expected a number",
     "; 1 is used"},
    {"alpha mode in lower case", "/materials/0/alphaMode", R"("mask")", "/materials/0/alphaMode: 'mask'",
     "; MASK is used"},
    {"unknown alpha mode", "/materials/0/alphaMode", R"("ADDITIVE")", "VALUE_NOT_IN_LIST", kIgnored},
    {"alpha cutoff below 0", "/materials/0/alphaCutoff", "-1", "-1, expected", "; 0 is used"},
    {"double sided is a number", "/materials/0/doubleSided", "1", "expected true or false", kIgnored},
    {"emission below 0", "/materials/0/emissiveFactor", "[-1, 0, 0]", "-1, expected", "; 0 is used"},
    {"texture that does not exist", "/materials/0/pbrMetallicRoughness/baseColorTexture/index", "7",
     "/materials/0/pbrMetallicRoughness/baseColorTexture/index: 7", kIgnored},
    {"texture without an index", "/materials/0/pbrMetallicRoughness/baseColorTexture/index", "", "'index' is missing",
     kIgnored},
    {"texture is null", "/materials/0/normalTexture", "null", "/materials/0/normalTexture: null", kAbsent},
    {"texture coordinates of set -1", "/materials/0/pbrMetallicRoughness/baseColorTexture/texCoord", "-1",
     "texCoord: -1", kIgnored},
    {"normal scale is text", "/materials/0/normalTexture", R"({"index": 0, "scale": "1"})", "scale: '1'", kIgnored},
    {"occlusion strength above 1", "/materials/0/occlusionTexture", R"({"index": 0, "strength": 2})", "2, expected",
     "; 1 is used"},
    {"texture transform of three numbers",
     "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/scale", "[1, 1, 1]",
     "3 elements, expected 2", "; the last ones are ignored"},
    {"texture transform is a list",
     "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform", "[1, 1]",
     "expected an object", kIgnored},
    {"anisotropy below 0", "/materials/1/extensions/KHR_materials_anisotropy/anisotropyStrength", "-0.5",
     "-0.5, expected", "; 0 is used"},
    {"clearcoat above 1", "/materials/1/extensions/KHR_materials_clearcoat/clearcoatFactor", "2", "2, expected",
     "; 1 is used"},
    {"diffuse transmission above 1",
     "/materials/1/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", "1.2", "1.2, expected",
     "; 1 is used"},
    {"dispersion below 0", "/materials/1/extensions/KHR_materials_dispersion/dispersion", "-1", "-1, expected",
     "; 0 is used"},
    {"emissive strength below 0", "/materials/1/extensions/KHR_materials_emissive_strength/emissiveStrength", "-0.5",
     "-0.5, expected", "; 0 is used"},
    {"index of refraction below 1", "/materials/1/extensions/KHR_materials_ior/ior", "0.5",
     "0.5, expected 0 or a number from 1", "; 1 is used"},
    {"index of refraction below 0", "/materials/1/extensions/KHR_materials_ior/ior", "-0.5", "-0.5, expected",
     "; 0 is used"},
    {"iridescence below 1", "/materials/1/extensions/KHR_materials_iridescence/iridescenceIor", "0.9", "0.9, expected",
     "; 1 is used"},
    {"sheen above 1", "/materials/1/extensions/KHR_materials_sheen/sheenColorFactor", "[2, 0, 0]", "2, expected",
     "; 1 is used"},
    {"specular below 0", "/materials/1/extensions/KHR_materials_specular/specularFactor", "-0.5", "-0.5, expected",
     "; 0 is used"},
    {"transmission above 1", "/materials/1/extensions/KHR_materials_transmission/transmissionFactor", "1.2",
     "1.2, expected", "; 1 is used"},
    {"thickness below 0", "/materials/1/extensions/KHR_materials_volume/thicknessFactor", "-1", "-1, expected",
     "; 0 is used"},
    {"attenuation color above 1", "/materials/1/extensions/KHR_materials_volume/attenuationColor", "[1, 1, 3]",
     "3, expected", "; 1 is used"},
    {"attenuation distance below 0", "/materials/1/extensions/KHR_materials_volume/attenuationDistance", "-1",
     "-1, expected", "; 0 is used"},
    {"glossiness above 1", "/materials/2/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", "1.1",
     "1.1, expected", "; 1 is used"},
    {"extensions are null", "/materials/1/extensions", "null", "/materials/1/extensions: null, expected an object",
     "; they are ignored"},
    {"extension object is null", "/materials/1/extensions/KHR_materials_sheen", "null", "expected an object", kIgnored},
    // textures
    {"sampler that does not exist", "/textures/0/sampler", "5", "UNRESOLVED_REFERENCE", kIgnored},
    {"sampler -1", "/textures/0/sampler", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"sampler is text", "/samplers/0", R"("linear")", "expected an object", "; it has no effect"},
    {"samplers are an object", "/samplers", "{}", "expected an array", kIgnored},
    {"unknown magnification filter", "/samplers/0/magFilter", "9987", "VALUE_NOT_IN_LIST", kIgnored},
    {"unknown minification filter", "/samplers/0/minFilter", "0", "VALUE_NOT_IN_LIST", kIgnored},
    {"unknown wrap", "/samplers/0/wrapS", "10496", "VALUE_NOT_IN_LIST", kIgnored},
    {"wrap is text", "/samplers/0/wrapT", R"("REPEAT")", "TYPE_MISMATCH", kIgnored},
    {"image of two sources", "/images/0/uri", R"("a.png")", "ONE_OF_MISMATCH", "; the bufferView is used"},
    {"MIME type is a number", "/images/0/mimeType", "1", "TYPE_MISMATCH", kIgnored},
    // cameras
    {"aspect ratio 0", "/cameras/0/perspective/aspectRatio", "0", "aspectRatio: 0, expected", kIgnored},
    {"aspect ratio null", "/cameras/0/perspective/aspectRatio", "null", "aspectRatio: null", kAbsent},
    {"near plane 0", "/cameras/0/perspective/znear", "0", "znear: 0, expected", kUnchanged},
    {"near plane below 0", "/cameras/0/perspective/znear", "-1", "znear: -1, expected", kUnchanged},
    {"no near plane", "/cameras/0/perspective/znear", "", "'znear' is missing", "; 0 is used"},
    {"near plane is text", "/cameras/0/perspective/znear", R"("0.1")", "znear: '0.1'", "; 0 is used"},
    {"far plane 0", "/cameras/0/perspective/zfar", "0", "zfar: 0, expected", kIgnored},
    {"far plane before the near plane", "/cameras/0/perspective/zfar", "0.05", "CAMERA_ZFAR_LEQUAL_ZNEAR",
     "; they are ignored"},
    {"field of view 0", "/cameras/0/perspective/yfov", "0", "/cameras/0/perspective/yfov: 0", "; it has no effect"},
    {"field of view of pi", "/cameras/0/perspective/yfov", "3.2", "CAMERA_YFOV_GEQUAL_PI", "; the camera is not used"},
    {"no field of view", "/cameras/0/perspective/yfov", "", "'yfov' is missing", "; it has no effect"},
    {"camera without its projection", "/cameras/0/perspective", "", "'perspective' is missing", "; it has no effect"},
    {"camera of no type", "/cameras/0/type", "", "'type' is missing", "; it has no effect"},
    {"camera type in capitals", "/cameras/0/type", R"("Perspective")", "VALUE_NOT_IN_LIST", "; perspective is used"},
    {"camera of an unknown type", "/cameras/0/type", R"("fisheye")", "VALUE_NOT_IN_LIST", "; it has no effect"},
    {"orthographic width 0", "/cameras/1/orthographic/xmag", "0", "CAMERA_XMAG_YMAG_ZERO", "; the camera is not used"},
    {"orthographic far plane missing", "/cameras/1/orthographic/zfar", "", "'zfar' is missing", "; 1e18 is used"},
    {"orthographic far plane 0", "/cameras/1/orthographic/zfar", "0", "zfar: 0, expected", "; 1e18 is used"},
    {"orthographic near plane below 0", "/cameras/1/orthographic/znear", "-5", "znear: -5, expected", kUnchanged},
    // lights
    {"light color above 1", "/extensions/KHR_lights_punctual/lights/0/color", "[2, 1, 1]", "color/0: 2, expected",
     kUnchanged},
    {"light color below 0", "/extensions/KHR_lights_punctual/lights/0/color", "[-2, 1, 1]", "color/0: -2, expected",
     "; 0 is used"},
    {"light color of four numbers", "/extensions/KHR_lights_punctual/lights/0/color", "[1, 1, 1, 1]",
     "4 elements, expected 3", "; the last ones are ignored"},
    {"intensity below 0", "/extensions/KHR_lights_punctual/lights/1/intensity", "-3", "intensity: -3, expected",
     "; 0 is used"},
    {"range 0", "/extensions/KHR_lights_punctual/lights/0/range", "0", "range: 0, expected", kIgnored},
    {"range null", "/extensions/KHR_lights_punctual/lights/0/range", "null", "range: null", kAbsent},
    {"equal cones", "/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle", "0.6",
     "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES", "; the cone has a sharp edge"},
    {"inner cone above the outer one", "/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle", "0.9",
     "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES", "; the cone has a sharp edge"},
    {"outer cone beyond a half sphere", "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", "3.14",
     "outerConeAngle: 3.14, expected", "is used"},
    {"spot light without angles", "/extensions/KHR_lights_punctual/lights/0/spot", "", "a spot light without 'spot'",
     "; it has default angles"},
    {"light of an unknown type", "/extensions/KHR_lights_punctual/lights/0/type", R"("area")", "VALUE_NOT_IN_LIST",
     "; it has no effect"},
    {"light of no type", "/extensions/KHR_lights_punctual/lights/0/type", "", "'type' is missing",
     "; it has no effect"},
    {"light type in capitals", "/extensions/KHR_lights_punctual/lights/1/type", R"("POINT")", "VALUE_NOT_IN_LIST",
     "; point is used"},
    {"light that does not exist", "/nodes/2/extensions/KHR_lights_punctual/light", "9", "UNRESOLVED_REFERENCE",
     "; the node has no light"},
    {"node with no light", "/nodes/2/extensions/KHR_lights_punctual", "{}", "'light' is missing", kIgnored},
    // skins
    {"skeleton -1", "/skins/0/skeleton", "-1", "UNRESOLVED_REFERENCE", kAbsent},
    {"skeleton that does not exist", "/skins/0/skeleton", "88", "UNRESOLVED_REFERENCE", kIgnored},
    {"joint listed twice", "/skins/0/joints", "[4, 4]", "DUPLICATE_ELEMENTS", "; both joints follow it"},
    {"joint that does not exist", "/skins/0/joints", "[4, 88]", "UNRESOLVED_REFERENCE", kRefused},
    {"used skin without joints", "/skins/0/joints", "[]", "EMPTY_ENTITY", kRefused},
    {"unused skin without joints", "/skins/-", R"({"joints": []})", "EMPTY_ENTITY", "; it has no effect"},
    {"unused skin with faulty matrices", "/skins/-", R"({"joints": [4], "inverseBindMatrices": 0})",
     "SKIN_IBM_INVALID_FORMAT", "; the skin is not used"},
    {"too few inverse bind matrices", "/accessors/7/count", "1", "INVALID_IBM_ACCESSOR_COUNT", kRefused},
    // animations
    {"animations are an object", "/animations", "{}", "expected an array", kIgnored},
    {"animation without channels", "/animations/0/channels", "", "'channels' is missing", "; it has no effect"},
    {"channel without a target", "/animations/0/channels/0/target", "", "'target' is missing",
     "; the element is ignored"},
    {"channel without a path", "/animations/0/channels/0/target/path", "", "'path' is missing",
     "; the element is ignored"},
    {"channel of a missing node", "/animations/0/channels/0/target/node", "55", "UNRESOLVED_REFERENCE",
     "; the element is ignored"},
    {"channel of a missing sampler", "/animations/0/channels/0/sampler", "5", "the animation has 3 samplers",
     "; the channel is ignored"},
    {"channel of sampler -1", "/animations/0/channels/0/sampler", "-1", "VALUE_NOT_IN_RANGE",
     "; the element is ignored"},
    {"channel of a node with a matrix", "/animations/0/channels/0/target/node", "9",
     "ANIMATION_CHANNEL_TARGET_NODE_MATRIX", "; the matrix is split into these"},
    {"weights of a node without targets", "/animations/0/channels/1/target/node", "0",
     "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS", "; the channel is ignored"},
    {"sampler without input", "/animations/0/samplers/0/input", "", "'input' is missing", "; it has no effect"},
    {"sampler of a missing accessor", "/animations/0/samplers/0/output", "77", "UNRESOLVED_REFERENCE",
     "; it has no effect"},
    {"interpolation in lower case", "/animations/0/samplers/0/interpolation", R"("step")", "VALUE_NOT_IN_LIST",
     "; STEP is used"},
    {"unknown interpolation", "/animations/0/samplers/0/interpolation", R"("BEZIER")", "VALUE_NOT_IN_LIST", kIgnored},
    {"values of another format", "/animations/0/samplers/0/output", "11",
     "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT", "; the channel is ignored"},
    {"times that are no numbers", "/animations/0/samplers/0/input", "4",
     "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT", "; the channel is ignored"},
    {"more values than keys", "/animations/0/samplers/0/output", "0", "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
     "; the first ones are used"},
    {"fewer values than keys", "/accessors/9/count", "1", "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
     "; the channel is ignored"},
    {"animated accessor beyond its view", "/accessors/9/count", "90", "ACCESSOR_TOO_LONG",
     "; the accessor is not read"},
    // extensions
    {"metadata required", "/extensionsRequired", R"(["EXT_structural_metadata"])", "EXT_structural_metadata",
     "although the file requires it (metadata)"},
    {"mesh features required", "/extensionsRequired", R"(["EXT_mesh_features"])", "EXT_mesh_features",
     "although the file requires it (metadata)"},
    {"levels of detail required", "/extensionsRequired", R"(["MSFT_lod"])", "MSFT_lod",
     "although the file requires it (the most detailed level is rendered)"},
    {"sounds required", "/extensionsRequired", R"(["KHR_audio_emitter"])", "KHR_audio_emitter",
     "although the file requires it (sounds)"},
    {"physics required", "/extensionsRequired", R"(["KHR_physics_rigid_bodies"])", "KHR_physics_rigid_bodies",
     "although the file requires it (physics)"},
    {"avatar required", "/extensionsRequired", R"(["VRM"])", "VRM", "although the file requires it (avatars"},
    {"avatar 1.0 required", "/extensionsRequired", R"(["VRMC_vrm"])", "VRMC_vrm",
     "although the file requires it (avatars"},
    {"articulations required", "/extensionsRequired", R"(["AGI_articulations"])", "AGI_articulations",
     "although the file requires it (articulations"},
    {"draft of a material required", "/extensionsRequired", R"(["KHR_materials_coat"])", "KHR_materials_coat",
     "although the file requires it (looks of materials"},
    {"Gaussian splats required", "/extensionsRequired", R"(["KHR_gaussian_splatting_compression_spz"])",
     "(Gaussian splats) is not supported; convert it with", kRefused},
    {"unknown extension required", "/extensionsRequired", R"(["ACME_hologram"])", "is required but not supported",
     kRefused},
    {"list of used extensions is text", "/extensionsUsed", R"("KHR_lights_punctual")", "expected an array", kIgnored},
    {"image-based light without coefficients", "/extensions/EXT_lights_image_based", R"({"lights": [{}]})",
     "no 'irradianceCoefficients'", "; the light is not used"},
    {"light profile without a source", "/extensions/EXT_lights_ies", R"({"lights": [{}]})",
     "neither uri nor bufferView", "; its lights are dark"},
    {"node with a missing light profile", "/nodes/0/extensions/EXT_lights_ies", R"({"light": 3})",
     "the file has 0 light profiles", "; the node has no light"},
};

json& slip_sampler(GltfBuilder& b, int index) {
  return b.root["animations"][0]["samplers"][static_cast<size_t>(index)];
}

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();

constexpr DataSlip kDataSlips[] = {
    {"repeated times",
     [](GltfBuilder& b) {
       slip_sampler(b, 0)["input"] = b.accessor<float>({1, 1}, kFloat, "SCALAR");
     },
     "ACCESSOR_ANIMATION_INPUT_NON_INCREASING", "; the value jumps there"},
    {"decreasing times",
     [](GltfBuilder& b) {
       slip_sampler(b, 0)["input"] = b.accessor<float>({1, 0}, kFloat, "SCALAR");
     },
     "ACCESSOR_ANIMATION_INPUT_NON_INCREASING", "; the channel is ignored"},
    {"negative times",
     [](GltfBuilder& b) {
       slip_sampler(b, 0)["input"] = b.accessor<float>({-1, 1}, kFloat, "SCALAR");
     },
     "ACCESSOR_ANIMATION_INPUT_NEGATIVE", "; it is used"},
    {"times that are not finite",
     [](GltfBuilder& b) {
       slip_sampler(b, 0)["input"] = b.accessor<float>({0, kNotANumber}, kFloat, "SCALAR");
     },
     "a time that is not finite", "; the channel is ignored"},
    {"no times",
     [](GltfBuilder& b) {
       slip_sampler(b, 0)["input"] = b.accessor<float>({}, kFloat, "SCALAR");
       b.root["bufferViews"].back()["byteLength"] = 4; // the accessor alone is empty
       b.bin += std::string(4, '\0');
     },
     "/accessors/13/count: 0", "; it is used unchanged"},
    {"values that are not finite",
     [](GltfBuilder& b) {
       slip_sampler(b, 0)["output"] = b.accessor<float>({0, kInfinite, 0, 0, 0, 0}, kFloat, "VEC3");
     },
     "a value that is not finite", "; the channel is ignored"},
    {"quaternion of length 0",
     [](GltfBuilder& b) {
       slip_sampler(b, 2)["output"] = b.accessor<float>({0, 0, 0, 1, 0, 0, 0, 0}, kFloat, "VEC4");
     },
     "quaternion 1 has length 0", "; the channel is ignored"},
    {"quaternion that is not finite",
     [](GltfBuilder& b) {
       slip_sampler(b, 2)["output"] = b.accessor<float>({0, 0, 0, 1, kNotANumber, 0, 0, 0}, kFloat, "VEC4");
     },
     "a value that is not finite", "; the channel is ignored"},
    {"one key of a spline",
     [](GltfBuilder& b) {
       slip_sampler(b, 0) = {{"input", b.accessor<float>({0}, kFloat, "SCALAR")}, {"output", 0}};
       slip_sampler(b, 0)["interpolation"] = "CUBICSPLINE";
     },
     "1 key with CUBICSPLINE", "; its value is constant"},
    {"position that is not finite",
     [](GltfBuilder& b) {
       json& primitive = b.root["meshes"][2]["primitives"][0];
       primitive["attributes"]["POSITION"] =
           b.accessor<float>({kNotANumber, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3");
       primitive["indices"] = b.accessor<uint16_t>({0, 1, 2, 1, 2, 3}, kUnsignedShort, "SCALAR");
       primitive.erase("targets");
       b.root["meshes"][2].erase("weights");
       b.root["nodes"][6].erase("weights");
       b.root["animations"][0]["channels"].erase(1);
     },
     "vertex (nan, 0, 0), expected finite numbers", "; its triangles are not rendered"},
    {"index beyond the vertices",
     [](GltfBuilder& b) {
       b.root["meshes"][0]["primitives"][0]["indices"] =
           b.accessor<uint16_t>({0, 1, 2, 0, 1, 7}, kUnsignedShort, "SCALAR");
     },
     "index 7 at 5, there are 3 vertices", "; its triangles are not rendered"},
    {"weight that is not finite",
     [](GltfBuilder& b) {
       b.root["meshes"][1]["primitives"][0]["attributes"]["WEIGHTS_0"] =
           b.accessor<float>({kNotANumber, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kFloat, "VEC4");
     },
     "a weight that is not finite", "; 0 is used"},
    {"joint beyond the skin",
     [](GltfBuilder& b) {
       b.root["meshes"][1]["primitives"][0]["attributes"]["JOINTS_0"] =
           b.accessor<uint8_t>({0, 9, 0, 0, 1, 0, 0, 0, 200, 0, 0, 0}, kUnsignedByte, "VEC4");
       b.root["meshes"][1]["primitives"][0]["attributes"]["WEIGHTS_0"] =
           b.accessor<float>({.5f, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kFloat, "VEC4");
     },
     "ACCESSOR_JOINTS_INDEX_OOB", "; its weight is ignored"},
    {"joints of 32 bits",
     [](GltfBuilder& b) {
       b.root["meshes"][1]["primitives"][0]["attributes"]["JOINTS_0"] =
           b.accessor<uint32_t>({0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kUnsignedInt, "VEC4");
     },
     "joints must be VEC4", "; they are read as integers"},
    {"delta that is not finite",
     [](GltfBuilder& b) {
       b.root["meshes"][2]["primitives"][0]["targets"][0]["POSITION"] =
           b.accessor<float>({0, 0, kNotANumber, 0, 0, 0, 0, 0, 0}, kFloat, "VEC3");
     },
     "a value that is not finite", "; the target is ignored"},
    {"more normals than positions",
     [](GltfBuilder& b) {
       b.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
           b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3");
     },
     "4 elements, POSITION has 3", "; the first ones are used"},
    {"primitives with unequal targets",
     [](GltfBuilder& b) {
       b.root["meshes"][2]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}});
     },
     "MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT", "; each uses its own"},
    {"many roughness values beyond 1",
     [](GltfBuilder& b) {
       for (int i = 0; i < 50; ++i) b.push("materials", {{"pbrMetallicRoughness", {{"roughnessFactor", 2}}}});
     },
     "/materials/3/pbrMetallicRoughness/roughnessFactor: 2", "; 1 is used [and 49 more like it]"},
    {"empty view and empty accessor that a primitive uses",
     [](GltfBuilder& b) {
       b.root["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 4}});
       b.push("accessors", {{"bufferView", 14}, {"componentType", kFloat}, {"count", 0}, {"type", "VEC3"}});
       b.root["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 13}}}});
     },
     "/accessors/13/count: 0", "; it is used unchanged"},
    {"animation pointer without text",
     [](GltfBuilder& b) {
       b.root["extensionsUsed"].push_back("KHR_animation_pointer");
       json& target = b.root["animations"][0]["channels"][0]["target"];
       target = {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", json::object()}}}};
     },
     "'pointer' is missing", "; the element is ignored"},
};

void set_u32(std::string& bytes, size_t at, size_t value) {
  const auto number = static_cast<uint32_t>(value);
  std::memcpy(&bytes[at], &number, sizeof number);
}
size_t u32(const std::string& bytes, size_t at) {
  uint32_t number = 0;
  std::memcpy(&number, &bytes[at], sizeof number);
  return number;
}
size_t bin_header(const std::string& bytes) { return 20 + u32(bytes, 12); }

constexpr ContainerSlip kContainerSlips[] = {
    {"length above the file", [](std::string& b) { set_u32(b, 8, b.size() + 4); }, "GLB_LENGTH_MISMATCH",
     "; these are read"},
    {"BIN chunk longer than the file", [](std::string& b) { set_u32(b, bin_header(b), u32(b, bin_header(b)) + 8); },
     "GLB_CHUNK_TOO_BIG", "; what the file has is read"},
    {"length without the header", [](std::string& b) { set_u32(b, 8, b.size() - 12); }, "GLB_CHUNK_TOO_BIG",
     "; what the file has is read"},
    {"name in Latin-1", [](std::string& b) { b[b.find("first")] = '\xe9'; }, "ill-formed UTF-8 byte",
     "; bytes that are not UTF-8 are replaced"},
    {"number that overflows",
     [](std::string& b) {
       b.insert(21, R"("extras":-1e309,)"); // 16 bytes, after the first brace
       set_u32(b, 12, u32(b, 12) + 16);
       set_u32(b, 8, b.size());
     },
     "number overflow parsing '-1e309'", "; the largest number is used"},
    {"half of a chunk header at the end",
     [](std::string& b) {
       b += std::string(4, '\0');
       set_u32(b, 8, b.size());
     },
     "GLB_UNEXPECTED_END_OF_CHUNK_HEADER", "; they are ignored"},
    {"BIN chunk after another one",
     [](std::string& b) {
       b.insert(bin_header(b), std::string("\0\0\0\0ABCD", 8));
       set_u32(b, 8, b.size());
     },
     "GLB_UNEXPECTED_BIN_CHUNK", "; it is read"},
    {"JSON chunk cut off", [](std::string& b) { b.resize(400); }, "declares ", kRefused},
    {"version 1", [](std::string& b) { set_u32(b, 4, 1); }, "convert it with gltf-pipeline", kRefused},
    {"another signature", [](std::string& b) { b[0] = 'x'; }, "GLB_INVALID_MAGIC", kRefused},
    {"header alone", [](std::string& b) { b.resize(12); }, "GLB_LENGTH", kRefused},
    {"BIN chunk first", [](std::string& b) { set_u32(b, 16, 0x004e4942U); }, "GLB_UNEXPECTED_FIRST_CHUNK", kRefused},
    {"two JSON chunks", [](std::string& b) { set_u32(b, bin_header(b) + 4, 0x4e4f534aU); }, "GLB_DUPLICATE_CHUNK",
     kRefused},
};

} // namespace

std::span<const Slip> slips() { return kSlips; }
std::span<const DataSlip> data_slips() { return kDataSlips; }
std::span<const ContainerSlip> container_slips() { return kContainerSlips; }

} // namespace kindling::test
