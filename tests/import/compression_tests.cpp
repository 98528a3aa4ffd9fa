// EXT_meshopt_compression, KHR_mesh_quantization and KHR_draco_mesh_compression.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>

namespace kindling::test {
namespace {

constexpr int kSide = 8; // vertices along the side of a grid in the unit square

std::vector<float> grid_positions() {
  std::vector<float> positions;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x)
      positions.insert(positions.end(), {static_cast<float>(x) / 8.0f, static_cast<float>(y) / 8.0f, 0.25f});
  }
  return positions;
}

std::vector<uint16_t> grid_indices() {
  std::vector<uint16_t> indices;
  for (int y = 0; y + 1 < kSide; ++y) {
    for (int x = 0; x + 1 < kSide; ++x) {
      const int a = y * kSide + x;
      for (const int corner : {a, a + 1, a + kSide, a + 1, a + kSide + 1, a + kSide})
        indices.push_back(static_cast<uint16_t>(corner));
    }
  }
  return indices;
}

std::string encode_vertices(const void* data, size_t count, size_t stride) {
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data, count, stride));
  return {out.begin(), out.end()};
}

// Adds a compressed bufferView over a fallback buffer without data.
int compressed_view(GltfBuilder& builder, const std::string& bytes, size_t count, size_t stride, const char* mode,
                    const char* filter = "NONE") {
  const int plain = builder.view(bytes);
  json view = builder.root["bufferViews"][static_cast<size_t>(plain)];
  view["byteStride"] = stride;
  view["count"] = count;
  view["mode"] = mode;
  view["filter"] = filter;
  return builder.push("bufferViews", {{"buffer", 1},
                                      {"byteOffset", 0},
                                      {"byteLength", count * stride},
                                      {"extensions", {{"EXT_meshopt_compression", view}}}});
}

std::string with_fallback(const GltfBuilder& builder) {
  json root = builder.root;
  root["extensionsUsed"] = root["extensionsRequired"] = {"EXT_meshopt_compression"};
  root["buffers"] =
      json::array({json{{"byteLength", builder.bin.size()}, {"uri", data_uri(builder.bin)}},
                   json{{"byteLength", 1000000}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}});
  return root.dump();
}

// Returns the grid with compressed positions and indices, accessors 0 and 1.
GltfBuilder meshopt_grid() {
  GltfBuilder builder;
  const std::vector<float> positions = grid_positions();
  const std::vector<uint16_t> indices = grid_indices();
  const size_t vertices = positions.size() / 3;
  std::vector<unsigned char> bytes(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
  const int position_view =
      compressed_view(builder, encode_vertices(positions.data(), vertices, 12), vertices, 12, "ATTRIBUTES");
  const int index_view = compressed_view(builder, {bytes.begin(), bytes.end()}, indices.size(), 2, "TRIANGLES");
  const int position = builder.accessor_of(position_view, vertices, kFloat, "VEC3");
  const int index = builder.accessor_of(index_view, indices.size(), kUnsignedShort, "SCALAR");
  builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}, {"indices", index}})}});
  return builder;
}

const Primitive& decoded_primitive(const Loaded& loaded) {
  static const Primitive none;
  EXPECT_TRUE(loaded.scene) << loaded.error;
  return loaded.scene && !loaded.scene->meshes.empty() ? loaded.scene->meshes[0].primitives.at(0) : none;
}

void expect_grid(const Loaded& loaded, float tolerance) {
  const Primitive& primitive = decoded_primitive(loaded);
  ASSERT_EQ(primitive.triangle_count(), grid_indices().size() / 3);
  ASSERT_EQ(primitive.positions.size(), grid_positions().size() / 3);
  double area = 0.0;
  for (size_t i = 0; i < primitive.indices.size(); i += 3) {
    const V3f& a = primitive.positions[primitive.indices[i]];
    const V3f normal =
        (primitive.positions[primitive.indices[i + 1]] - a).cross(primitive.positions[primitive.indices[i + 2]] - a);
    EXPECT_GT(normal.z, 0.0f) << "winding is kept";
    area += 0.5 * static_cast<double>(normal.z);
    EXPECT_NEAR(a.z, 0.25f, tolerance);
  }
  EXPECT_NEAR(area, 49.0 / 64.0, tolerance);
}

TEST(Meshopt, DecodesAttributesAndTriangles) { expect_grid(load_text(with_fallback(meshopt_grid())), 0.0f); }

TEST(Meshopt, DecodesIndexSequences) {
  GltfBuilder builder = triangle();
  const std::vector<uint32_t> indices = {2, 0, 1};
  std::vector<unsigned char> bytes(meshopt_encodeIndexSequenceBound(3, 3));
  bytes.resize(meshopt_encodeIndexSequence(bytes.data(), bytes.size(), indices.data(), 3));
  const int view = compressed_view(builder, {bytes.begin(), bytes.end()}, 3, 4, "INDICES");
  builder.root["meshes"][0]["primitives"][0]["indices"] = builder.accessor_of(view, 3, kUnsignedInt, "SCALAR");
  EXPECT_EQ(decoded_primitive(load_text(with_fallback(builder))).indices, indices);
}

// Encodes vectors of three components with 24 bits.
void encode_exponential(std::vector<uint32_t>& encoded, const std::vector<float>& positions) {
  const size_t count = positions.size() / 3;
#if MESHOPTIMIZER_VERSION >= 190
  meshopt_encodeFilterExp(encoded.data(), count, 12, 24, positions.data(), meshopt_EncodeExpSharedVector);
#else // always with one exponent for a vector
  meshopt_encodeFilterExp(encoded.data(), count, 12, 24, positions.data());
#endif
}

TEST(Meshopt, AppliesFilters) {
  // EXPONENTIAL positions, OCTAHEDRAL normals; a QUATERNION channel.
  GltfBuilder builder;
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::vector<uint32_t> exponential(9);
  encode_exponential(exponential, positions);
  const std::vector<float> normals = {0, 0, 1, 0, 0.6f, 0.8f, 0, 0, 0, -1, 0, 0}; // vec4s
  std::vector<int8_t> octahedral(12);
  meshopt_encodeFilterOct(octahedral.data(), 3, 4, 8, normals.data());
  const int position = builder.accessor_of(
      compressed_view(builder, encode_vertices(exponential.data(), 3, 12), 3, 12, "ATTRIBUTES", "EXPONENTIAL"), 3,
      kFloat, "VEC3");
  const int normal_view =
      compressed_view(builder, encode_vertices(octahedral.data(), 3, 4), 3, 4, "ATTRIBUTES", "OCTAHEDRAL");
  builder.root["bufferViews"][static_cast<size_t>(normal_view)]["byteStride"] = 4;
  const int normal = builder.accessor_of(normal_view, 3, kByte, "VEC3", true);
  builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}})}});
  const std::vector<float> quaternions = {0, 0, 0, 1, 0, 0.6f, 0, 0.8f};
  std::vector<int16_t> packed(8);
  meshopt_encodeFilterQuat(packed.data(), 2, 8, 16, quaternions.data());
  const int rotation = builder.accessor_of(
      compressed_view(builder, encode_vertices(packed.data(), 2, 8), 2, 8, "ATTRIBUTES", "QUATERNION"), 2, kShort,
      "VEC4", true);
  const int times = builder.accessor<float>({0, 1}, kFloat, "SCALAR");
  builder.push("animations",
               {{"channels", json::array({json{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}})},
                {"samplers", json::array({json{{"input", times}, {"output", rotation}}})}});

  const Loaded loaded = load_text(with_fallback(builder));
  const Primitive& primitive = decoded_primitive(loaded);
  ASSERT_EQ(primitive.normals.size(), 3U);
  for (size_t i = 0; i < 3; ++i) {
    const V3f wanted(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]);
    EXPECT_LT((primitive.positions[i] - wanted).length(), 1e-6f);
  }
  // Eight bits per octahedral coordinate: a step of 1/127.
  EXPECT_LT((primitive.normals[0] - V3f(0, 0, 1)).length(), 0.02f);
  EXPECT_LT((primitive.normals[1] - V3f(0.6f, 0.8f, 0)).length(), 0.02f);
  const std::vector<float>& values = loaded.scene->animations[0].channels[0].values;
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(std::abs(values[i]), quaternions[i], 1e-3f);
}

TEST(Meshopt, RefusesBrokenData) {
  const auto error = [](auto&& change) {
    GltfBuilder builder = meshopt_grid();
    change(builder, builder.root["bufferViews"][1]["extensions"]["EXT_meshopt_compression"]);
    return load_text(with_fallback(builder)).error;
  };
  const auto has = [](const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; };
  EXPECT_TRUE(
      has(error([](GltfBuilder& b, json&) { b.bin[0] = '\x11'; }), "that meshoptimizer cannot decode as ATTRIBUTES"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["byteLength"] = 10; }), "that meshoptimizer cannot decode"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["byteLength"] = 100000; }), "BUFFER_VIEW_TOO_LONG"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["buffer"] = 2; }), "UNRESOLVED_REFERENCE"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["count"] = 63; }),
                  "/count: 63 elements of 12 bytes, the bufferView has 768"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["count"] = 9007199254740991; }), "/count: "));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["byteStride"] = 6; }), "/byteStride: 6 with mode ATTRIBUTES"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["mode"] = "TRIANGLES"; }), "expected 2 or 4"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["filter"] = "QUATERNION"; }), "expected 8"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["filter"] = "OTHER"; }), "expected one of NONE"));
}

TEST(Quantization, ReadsIntegerAttributes) {
  GltfBuilder builder;
  const int position = builder.accessor<uint16_t>({0, 0, 0, 0, 100, 0, 0, 0, 0, 200, 0, 0}, kUnsignedShort, "VEC4");
  builder.root["accessors"][0] = {{"bufferView", 0}, {"componentType", kUnsignedShort}, {"count", 3}, {"type", "VEC3"}};
  builder.root["bufferViews"][0]["byteStride"] = 8;
  json attributes = {{"POSITION", position}};
  const int normal = builder.accessor<int8_t>({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, kByte, "VEC4", true);
  builder.root["accessors"][1]["type"] = "VEC3";
  builder.root["bufferViews"][1]["byteStride"] = 4;
  attributes["NORMAL"] = normal;
  attributes["TEXCOORD_0"] = builder.accessor<int16_t>({-2, 3, 4, 5, 6, 7}, kShort, "VEC2");
  builder.root_node({{"mesh", builder.mesh({{"attributes", attributes}})}});
  builder.root["extensionsUsed"] = builder.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  const Loaded loaded = load(builder);
  EXPECT_EQ(decoded_primitive(loaded).positions, (std::vector<V3f>{{0, 0, 0}, {100, 0, 0}, {0, 200, 0}}));
  EXPECT_EQ(decoded_primitive(loaded).normals, std::vector<V3f>(3, V3f(0, 0, 1)));
  EXPECT_EQ(decoded_primitive(loaded).texcoords.at(0)[0], V2f(-2, 3));
}

// The grid as Draco data, with the ids of its attributes.
struct DracoGrid {
  std::string bytes;
  uint32_t position = 0;
  uint32_t texcoord = 0;
};

DracoGrid encode_draco(bool sequential, draco::DataType texcoord_type = draco::DT_FLOAT32) {
  const std::vector<float> positions = grid_positions();
  const std::vector<uint16_t> indices = grid_indices();
  const auto vertices = static_cast<uint32_t>(positions.size() / 3);
  draco::Mesh mesh;
  mesh.set_num_points(vertices);
  const auto add = [&](draco::GeometryAttribute::Type type, int8_t components, draco::DataType data) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, static_cast<uint8_t>(components), data, false,
                   int64_t{draco::DataTypeLength(data)} * components, 0);
    return mesh.AddAttribute(attribute, true, vertices);
  };
  const int position = add(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int texcoord = add(draco::GeometryAttribute::TEX_COORD, 2, texcoord_type);
  for (uint32_t i = 0; i < vertices; ++i) {
    mesh.attribute(position)->SetAttributeValue(draco::AttributeValueIndex(i), &positions[i * 3]);
    mesh.attribute(texcoord)->SetAttributeValue(draco::AttributeValueIndex(i), &positions[i * 3]); // x and y
  }
  for (size_t i = 0; i < indices.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(indices[i]), draco::PointIndex(indices[i + 1]), draco::PointIndex(indices[i + 2])});
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  return {{buffer.data(), buffer.size()}, mesh.attribute(position)->unique_id(), mesh.attribute(texcoord)->unique_id()};
}

GltfBuilder draco_grid(const DracoGrid& grid) {
  GltfBuilder builder;
  const size_t vertices = grid_positions().size() / 3;
  const int position = builder.push("accessors", {{"componentType", kFloat}, {"count", vertices}, {"type", "VEC3"}});
  const int texcoord = builder.push("accessors", {{"componentType", kFloat}, {"count", vertices}, {"type", "VEC2"}});
  const int index = builder.push(
      "accessors", {{"componentType", kUnsignedShort}, {"count", grid_indices().size()}, {"type", "SCALAR"}});
  const int view = builder.view(grid.bytes);
  builder.root_node(
      {{"mesh", builder.mesh({{"attributes", {{"POSITION", position}, {"TEXCOORD_0", texcoord}}},
                              {"indices", index},
                              {"extensions",
                               {{"KHR_draco_mesh_compression",
                                 {{"bufferView", view},
                                  {"attributes", {{"POSITION", grid.position}, {"TEXCOORD_0", grid.texcoord}}}}}}}})}});
  builder.root["extensionsUsed"] = builder.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return builder;
}

TEST(Draco, DecodesBothEncodings) {
  for (const bool sequential : {false, true}) {
    const Loaded loaded = load(draco_grid(encode_draco(sequential)));
    expect_grid(loaded, 1.0f / 8192.0f); // 14 bits over a range of 7/8
    const Primitive& primitive = decoded_primitive(loaded);
    ASSERT_EQ(primitive.texcoords.size(), 1U);
    for (size_t i = 0; i < primitive.positions.size(); ++i) {
      EXPECT_NEAR(primitive.texcoords[0][i].x, primitive.positions[i].x, 1.0f / 2048.0f);
    }
  }
}

TEST(Draco, RefusesBrokenData) {
  const DracoGrid grid = encode_draco(false);
  const auto error = [&](auto&& change) {
    GltfBuilder builder = draco_grid(grid);
    change(builder, builder.root["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]);
    return load(builder).error;
  };
  const auto has = [](const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; };
  EXPECT_TRUE(has(error([](GltfBuilder& b, json&) { b.bin[0] = 'X'; }), "not Draco data"));
  EXPECT_TRUE(has(error([](GltfBuilder& b, json&) { b.bin[5] = 1; }), "Draco bitstream 1.2, expected 2.2"));
  EXPECT_TRUE(has(error([](GltfBuilder& b, json&) { b.root["bufferViews"][0]["byteLength"] = b.bin.size() / 2; }),
                  "that draco cannot decode"));
  EXPECT_TRUE(
      has(error([](GltfBuilder&, json& e) { e["attributes"]["POSITION"] = 77; }), "id 77 is not in the Draco data"));
  EXPECT_TRUE(
      has(error([](GltfBuilder&, json& e) { e["attributes"]["POSITION"] = "0"; }), "expected an integer from 0"));
  EXPECT_TRUE(
      has(error([](GltfBuilder&, json& e) { e["attributes"]["NORMAL"] = 0; }), "that the primitive does not list"));
  EXPECT_TRUE(has(error([](GltfBuilder&, json& e) { e["bufferView"] = 9; }), "UNRESOLVED_REFERENCE"));
  EXPECT_TRUE(has(error([&](GltfBuilder&, json& e) { e["attributes"]["POSITION"] = grid.texcoord; }),
                  "2 components in the Draco data, 3 in accessor 0"));
}

// Draco reads any stored byte as a bool: undefined behavior unless it is 0 or 1.
TEST(Draco, RefusesBooleans) {
  const std::string error = load(draco_grid(encode_draco(true, draco::DT_BOOL))).error;
  EXPECT_NE(error.find("TEXCOORD_0: Draco values of type bool, expected a component type of glTF"), std::string::npos)
      << error;
}

TEST(Draco, RefusesHugeCountsBeforeDecoding) {
  GltfBuilder builder = draco_grid(encode_draco(true));
  // The sequential header is followed by the number of triangles as a varint: 2^32 - 1 of them.
  for (size_t i = 0; i < 4; ++i) builder.bin[11 + i] = '\xff';
  builder.bin[15] = '\x0f';
  EXPECT_NE(load(builder).error.find("are accepted for a file of this size"), std::string::npos);
}

} // namespace
} // namespace kindling::test
