// Meshes: primitive modes, vertex attributes and their repair, morph targets.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace kindling::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Five vertices on a zig-zag.
GltfBuilder zigzag(int mode, std::vector<uint16_t> indices = {}) {
  GltfBuilder builder;
  const int position = builder.accessor<float>({0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0}, kFloat, "VEC3");
  json primitive = {{"attributes", {{"POSITION", position}}}, {"mode", mode}};
  if (!indices.empty()) primitive["indices"] = builder.accessor<uint16_t>(indices, kUnsignedShort, "SCALAR");
  builder.root_node({{"mesh", builder.mesh(std::move(primitive))}});
  return builder;
}

const Primitive& only(const Loaded& loaded) {
  static const Primitive none;
  EXPECT_TRUE(loaded.scene) << loaded.error;
  if (!loaded.scene || loaded.scene->meshes.empty() || loaded.scene->meshes[0].primitives.empty()) return none;
  return loaded.scene->meshes[0].primitives[0];
}

using Indices = std::vector<uint32_t>;

TEST(Mesh, UnrollsEveryTriangleMode) {
  // glTF 2.0, section 3.7.2.1: strips reverse every second triangle to preserve the winding; a
  // triangle of a fan starts with the next two vertices.
  EXPECT_EQ(only(load(zigzag(4))).indices, (Indices{0, 1, 2})); // two vertices are unused
  EXPECT_EQ(only(load(zigzag(5))).indices, (Indices{0, 1, 2, 1, 3, 2, 2, 3, 4}));
  EXPECT_EQ(only(load(zigzag(6))).indices, (Indices{1, 2, 0, 2, 3, 0, 3, 4, 0}));
  EXPECT_EQ(only(load(zigzag(5, {4, 3, 2, 1, 0}))).indices, (Indices{4, 3, 2, 3, 1, 2, 2, 1, 0}));
}

// Checks that the bodies are closed and that their triangles face outwards once they have a width.
void expect_closed_bodies(const Primitive& primitive) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  double volume = 0.0;
  ASSERT_EQ(primitive.stroke_offsets.size(), primitive.positions.size());
  for (size_t i = 0; i < primitive.indices.size(); i += 3) {
    std::array<V3d, 3> p;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t corner = primitive.indices[i + c];
      ++edges[{corner, primitive.indices[i + (c + 1) % 3]}];
      p[c] = V3d(primitive.positions[corner]) + V3d(primitive.stroke_offsets[corner]) * 0.01;
      EXPECT_NEAR(primitive.stroke_offsets[corner].length(), 1.0f, 1e-6f);
    }
    volume += p[0].dot(p[1].cross(p[2])) / 6.0;
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
  EXPECT_GT(volume, 0.0);
}

TEST(Mesh, MakesBodiesOfPointsAndLines) {
  struct Case {
    int mode;
    size_t vertices, triangles; // of bodies: 6 and 8 of a point, 10 and 16 of a segment
  };
  for (const Case& expected : {Case{0, 30, 40}, Case{1, 20, 32}, Case{2, 50, 80}, Case{3, 40, 64}}) {
    SCOPED_TRACE(expected.mode);
    const Loaded loaded = load(zigzag(expected.mode));
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warnings.empty()) << testing::PrintToString(loaded.warnings);
    const Primitive& primitive = only(loaded);
    EXPECT_EQ(primitive.stroke, Stroke::unlit);
    EXPECT_EQ(primitive.positions.size(), expected.vertices);
    EXPECT_EQ(primitive.triangle_count(), expected.triangles);
    expect_closed_bodies(primitive);
  }
}

// A square of two triangles, and lines of the given indices into its corners and its center.
GltfBuilder square_with_lines(int mode, const std::vector<uint16_t>& lines) {
  GltfBuilder builder = zigzag(4, {0, 1, 2, 2, 1, 3});
  json& primitives = builder.root["meshes"][0]["primitives"];
  json& triangles = primitives[0];
  triangles["attributes"]["POSITION"] =
      builder.accessor<float>({-0.0f, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, .5f, .5f, 0}, kFloat, "VEC3");
  json edges = triangles;
  edges["mode"] = mode;
  edges["attributes"]["POSITION"] =
      builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, .5f, .5f, 0}, kFloat, "VEC3");
  edges["indices"] = builder.accessor<uint16_t>(lines, kUnsignedShort, "SCALAR");
  primitives.push_back(edges);
  return builder;
}

TEST(Mesh, LinesAlongEdgesOfTrianglesAreOutlines) {
  const auto is_outline = [](int mode, const std::vector<uint16_t>& lines) {
    const Loaded loaded = load(square_with_lines(mode, lines));
    EXPECT_TRUE(loaded.scene) << loaded.error;
    const std::vector<Primitive>& primitives = loaded.scene.value().meshes[0].primitives;
    EXPECT_EQ(primitives.size(), 2U);
    EXPECT_FALSE(primitives[0].outline);
    return primitives[1].outline;
  };
  EXPECT_TRUE(is_outline(1, {0, 1, 1, 3, 3, 2, 2, 0})); // of the square, which has a corner at -0
  EXPECT_TRUE(is_outline(3, {0, 1, 3, 2, 0}));
  EXPECT_TRUE(is_outline(2, {0, 1, 3, 2}));
  EXPECT_TRUE(is_outline(1, {1, 2}));                    // the diagonal, an edge of both triangles
  EXPECT_FALSE(is_outline(1, {0, 3}));                   // the other one
  EXPECT_FALSE(is_outline(1, {0, 4}));                   // half of it
  EXPECT_TRUE(is_outline(1, {0, 1, 1, 3, 3, 2, 0, 3}));  // three quarters
  EXPECT_FALSE(is_outline(1, {0, 1, 1, 3, 0, 3, 0, 4})); // a half
  EXPECT_FALSE(is_outline(0, {0, 1, 2, 3}));             // points at its corners
}

TEST(Mesh, VerticesOfBodiesHaveTheAttributesOfTheirPoint) {
  GltfBuilder builder = zigzag(3, {4, 0, 2});
  json& attributes = builder.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["COLOR_0"] =
      builder.accessor<float>({0, 0, 0, .1f, 0, 0, .2f, 0, 0, .3f, 0, 0, .4f, 0, 0}, kFloat, "VEC3");
  attributes["NORMAL"] = builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0, 1, 1, 0, 0}, kFloat, "VEC3");
  const Loaded loaded = load(builder);
  const Primitive& primitive = only(loaded);
  EXPECT_EQ(primitive.stroke, Stroke::lit);
  ASSERT_EQ(primitive.colors.size(), 20U);
  const Primitive source = only(load(zigzag(4)));
  for (size_t v = 0; v < 20; ++v) {
    const float red = v < 5 ? 0.4f : v < 15 ? 0.0f : 0.2f; // vertices 4, 0, 0, 2
    EXPECT_EQ(primitive.colors[v], V4f(red, 0.0f, 0.0f, 1.0f)) << v;
    EXPECT_EQ(primitive.normals[v], v < 5 ? V3f(1, 0, 0) : v < 15 ? V3f(0, 0, 1) : V3f(0, 1, 0)) << v;
  }
}

TEST(Mesh, LeavesOutPointsAndLinesThatCannotBeDrawn) {
  const Loaded outside = load(zigzag(1, {0, 1, 2, 7, 3, 4}));
  EXPECT_NE(outside.error.find("ACCESSOR_INDEX_OOB"), std::string::npos) << outside.error;
  const Loaded lenient = load(zigzag(1, {0, 1, 2, 7, 3, 4}), kLenient);
  ASSERT_TRUE(lenient.scene) << lenient.error;
  EXPECT_EQ(only(lenient).triangle_count(), 32U);
  const Loaded single = load(zigzag(3, {1}));
  ASSERT_TRUE(single.scene) << single.error;
  EXPECT_TRUE(single.scene->meshes[0].primitives.empty());
  EXPECT_EQ(single.warnings,
            std::vector<std::string>{"/meshes/0/primitives/0: a primitive with fewer than two vertices "
                                     "is not rendered (MESH_PRIMITIVE_INCOMPATIBLE_MODE)"});
}

TEST(Mesh, ReadsIndicesOfEveryType) {
  const auto with = [](auto values, int type) {
    GltfBuilder builder = zigzag(4);
    builder.root["meshes"][0]["primitives"][0]["indices"] = builder.accessor(values, type, "SCALAR");
    return only(load(builder)).indices;
  };
  EXPECT_EQ(with(std::vector<uint8_t>{4, 3, 0, 1, 2, 3}, kUnsignedByte), (Indices{4, 3, 0, 1, 2, 3}));
  EXPECT_EQ(with(std::vector<uint16_t>{4, 3, 0, 1, 2, 3}, kUnsignedShort), (Indices{4, 3, 0, 1, 2, 3}));
  EXPECT_EQ(with(std::vector<uint32_t>{4, 3, 0, 1, 2, 3}, kUnsignedInt), (Indices{4, 3, 0, 1, 2, 3}));
}

TEST(Mesh, RefusesIndicesOutOfBounds) {
  EXPECT_EQ(load(zigzag(4, {0, 1, 5})).error,
            "/meshes/0/primitives/0/indices: index 5 at 2, there are 5 vertices (ACCESSOR_INDEX_OOB)");
  GltfBuilder builder = zigzag(4);
  builder.root["meshes"][0]["primitives"][0]["indices"] = builder.accessor<float>({0, 1, 2}, kFloat, "SCALAR");
  EXPECT_NE(load(builder).error.find("MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT"), std::string::npos);
}

TEST(Mesh, RemovesUnusedVertices) {
  const Loaded loaded = load(zigzag(4, {4, 2, 1}));
  EXPECT_EQ(only(loaded).indices, (Indices{2, 1, 0}));
  EXPECT_EQ(only(loaded).positions, (std::vector<V3f>{{0, 1, 0}, {1, 0, 0}, {2, 0, 0}}));
}

TEST(Mesh, RefusesPositionsThatAreNotFinite) {
  for (const float bad : {kNan, std::numeric_limits<float>::infinity(), 1e30f}) {
    GltfBuilder builder;
    const int position = builder.accessor<float>({0, 0, 0, 1, bad, 0, 0, 1, 0}, kFloat, "VEC3");
    builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}})}});
    EXPECT_NE(load(builder).error.find("/meshes/0/primitives/0/attributes/POSITION: vertex ("), std::string::npos);
  }
}

TEST(Mesh, NormalizesNormalsAndReplacesThoseWithoutDirection) {
  GltfBuilder builder = triangle();
  const int normal = builder.accessor<float>({0, 0, 2, 0, 0, 0, kNan, 0, 0}, kFloat, "VEC3");
  builder.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normal;
  const Loaded loaded = load(builder);
  EXPECT_EQ(only(loaded).normals, std::vector<V3f>(3, V3f(0, 0, 1)));
  EXPECT_TRUE(loaded.warned("2 normals without a direction"));
}

TEST(Mesh, ReadsAllTexcoordSetsAndColors) {
  GltfBuilder builder = triangle();
  json& attributes = builder.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_0"] = builder.accessor<float>({0, 0, 1, 0, kNan, 1}, kFloat, "VEC2");
  attributes["TEXCOORD_2"] = builder.accessor<uint16_t>({0, 0, 65535, 0, 0, 65535}, kUnsignedShort, "VEC2", true);
  attributes["COLOR_0"] = builder.accessor<float>({1, 0, 0, 0, 2, 0, 0, 0, -1}, kFloat, "VEC3");
  attributes["_CUSTOM"] = builder.accessor<float>({1, 2, 3}, kFloat, "SCALAR");
  const Loaded loaded = load(builder);
  const Primitive& primitive = only(loaded);
  ASSERT_EQ(primitive.texcoords.size(), 3U);
  EXPECT_EQ(primitive.texcoords[0], (std::vector<V2f>{{0, 0}, {1, 0}, {0, 0}}));
  EXPECT_TRUE(primitive.texcoords[1].empty());
  EXPECT_EQ(primitive.texcoords[2], (std::vector<V2f>{{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_EQ(primitive.colors, (std::vector<V4f>{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 0, 1}}));
  EXPECT_TRUE(loaded.warned("1 texture coordinates that are not finite"));
}

TEST(Mesh, ReadsColorsWithAlphaOfEveryType) {
  const auto color = [](auto values, int type, bool normalized) {
    GltfBuilder builder = triangle();
    builder.root["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
        builder.accessor(values, type, "VEC4", normalized);
    return only(load(builder)).colors.at(2);
  };
  EXPECT_EQ(color(std::vector<float>{0, 0, 0, 0, 0, 0, 0, 0, 1, .5f, 0, .2f}, kFloat, false), V4f(1, .5f, 0, .2f));
  EXPECT_EQ(color(std::vector<uint8_t>{0, 0, 0, 0, 0, 0, 0, 0, 255, 0, 0, 51}, kUnsignedByte, true), V4f(1, 0, 0, .2f));
  EXPECT_EQ(color(std::vector<uint16_t>{0, 0, 0, 0, 0, 0, 0, 0, 65535, 0, 0, 13107}, kUnsignedShort, true),
            V4f(1, 0, 0, .2f));
}

TEST(Mesh, RefusesAttributesOfUnequalLength) {
  GltfBuilder builder = triangle();
  builder.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      builder.accessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC3");
  EXPECT_EQ(
      load(builder).error,
      "/meshes/0/primitives/0/attributes/NORMAL: 2 elements, POSITION has 3 (MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT)");
}

// A triangle with texture coordinates and a normal map.
GltfBuilder normal_mapped() {
  GltfBuilder builder = triangle();
  json& primitive = builder.root["meshes"][0]["primitives"][0];
  primitive["attributes"]["NORMAL"] = builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3");
  primitive["attributes"]["TEXCOORD_0"] = builder.accessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2");
  primitive["material"] = builder.push("materials", {{"normalTexture", {{"index", 0}}}});
  builder.push("textures", {{"source", 0}});
  builder.push("images", {{"uri", "data:image/png;base64," + std::string(kPngBase64)}});
  return builder;
}

TEST(Mesh, ComputesTangentsForNormalMaps) {
  const Loaded loaded = load(normal_mapped());
  ASSERT_EQ(only(loaded).tangents.size(), 3U);
  for (const V4f& tangent : only(loaded).tangents)
    EXPECT_NEAR((tangent - V4f(1, 0, 0, tangent.w)).length(), 0.0f, 1e-6f);
  EXPECT_TRUE(only(load(triangle())).tangents.empty());
}

TEST(Mesh, ReadsAndRepairsTangents) {
  GltfBuilder builder = normal_mapped();
  json& attributes = builder.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["TANGENT"] = builder.accessor<float>({0, 2, 0, 1, 0, 1, 0, -1, 0, 1, 0, 0}, kFloat, "VEC4");
  EXPECT_EQ(only(load(builder)).tangents, (std::vector<V4f>{{0, 1, 0, 1}, {0, 1, 0, -1}, {0, 1, 0, 1}}));
  attributes["TANGENT"] = builder.accessor<float>({0, 0, 0, 1, 0, 1, 0, -1, 0, 1, 0, 0}, kFloat, "VEC4");
  const Loaded loaded = load(builder);
  EXPECT_TRUE(loaded.warned("1 tangents without a direction: all are recomputed"));
  EXPECT_NEAR(std::abs(only(loaded).tangents.at(0).x), 1.0f, 1e-6f);
}

TEST(Mesh, WarnsOfTexturesWithoutCoordinates) {
  GltfBuilder builder = normal_mapped();
  builder.root["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  const Loaded loaded = load(builder);
  EXPECT_TRUE(only(loaded).tangents.empty());
  EXPECT_TRUE(loaded.warned("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS"));
}

TEST(Mesh, ReadsJointsAndNormalizesWeights) {
  GltfBuilder builder = triangle();
  json& attributes = builder.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = builder.accessor<uint8_t>({1, 9, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0}, kUnsignedByte, "VEC4");
  attributes["WEIGHTS_0"] = builder.accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, kFloat, "VEC4");
  attributes["JOINTS_1"] = builder.accessor<uint16_t>({2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, kUnsignedShort, "VEC4");
  attributes["WEIGHTS_1"] =
      builder.accessor<uint8_t>({255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, kUnsignedByte, "VEC4", true);
  const Loaded loaded = load(builder);
  const Primitive& primitive = only(loaded);
  ASSERT_EQ(primitive.joints.size(), 6U);
  // Vertex 0: equal weights in both sets; the joint without weight becomes 0.
  EXPECT_EQ(primitive.joints[0], (std::array<uint16_t, 4>{1, 0, 0, 0}));
  EXPECT_EQ(primitive.joints[3], (std::array<uint16_t, 4>{2, 0, 0, 0}));
  EXPECT_EQ(primitive.weights[0], V4f(.5f, 0, 0, 0));
  EXPECT_EQ(primitive.weights[3], V4f(.5f, 0, 0, 0));
  // Vertex 2 has no weights: it follows its first joint.
  EXPECT_EQ(primitive.joints[2][0], 2);
  EXPECT_EQ(primitive.weights[2], V4f(1, 0, 0, 0));
}

TEST(Mesh, RefusesJointsWithoutWeights) {
  GltfBuilder builder = triangle();
  builder.root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] =
      builder.accessor<uint8_t>(std::vector<uint8_t>(12), kUnsignedByte, "VEC4");
  EXPECT_NE(load(builder).error.find("MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH"), std::string::npos);
}

TEST(Mesh, ReadsMorphTargets) {
  GltfBuilder builder = triangle();
  json& primitive = builder.root["meshes"][0]["primitives"][0];
  const int delta = builder.accessor<float>({0, 0, 1, 0, 0, 2, 0, 0, 3}, kFloat, "VEC3");
  const int zero = builder.push("accessors", {{"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
  primitive["targets"] = json::array({json{{"POSITION", delta}}, json{{"POSITION", zero}, {"NORMAL", delta}}});
  builder.root["meshes"][0]["weights"] = {0.25, 0.5};
  Loaded loaded = load(builder);
  ASSERT_EQ(only(loaded).targets.size(), 2U);
  EXPECT_EQ(only(loaded).targets[0].positions, (std::vector<V3f>{{0, 0, 1}, {0, 0, 2}, {0, 0, 3}}));
  EXPECT_TRUE(only(loaded).targets[1].positions.empty()) << "zero deltas need no memory";
  EXPECT_TRUE(only(loaded).targets[1].normals.empty()) << "there are no normals to add to";
  EXPECT_EQ(loaded.scene->meshes[0].weights, (std::vector<float>{0.25f, 0.5f}));

  builder.root["meshes"][0]["weights"] = {0.25};
  EXPECT_EQ(load(builder).error,
            "/meshes/0/weights: 1 weights, the mesh has 2 morph targets (MESH_INVALID_WEIGHTS_COUNT)");
  builder.root["meshes"][0].erase("weights");
  json other = primitive;
  other["targets"].erase(0);
  builder.root["meshes"][0]["primitives"].push_back(other);
  EXPECT_NE(load(builder).error.find("MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT"), std::string::npos);
  builder.root["meshes"][0]["primitives"].erase(1);
  builder.root["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] =
      builder.accessor<float>({0, 0, 1}, kFloat, "VEC3");
  EXPECT_NE(load(builder).error.find("MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT"), std::string::npos);
}

TEST(Mesh, IsIndependentOfWorkOrder) {
  // Several invalid primitives: the error is always that of the first.
  GltfBuilder builder = triangle();
  json& primitives = builder.root["meshes"][0]["primitives"];
  const int bad = builder.accessor<uint8_t>({0, 1, 7}, kUnsignedByte, "SCALAR");
  for (int i = 0; i < 40; ++i) {
    json primitive = primitives[0];
    if (i >= 20) primitive["indices"] = bad;
    primitives.push_back(primitive);
  }
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(load(builder).error,
              "/meshes/0/primitives/21/indices: index 7 at 2, there are 3 vertices (ACCESSOR_INDEX_OOB)");
  }
}

} // namespace
} // namespace kindling::test
