// KHR_meshopt_compression: attribute codec version 1 and color filter against the reference.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/compression/meshopt_attributes.h"
#include "tests/import/gltf_builder.h"
#include "tests/import/meshopt_fixtures.h"

#include <gtest/gtest.h>

#include <random>

namespace kindling::test {
namespace {

std::vector<std::byte> from_base64_bytes(std::string_view base64) {
  const std::string text = from_base64(base64);
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}

struct Decoded {
  bool valid = false;
  std::vector<std::byte> bytes;
};

// Copies the stream to memory of exactly its size, so that a sanitizer detects every read beyond
// it.
Decoded decode(const std::vector<std::byte>& stream, size_t count, size_t stride, std::string_view filter) {
  const auto exact = std::make_unique<std::byte[]>(stream.size());
  std::copy(stream.begin(), stream.end(), exact.get());
  Decoded out{false, std::vector<std::byte>(count * stride)};
  out.valid = gltf::decode_meshopt_attributes_v1({exact.get(), stream.size()}, count, stride, out.bytes);
  if (filter == "COLOR") gltf::decode_meshopt_color(out.bytes, stride);
  return out;
}

TEST(MeshoptV1, DecodesBitIdenticallyToReference) {
  for (const MeshoptFixture& fixture : meshopt_fixtures()) {
    const std::vector<std::byte> stream = from_base64_bytes(fixture.encoded);
    ASSERT_TRUE(gltf::is_meshopt_attributes_v1(stream)) << fixture.name;
    const Decoded decoded = decode(stream, fixture.count, fixture.stride, fixture.filter);
    EXPECT_TRUE(decoded.valid) << fixture.name;
    EXPECT_EQ(decoded.bytes, from_base64_bytes(fixture.decoded)) << fixture.name;
  }
}

TEST(MeshoptV1, RefusesStreamsOfWrongLength) {
  for (const MeshoptFixture& fixture : meshopt_fixtures()) {
    std::vector<std::byte> stream = from_base64_bytes(fixture.encoded);
    EXPECT_FALSE(decode({}, fixture.count, fixture.stride, "").valid);
    stream.push_back(std::byte{0});
    EXPECT_FALSE(decode(stream, fixture.count, fixture.stride, "").valid) << fixture.name;
    stream.resize(20);
    EXPECT_FALSE(decode(stream, fixture.count, fixture.stride, "").valid) << fixture.name;
  }
}

TEST(MeshoptV1, RefusesInvalidChannelModes) {
  const MeshoptFixture& fixture = meshopt_fixtures()[0];
  for (const int mode : {0x03, 0x0f, 0x10, 0x21}) {
    std::vector<std::byte> stream = from_base64_bytes(fixture.encoded);
    stream.back() = static_cast<std::byte>(mode);
    EXPECT_FALSE(decode(stream, fixture.count, fixture.stride, "").valid) << mode;
  }
}

// No bytes cause access out of bounds (for builds with sanitizers), and each stream gets an answer.
TEST(MeshoptV1, SurvivesBrokenStreams) {
  std::mt19937 random(1);
  size_t valid = 0;
  for (const MeshoptFixture& fixture : meshopt_fixtures()) {
    const std::vector<std::byte> good = from_base64_bytes(fixture.encoded);
    for (int i = 0; i < 300; ++i) {
      std::vector<std::byte> bad = good;
      for (int n = 0; n < 1 + i % 4; ++n) bad[1 + random() % (bad.size() - 1)] = static_cast<std::byte>(random());
      if (i % 3 == 0) bad.resize(1 + random() % bad.size());
      const size_t count = i % 5 == 0 ? fixture.count + random() % 40 : fixture.count;
      valid += decode(bad, count, fixture.stride, fixture.filter).valid;
    }
  }
  EXPECT_GT(valid, 0U); // other values in a stream of the same shape
}

TEST(MeshoptV1, InvalidColorsGiveValidValues) {
  for (const size_t stride : {4U, 8U}) {
    std::vector<std::byte> elements(stride * 3, std::byte{0});
    std::fill(elements.begin() + static_cast<std::ptrdiff_t>(stride), elements.end(), std::byte{0xff});
    std::fill(elements.end() - static_cast<std::ptrdiff_t>(stride), elements.end(), std::byte{0x80});
    gltf::decode_meshopt_color(elements, stride);
    EXPECT_EQ(elements[0], std::byte{0}); // without an alpha there is no scale
  }
}

// Returns a file whose positions are the named fixture, in the named extension.
json compressed_file(const char* extension, std::string_view name) {
  const auto fixtures = meshopt_fixtures();
  const auto fixture =
      std::find_if(fixtures.begin(), fixtures.end(), [&](const MeshoptFixture& f) { return f.name == name; });
  GltfBuilder builder;
  const int plain = builder.view(from_base64(fixture->encoded));
  json compressed = builder.root["bufferViews"][static_cast<size_t>(plain)];
  compressed["byteStride"] = fixture->stride;
  compressed["count"] = fixture->count;
  compressed["mode"] = "ATTRIBUTES";
  compressed["filter"] = fixture->filter;
  const int view = builder.push(
      "bufferViews",
      {{"buffer", 1}, {"byteLength", fixture->count * fixture->stride}, {"extensions", {{extension, compressed}}}});
  const int position = builder.accessor_of(view, fixture->count - fixture->count % 3, kFloat, "VEC3");
  builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}})}});
  json root = builder.root;
  root["extensionsUsed"] = root["extensionsRequired"] = {extension};
  json fallback = {{"byteLength", 1000000}};
  fallback["extensions"][extension]["fallback"] = true;
  root["buffers"] = json::array({json{{"byteLength", builder.bin.size()}, {"uri", data_uri(builder.bin)}}, fallback});
  return root;
}

TEST(MeshoptV1, FilesLoad) {
  for (const char* extension : {"KHR_meshopt_compression", "EXT_meshopt_compression"}) {
    const Loaded loaded = load_text(compressed_file(extension, "floats").dump());
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
    const std::vector<V3f>& positions = loaded.scene->meshes[0].primitives[0].positions;
    ASSERT_EQ(positions.size(), 48U);
    EXPECT_EQ(positions[0], V3f(2.0f, 2.29552021f, 2.56464247f)); // sin(0.3 i) + 2
  }
}

TEST(MeshoptV1, InvalidFilesReportThePlace) {
  json root = compressed_file("KHR_meshopt_compression", "floats");
  json& view = root["bufferViews"][1]["extensions"]["KHR_meshopt_compression"];
  view["filter"] = "COLOR";
  EXPECT_EQ(load_text(root.dump()).error, "/bufferViews/1/extensions/KHR_meshopt_compression/byteStride: 12 with mode "
                                          "ATTRIBUTES and filter COLOR, expected 4 or 8");
  view["filter"] = "NONE";
  view["byteLength"] = view["byteLength"].get<int>() - 1;
  EXPECT_NE(load_text(root.dump()).error.find("/bufferViews/1/extensions/KHR_meshopt_compression"), std::string::npos);
}

} // namespace
} // namespace kindling::test
