// Accessors: component types, strides, sparse values, bounds.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Returns a triangle whose positions are the accessor `position`.
GltfBuilder with_position(GltfBuilder builder, int position) {
  builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}})}});
  return builder;
}

std::vector<V3f> positions(const Loaded& loaded) {
  EXPECT_TRUE(loaded.scene) << loaded.error;
  return loaded.scene ? loaded.scene->meshes.at(0).primitives.at(0).positions : std::vector<V3f>();
}

template <typename T>
std::vector<V3f> read_as(int component_type, bool normalized, T low, T high) {
  GltfBuilder builder;
  const int position =
      builder.accessor<T>({low, high, 0, high, low, 0, 0, 0, high}, component_type, "VEC3", normalized);
  return positions(load(with_position(std::move(builder), position)));
}

TEST(Accessor, ReadsEveryComponentType) {
  EXPECT_EQ(read_as<int8_t>(kByte, false, -128, 127)[0], V3f(-128, 127, 0));
  EXPECT_EQ(read_as<uint8_t>(kUnsignedByte, false, 0, 255)[0], V3f(0, 255, 0));
  EXPECT_EQ(read_as<int16_t>(kShort, false, -32768, 32767)[0], V3f(-32768, 32767, 0));
  EXPECT_EQ(read_as<uint16_t>(kUnsignedShort, false, 0, 65535)[0], V3f(0, 65535, 0));
  EXPECT_EQ(read_as<float>(kFloat, false, -1.5f, 2.5f)[0], V3f(-1.5f, 2.5f, 0));
}

TEST(Accessor, NormalizesIntegers) {
  EXPECT_EQ(read_as<int8_t>(kByte, true, -128, 127)[0], V3f(-1, 1, 0));
  EXPECT_EQ(read_as<uint8_t>(kUnsignedByte, true, 51, 255)[0], V3f(0.2f, 1, 0));
  EXPECT_EQ(read_as<int16_t>(kShort, true, -32768, 32767)[0], V3f(-1, 1, 0));
  EXPECT_EQ(read_as<uint16_t>(kUnsignedShort, true, 13107, 65535)[0], V3f(0.2f, 1, 0));
}

TEST(Accessor, RefusesFormatsInvalidForTheirUse) {
  GltfBuilder builder;
  const int position = builder.accessor<float>({0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2}, kFloat, "VEC4");
  EXPECT_EQ(load(with_position(std::move(builder), position)).error,
            "/meshes/0/primitives/0/attributes/POSITION: VEC4 of FLOAT, POSITION must be VEC3 of FLOAT, normalized "
            "BYTE or SHORT, BYTE or SHORT (MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT)");
}

TEST(Accessor, ReadsInterleavedAndOffset) {
  GltfBuilder builder;
  // Interleaved positions and normals after 8 unrelated bytes.
  std::vector<float> values = {9, 9};
  for (int i = 0; i < 3; ++i) {
    const auto x = static_cast<float>(i);
    values.insert(values.end(), {x, x + 1, x * x, 0, 0, 1});
  }
  const int view = builder.view(bytes_of(values), 24);
  const int position = builder.accessor_of(view, 3, kFloat, "VEC3");
  const int normal = builder.accessor_of(view, 3, kFloat, "VEC3");
  builder.root["accessors"][0]["byteOffset"] = 8;
  builder.root["accessors"][1]["byteOffset"] = 20;
  builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}})}});
  const Loaded loaded = load(builder);
  EXPECT_EQ(positions(loaded), (std::vector<V3f>{{0, 1, 0}, {1, 2, 1}, {2, 3, 4}}));
  EXPECT_EQ(loaded.scene->meshes[0].primitives[0].normals, std::vector<V3f>(3, V3f(0, 0, 1)));
}

TEST(Accessor, AppliesSparseValues) {
  for (const bool with_base : {true, false}) {
    GltfBuilder builder;
    int position;
    if (with_base) {
      position = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3");
    } else {
      position = builder.push("accessors", {{"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
    }
    const int indices = builder.view(bytes_of<uint16_t>({1, 2}));
    const int values = builder.view(bytes_of<float>({5, 6, 7, 8, 9, 10}));
    builder.root["accessors"][0]["sparse"] = {{"count", 2},
                                              {"indices", {{"bufferView", indices}, {"componentType", kUnsignedShort}}},
                                              {"values", {{"bufferView", values}}}};
    EXPECT_EQ(positions(load(with_position(std::move(builder), position))),
              (std::vector<V3f>{{0, 0, 0}, {5, 6, 7}, {8, 9, 10}}));
  }
}

TEST(Accessor, RefusesBrokenSparse) {
  const auto error = [](std::vector<uint16_t> sparse_indices, int count) {
    GltfBuilder builder;
    const int position = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3");
    const int indices = builder.view(bytes_of(sparse_indices));
    const int values = builder.view(std::string(48, '\0'));
    builder.root["accessors"][0]["sparse"] = {{"count", count},
                                              {"indices", {{"bufferView", indices}, {"componentType", kUnsignedShort}}},
                                              {"values", {{"bufferView", values}}}};
    return load(with_position(std::move(builder), position)).error;
  };
  EXPECT_NE(error({0, 3}, 2).find("ACCESSOR_SPARSE_INDEX_OOB"), std::string::npos);
  EXPECT_NE(error({1, 1}, 2).find("ACCESSOR_SPARSE_INDICES_NON_INCREASING"), std::string::npos);
  EXPECT_NE(error({0, 1, 2, 3}, 4).find("ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE"), std::string::npos);
  EXPECT_NE(error({0}, 2).find("ACCESSOR_TOO_LONG"), std::string::npos);
}

TEST(Accessor, ChecksBounds) {
  const auto error = [](auto&& change) {
    GltfBuilder builder = triangle();
    change(builder.root);
    return load(builder).error;
  };
  EXPECT_EQ(error([](json& r) { r["accessors"][0]["count"] = 4; }),
            "/accessors/0: reads 12 bytes past bufferView 0 (length 36) (ACCESSOR_TOO_LONG)");
  EXPECT_NE(error([](json& r) { r["accessors"][0]["byteOffset"] = 4; }).find("reads 4 bytes past"), std::string::npos);
  EXPECT_NE(error([](json& r) { r["accessors"][0]["byteOffset"] = 9007199254740991; }).find("ACCESSOR_TOO_LONG"),
            std::string::npos);
  EXPECT_NE(error([](json& r) { r["accessors"][0]["count"] = 9007199254740991; }).find("ACCESSOR_TOO_LONG"),
            std::string::npos);
  EXPECT_NE(error([](json& r) { r["bufferViews"][0]["byteLength"] = 40; }).find("BUFFER_VIEW_TOO_LONG"),
            std::string::npos);
  EXPECT_NE(error([](json& r) { r["bufferViews"][0]["byteOffset"] = 9007199254740991; }).find("BUFFER_VIEW_TOO_LONG"),
            std::string::npos);
  EXPECT_NE(error([](json& r) { r["bufferViews"][0]["byteStride"] = 4; }).find("ACCESSOR_SMALL_BYTESTRIDE"),
            std::string::npos);
  EXPECT_NE(error([](json& r) { r["bufferViews"][0]["byteStride"] = 6; }).find("VALUE_MULTIPLE_OF"), std::string::npos);
  EXPECT_NE(error([](json& r) { r["accessors"][0]["normalized"] = true; }).find("ACCESSOR_NORMALIZED_INVALID"),
            std::string::npos);
  EXPECT_NE(error([](json& r) { r["accessors"][0]["componentType"] = 5124; }).find("expected one of 5120"),
            std::string::npos);
  EXPECT_NE(error([](json& r) { r["accessors"][0]["count"] = 0; }).find("VALUE_NOT_IN_RANGE"), std::string::npos);
  EXPECT_NE(error([](json& r) { r["accessors"][0]["bufferView"] = 1; }).find("UNRESOLVED_REFERENCE"),
            std::string::npos);
}

TEST(Accessor, RefusesBufferShorterThanDeclared) {
  GltfBuilder builder = triangle();
  builder.root["buffers"] = json::array({json{{"byteLength", 36}, {"uri", data_uri(builder.bin.substr(0, 35))}}});
  EXPECT_EQ(load(builder).error, "/buffers/0: declares 36 bytes but has 35 (BUFFER_BYTE_LENGTH_MISMATCH)");
}

} // namespace
} // namespace kindling::test
