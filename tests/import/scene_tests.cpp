// The node tree, scenes, cameras, lights, skins, instances, animations.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling::test {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

Loaded with_nodes(json nodes, json scenes = {}) {
  GltfBuilder builder;
  builder.root["nodes"] = std::move(nodes);
  if (!scenes.is_null()) builder.root["scenes"] = std::move(scenes);
  return load(builder);
}

TEST(Nodes, ReadsTransforms) {
  const Loaded loaded = with_nodes(json::parse(R"([
    {"name": "trs", "translation": [1, 2, 3], "rotation": [0, 0, 0.70710678, 0.70710678], "scale": [2, -1, 0]},
    {"matrix": [1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1]}, {}])"));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const Node& trs = loaded.scene->nodes[0];
  EXPECT_EQ(trs.name, "trs");
  EXPECT_EQ(trs.local.translation, V3f(1, 2, 3));
  EXPECT_EQ(trs.local.scale, V3f(2, -1, 0));
  EXPECT_NEAR(trs.local.rotation.r, std::sqrt(0.5f), 1e-6f);
  EXPECT_NEAR(trs.local.rotation.v.z, std::sqrt(0.5f), 1e-6f);
  ASSERT_TRUE(loaded.scene->nodes[1].matrix);
  EXPECT_EQ(transform_point(*loaded.scene->nodes[1].matrix, V3f(1, 1, 1)), V3f(5, 7, 9));
  EXPECT_FALSE(loaded.scene->nodes[2].matrix);
}

TEST(Nodes, RefusesInvalidTransforms) {
  EXPECT_TRUE(contains(with_nodes(json::parse(R"([{"rotation": [0, 0, 0, 0]}])")).error, "ROTATION_NON_UNIT"));
  EXPECT_TRUE(contains(with_nodes(json::parse(R"([{"translation": [0, 1e30, 0]}])")).error,
                       "/nodes/0/translation/1: 1e+30, expected"));
  EXPECT_TRUE(
      contains(with_nodes(json::parse(R"([{"scale": [1, 1]}])")).error, "/nodes/0/scale: 2 elements, expected 3"));
  EXPECT_TRUE(contains(with_nodes(json::parse(R"([{"matrix": [1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1]}])")).error,
                       "/nodes/0/matrix: element 3"));
  EXPECT_TRUE(
      contains(with_nodes(json::parse(R"([{"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], "scale": [1,1,1]}])")).error,
               "NODE_MATRIX_TRS"));
  // A slightly wrong length is normalized.
  EXPECT_NEAR(with_nodes(json::parse(R"([{"rotation": [0, 0, 0, 0.9]}])")).scene->nodes[0].local.rotation.r, 1.0f,
              1e-6f);
}

TEST(Nodes, RefusesLoopsAndSecondParents) {
  EXPECT_EQ(with_nodes(json::parse(R"([{"children": [1]}, {"children": [0]}])")).error,
            "/nodes/0: the node is part of a loop, or below one (NODE_LOOP)");
  EXPECT_TRUE(contains(with_nodes(json::parse(R"([{"children": [0]}])")).error, "NODE_LOOP"));
  EXPECT_EQ(with_nodes(json::parse(R"([{"children": [2]}, {"children": [2]}, {}])")).error,
            "/nodes/1/children/0: node 2 is a child of node 0 already (NODE_PARENT_OVERRIDE)");
  EXPECT_TRUE(contains(with_nodes(json::parse(R"([{"children": [1, 1]}, {}])")).error, "NODE_PARENT_OVERRIDE"));
  EXPECT_EQ(with_nodes(json::parse(R"([{"children": [1]}])")).error,
            "/nodes/0/children/0: 1, expected an index of nodes, 0 to 0 (UNRESOLVED_REFERENCE)");
  EXPECT_TRUE(contains(with_nodes(json::parse(R"([{"children": [1]}, {}])"), json::parse(R"([{"nodes": [1]}])")).error,
                       "SCENE_NON_ROOT_NODE"));
}

TEST(Nodes, RefusesDeepTrees) {
  const auto chain = [](int length) {
    json nodes = json::array();
    for (int i = 0; i + 1 < length; ++i) nodes.push_back({{"children", {i + 1}}});
    nodes.push_back(json::object());
    return with_nodes(std::move(nodes)).error;
  };
  EXPECT_EQ(chain(1024), "");
  EXPECT_TRUE(contains(chain(1025), "more than 1024 levels"));
}

TEST(Scenes, ReadsAllAndTheDefault) {
  GltfBuilder builder;
  builder.root["nodes"] = json::parse(R"([{}, {"children": [2]}, {}])");
  builder.root["scenes"] = json::parse(R"([{"name": "a", "nodes": [0]}, {"nodes": [0, 1]}, {}])");
  builder.root["scene"] = 1;
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  ASSERT_EQ(loaded.scene->scenes.size(), 3U);
  EXPECT_EQ(loaded.scene->scenes[0].name, "a");
  EXPECT_EQ(loaded.scene->scenes[1].nodes, (std::vector<int>{0, 1}));
  EXPECT_EQ(loaded.scene->default_scene, 1);
  builder.root["scene"] = 3;
  EXPECT_TRUE(contains(load(builder).error, "/scene: 3, expected an index of scenes, 0 to 2"));
}

TEST(Scenes, FileWithoutScenesGetsOne) {
  const Loaded loaded = with_nodes(json::parse(R"([{"children": [1]}, {}, {}])"));
  ASSERT_EQ(loaded.scene->scenes.size(), 1U);
  EXPECT_EQ(loaded.scene->scenes[0].nodes, (std::vector<int>{0, 2}));
}

Loaded with_camera(std::string_view text) {
  GltfBuilder builder;
  builder.root["cameras"] = json::array({json::parse(text)});
  return load(builder);
}

TEST(Cameras, ReadsPerspectiveAndOrthographic) {
  Loaded loaded = with_camera(
      R"({"type": "perspective", "name": "c", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 1.5}})");
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->cameras[0].kind, SceneCamera::Kind::perspective);
  EXPECT_EQ(loaded.scene->cameras[0].name, "c");
  EXPECT_FLOAT_EQ(loaded.scene->cameras[0].yfov_rad, 0.5f);
  EXPECT_FLOAT_EQ(loaded.scene->cameras[0].aspect_ratio.value(), 1.5f);
  EXPECT_FLOAT_EQ(loaded.scene->cameras[0].znear, 0.1f);
  EXPECT_TRUE(std::isinf(loaded.scene->cameras[0].zfar));
  loaded = with_camera(R"({"type": "orthographic", "orthographic": {"xmag": 2, "ymag": -3, "znear": 0, "zfar": 9}})");
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->cameras[0].kind, SceneCamera::Kind::orthographic);
  EXPECT_FLOAT_EQ(loaded.scene->cameras[0].xmag, 2.0f);
  EXPECT_FLOAT_EQ(loaded.scene->cameras[0].ymag, 3.0f);
  EXPECT_FLOAT_EQ(loaded.scene->cameras[0].zfar, 9.0f);
}

TEST(Cameras, RefusesInvalidProjections) {
  EXPECT_TRUE(contains(with_camera(R"({"type": "perspective", "perspective": {"yfov": 0, "znear": 1}})").error,
                       "/cameras/0/perspective/yfov: 0, expected a finite number above 0"));
  EXPECT_TRUE(contains(with_camera(R"({"type": "perspective", "perspective": {"yfov": 4, "znear": 1}})").error,
                       "CAMERA_YFOV_GEQUAL_PI"));
  EXPECT_TRUE(
      contains(with_camera(R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 1, "zfar": 1}})").error,
               "CAMERA_ZFAR_LEQUAL_ZNEAR"));
  EXPECT_TRUE(contains(
      with_camera(R"({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1, "znear": 0, "zfar": 1}})").error,
      "CAMERA_XMAG_YMAG_ZERO"));
  EXPECT_FALSE(with_camera(R"({"type": "perspective"})").scene);
  EXPECT_FALSE(with_camera(R"({"type": "fisheye"})").scene);
}

Loaded with_light(std::string_view text, int used = 0) {
  GltfBuilder builder;
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = json::array({json::parse(text)});
  builder.root_node({{"extensions", {{"KHR_lights_punctual", {{"light", used}}}}}});
  return load(builder);
}

TEST(Lights, ReadsEveryKind) {
  Loaded loaded = with_light(
      R"({"type": "spot", "name": "s", "color": [1, 0.5, 0], "intensity": 20, "range": 5, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}})");
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const PunctualLight& spot = loaded.scene->lights[0];
  EXPECT_EQ(spot.kind, PunctualLight::Kind::spot);
  EXPECT_EQ(spot.color, Rgb(1, 0.5f, 0));
  EXPECT_EQ(spot.intensity, 20.0f);
  EXPECT_EQ(spot.range_m.value(), 5.0f);
  EXPECT_FLOAT_EQ(spot.inner_cone_rad, 0.1f);
  EXPECT_FLOAT_EQ(spot.outer_cone_rad, 0.2f);
  EXPECT_EQ(loaded.scene->nodes[0].light, 0);
  EXPECT_EQ(with_light(R"({"type": "point"})").scene->lights[0].kind, PunctualLight::Kind::point);
  EXPECT_EQ(with_light(R"({"type": "directional"})").scene->lights[0].kind, PunctualLight::Kind::directional);
}

TEST(Lights, RefusesInvalidLights) {
  EXPECT_EQ(with_light(R"({"type": "point"})", 1).error,
            "/nodes/0/extensions/KHR_lights_punctual/light: 1, the file has 1 lights (UNRESOLVED_REFERENCE)");
  EXPECT_TRUE(contains(with_light(R"({"type": "point", "intensity": -1})").error, "VALUE_NOT_IN_RANGE"));
  EXPECT_TRUE(contains(with_light(R"({"type": "spot"})").error, "a spot light without 'spot'"));
  EXPECT_TRUE(contains(with_light(R"({"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.2}})").error,
                       "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES"));
}

// Returns a skinned triangle whose vertices follow joint 1 of two.
GltfBuilder skinned() {
  GltfBuilder builder = triangle();
  json& attributes = builder.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = builder.accessor<uint8_t>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kUnsignedByte, "VEC4");
  attributes["WEIGHTS_0"] = builder.accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kFloat, "VEC4");
  builder.root["nodes"][0]["skin"] = 0;
  const int a = builder.root_node(json::object());
  const int b = builder.root_node(json::object());
  std::vector<float> matrices;
  for (int m = 0; m < 2; ++m) {
    for (int i = 0; i < 16; ++i) matrices.push_back(i % 5 == 0 ? 1.0f : i == 12 ? static_cast<float>(m) : 0.0f);
  }
  builder.push("skins", {{"joints", {a, b}}, {"inverseBindMatrices", builder.accessor(matrices, kFloat, "MAT4")}});
  return builder;
}

TEST(Skins, ReadsJointsAndMatrices) {
  const Loaded loaded = load(skinned());
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->nodes[0].skin, 0);
  EXPECT_EQ(loaded.scene->skins[0].joints, (std::vector<int>{1, 2}));
  EXPECT_EQ(loaded.scene->skins[0].inverse_bind_matrices[1][3][0], 1.0f);
  GltfBuilder without = skinned();
  without.root["skins"][0].erase("inverseBindMatrices");
  EXPECT_EQ(load(without).scene->skins[0].inverse_bind_matrices, std::vector<M44f>(2));
}

// Vertex 0 follows joints 0 and 7 in equal parts, vertex 1 joint 9 alone, vertex 2 joint 1: without
// joints 7 and 9 that is joint 0, joint 0 and joint 1.
TEST(Skins, IgnoreWeightsOfJointsBeyondTheSkin) {
  GltfBuilder builder = skinned();
  builder.root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] =
      builder.accessor<float>({0, 7.9f, 0, 0, 9, -4, 0, 0, 1.5f, 1e9f, 0, 0}, kFloat, "VEC4");
  builder.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] =
      builder.accessor<float>({.5f, .5f, 0, 0, 1, 0, 0, 0, .25f, .75f, 0, 0}, kFloat, "VEC4");
  const Loaded loaded = load(builder, kLenient);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warned("joints must be VEC4"));
  EXPECT_TRUE(loaded.warned("/nodes/0/skin: a vertex of mesh 0 uses joint 65535, skin 0 has 2"));
  const Primitive& primitive = loaded.scene->meshes[0].primitives[0];
  ASSERT_EQ(primitive.joints.size(), 3U);
  for (size_t v = 0; v < 3; ++v) {
    EXPECT_EQ(primitive.weights[v], V4f(1, 0, 0, 0)) << v;
    EXPECT_EQ(primitive.joints[v], (std::array<uint16_t, 4>{static_cast<uint16_t>(v == 2 ? 1 : 0), 0, 0, 0})) << v;
  }
  EXPECT_EQ(loaded.scene->nodes[0].skin, 0);
}

TEST(Skins, RefusesInvalidSkins) {
  GltfBuilder builder = skinned();
  builder.root["skins"][0]["joints"] = {1};
  EXPECT_EQ(load(builder).error,
            "/nodes/0/skin: a vertex of mesh 0 uses joint 1, skin 0 has 1 (ACCESSOR_JOINTS_INDEX_OOB)");
  builder.root["skins"][0]["joints"] = {1, 1};
  EXPECT_TRUE(contains(load(builder).error, "DUPLICATE_ELEMENTS"));
  builder.root["skins"][0]["joints"] = {0, 1, 2};
  EXPECT_EQ(load(builder).error, "/skins/0/inverseBindMatrices: 2 matrices for 3 joints (INVALID_IBM_ACCESSOR_COUNT)");
  builder.root["skins"][0]["joints"] = json::array();
  EXPECT_TRUE(contains(load(builder).error, "/skins/0/joints: 0 elements, expected at least 1"));
  builder = skinned();
  builder.root["skins"][0]["inverseBindMatrices"] = 0;
  EXPECT_TRUE(contains(load(builder).error, "SKIN_IBM_INVALID_FORMAT"));
}

TEST(Skins, SkinWithoutJointsInMeshHasNoEffect) {
  GltfBuilder builder = skinned();
  json& attributes = builder.root["meshes"][0]["primitives"][0]["attributes"];
  attributes.erase("JOINTS_0");
  attributes.erase("WEIGHTS_0");
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->nodes[0].skin, kNone);
  EXPECT_TRUE(loaded.warned("NODE_SKIN_WITH_NON_SKINNED_MESH"));
}

TEST(Visibility, ReadsVisibility) {
  const Loaded loaded = with_nodes(json::parse(R"([{"extensions": {"KHR_node_visibility": {"visible": false}}},
                                                    {"extensions": {"KHR_node_visibility": {}}}])"));
  EXPECT_FALSE(loaded.scene->nodes[0].visible);
  EXPECT_TRUE(loaded.scene->nodes[1].visible);
  EXPECT_TRUE(contains(with_nodes(json::parse(R"([{"extensions": {"KHR_node_visibility": {"visible": 1}}}])")).error,
                       "/nodes/0/extensions/KHR_node_visibility/visible: 1, expected true or false"));
}

TEST(GpuInstancing, ReadsTransforms) {
  GltfBuilder builder = triangle();
  const int translation = builder.accessor<float>({1, 2, 3, 4, 5, 6}, kFloat, "VEC3");
  const int rotation = builder.accessor<int16_t>({0, 0, 32767, 0, 0, 0, 0, 32767}, kShort, "VEC4", true);
  const int scale = builder.accessor<float>({1, 1, 1, 2, 2, 2}, kFloat, "VEC3");
  json& attributes = builder.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes = {{"TRANSLATION", translation}, {"ROTATION", rotation}, {"SCALE", scale}, {"_ID", scale}};
  Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  const std::vector<Transform>& instances = loaded.scene->nodes[0].gpu_instances;
  ASSERT_EQ(instances.size(), 2U);
  EXPECT_EQ(instances[0].translation, V3f(1, 2, 3));
  EXPECT_EQ(instances[0].rotation, Quatf(0, 0, 0, 1));
  EXPECT_EQ(instances[1].rotation, Quatf(1, 0, 0, 0));
  EXPECT_EQ(instances[1].scale, V3f(2, 2, 2));
  EXPECT_EQ(loaded.scene->meshes.size(), 1U);

  ImportOptions options;
  options.limits.max_gpu_instances = 1;
  EXPECT_TRUE(contains(load(builder, options).error, "more than 1 instances"));
  attributes["SCALE"] = builder.accessor<float>({1, 1, 1}, kFloat, "VEC3");
  attributes.erase("_ID");
  EXPECT_TRUE(contains(load(builder).error, "elements, another attribute has"));
  attributes = {{"TRANSLATION", rotation}};
  EXPECT_TRUE(contains(load(builder).error, "TRANSLATION must be VEC3 of FLOAT"));
}

GltfBuilder animated(const char* path, const char* interpolation, std::vector<float> times, std::vector<float> values,
                     const char* type) {
  GltfBuilder builder = triangle();
  const int input = builder.accessor(times, kFloat, "SCALAR");
  const int output = builder.accessor(values, kFloat, type);
  builder.push(
      "animations",
      {{"channels", json::array({json{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}})},
       {"samplers", json::array({json{{"input", input}, {"output", output}, {"interpolation", interpolation}}})}});
  return builder;
}

TEST(Animations, ReadsEveryPropertyAndInterpolation) {
  Loaded loaded = load(animated("translation", "LINEAR", {0, 2}, {1, 2, 3, 4, 5, 6}, "VEC3"));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  AnimationChannel channel = loaded.scene->animations[0].channels[0];
  EXPECT_EQ(channel.property, AnimatedProperty::translation);
  EXPECT_EQ(channel.interpolation, Interpolation::linear);
  EXPECT_EQ(channel.times_s, (std::vector<float>{0, 2}));
  EXPECT_EQ(channel.values, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(channel.components, 3);

  channel = load(animated("scale", "STEP", {1}, {1, 2, 3}, "VEC3")).scene->animations[0].channels[0];
  EXPECT_EQ(channel.property, AnimatedProperty::scale);
  EXPECT_EQ(channel.interpolation, Interpolation::step);

  channel = load(animated("rotation", "CUBICSPLINE", {0, 1}, std::vector<float>(24, 0.5f), "VEC4"))
                .scene->animations[0]
                .channels[0];
  EXPECT_EQ(channel.property, AnimatedProperty::rotation);
  EXPECT_EQ(channel.interpolation, Interpolation::cubic_spline);
  EXPECT_EQ(channel.values.size(), 24U);

  GltfBuilder builder = animated("weights", "LINEAR", {0, 1}, {0, 1, 1, 0}, "SCALAR");
  json& primitive = builder.root["meshes"][0]["primitives"][0];
  primitive["targets"] = json::array({json{{"POSITION", 0}}, json{{"POSITION", 0}}});
  channel = load(builder).scene->animations[0].channels[0];
  EXPECT_EQ(channel.property, AnimatedProperty::weights);
  EXPECT_EQ(channel.components, 2);
}

TEST(Animations, ReadsNormalizedIntegers) {
  GltfBuilder builder = animated("rotation", "LINEAR", {0}, {0, 0, 0, 1}, "VEC4");
  builder.root["animations"][0]["samplers"][0]["output"] =
      builder.accessor<int8_t>({0, 0, 127, 0}, kByte, "VEC4", true);
  EXPECT_EQ(load(builder).scene->animations[0].channels[0].values, (std::vector<float>{0, 0, 1, 0}));
}

TEST(Animations, ReadsPointersToNodes) {
  GltfBuilder builder = animated("pointer", "STEP", {0, 1}, {0, 0}, "SCALAR");
  json& animation = builder.root["animations"][0];
  animation["samplers"][0]["output"] = builder.accessor<uint8_t>({1, 0}, kUnsignedByte, "SCALAR");
  json& target = animation["channels"][0]["target"];
  target.erase("node");
  json& pointer = target["extensions"]["KHR_animation_pointer"]["pointer"];
  pointer = "/nodes/0/extensions/KHR_node_visibility/visible";
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_EQ(loaded.scene->animations[0].channels.at(0).property, AnimatedProperty::visible);
  EXPECT_EQ(loaded.scene->animations[0].channels.at(0).values, (std::vector<float>{1, 0}));
  for (const char* other : {"/materials/0/emissiveFactor", "/nodes/9/rotation", "/nodes/0", "/nodes/0/name", "nodes"}) {
    pointer = other;
    const Loaded without = load(builder);
    EXPECT_TRUE(without.scene->animations[0].channels.empty()) << other;
    EXPECT_TRUE(without.warned("has no effect")) << other;
  }
}

TEST(Animations, SkipsChannelsWithoutTarget) {
  GltfBuilder builder = animated("translation", "LINEAR", {0}, {1, 2, 3}, "VEC3");
  builder.root["animations"][0]["channels"][0]["target"].erase("node");
  EXPECT_TRUE(load(builder).scene->animations[0].channels.empty());
}

TEST(Animations, RefusesInvalidAnimations) {
  const auto error = [](const GltfBuilder& builder) { return load(builder).error; };
  EXPECT_EQ(error(animated("translation", "LINEAR", {0, 0}, {1, 2, 3, 4, 5, 6}, "VEC3")),
            "/animations/0/samplers/0/input: key 1 at 0 s is not after the one before at 0 s "
            "(ACCESSOR_ANIMATION_INPUT_NON_INCREASING)");
  EXPECT_TRUE(
      contains(error(animated("translation", "LINEAR", {-1}, {1, 2, 3}, "VEC3")), "ACCESSOR_ANIMATION_INPUT_NEGATIVE"));
  EXPECT_TRUE(contains(error(animated("translation", "LINEAR", {NAN}, {1, 2, 3}, "VEC3")), "ACCESSOR_INVALID_FLOAT"));
  EXPECT_TRUE(
      contains(error(animated("translation", "LINEAR", {0}, {1, INFINITY, 3}, "VEC3")), "ACCESSOR_INVALID_FLOAT"));
  EXPECT_TRUE(
      contains(error(animated("translation", "LINEAR", {0, 1}, {1, 2, 3}, "VEC3")), "1 values for 2 keys, expected 2"));
  EXPECT_TRUE(contains(error(animated("translation", "CUBICSPLINE", {0}, {1, 2, 3, 1, 2, 3, 1, 2, 3}, "VEC3")),
                       "ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS"));
  EXPECT_TRUE(contains(error(animated("rotation", "LINEAR", {0}, {1, 2, 3}, "VEC3")),
                       "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT"));
  EXPECT_TRUE(contains(error(animated("rotation", "LINEAR", {0}, {0, 0, 0, 0}, "VEC4")), "quaternion 0 has length 0"));
  EXPECT_TRUE(contains(error(animated("weights", "LINEAR", {0}, {1}, "SCALAR")),
                       "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS"));
  GltfBuilder builder = animated("translation", "LINEAR", {0}, {1, 2, 3}, "VEC3");
  builder.root["animations"][0]["channels"][0]["sampler"] = 1;
  EXPECT_EQ(error(builder), "/animations/0/channels/0/sampler: 1, the animation has 1 samplers (UNRESOLVED_REFERENCE)");
  builder.root["animations"][0]["channels"][0]["sampler"] = 0;
  builder.root["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  EXPECT_TRUE(contains(error(builder), "ANIMATION_CHANNEL_TARGET_NODE_MATRIX"));
}

} // namespace
} // namespace kindling::test
