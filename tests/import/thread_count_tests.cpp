// Results, warnings and errors for any number of threads; parallel parts against serial loops.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/document/triangles.h"
#include "renderer/import/files/file_bytes.h"
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

namespace kindling::test {
namespace {

constexpr size_t kThreads[] = {1, 4};

template <typename Run>
auto with_threads(size_t threads, const Run& run) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return run();
}

std::string random_bytes(size_t size) {
  std::mt19937_64 random(size);
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

gltf::Bytes as_span(std::string_view text) { return std::as_bytes(std::span(text.data(), text.size())); }

TEST(FileBytes, ReadsLargeFilesCompletely) {
  const TempFolder folder;
  for (const size_t size : {size_t{0}, size_t{1}, gltf::kHashedBlock, 3 * gltf::kHashedBlock + 12345}) {
    const std::string content = random_bytes(size);
    const std::filesystem::path path = folder.write("large.bin", content);
    for (const size_t threads : kThreads) {
      const Result<gltf::OwnedBytes> read = with_threads(threads, [&] { return gltf::read_file(path, size); });
      ASSERT_TRUE(read.ok()) << size;
      EXPECT_TRUE(gltf::as_text(read.value().span()) == content) << size;
    }
    if (size > 0) {
      EXPECT_FALSE(gltf::read_file(path, size - 1).ok());
    }
  }
}

// The definition in file_bytes.h.
TEST(FileBytes, ContentHashCombinesBlockHashes) {
  for (const size_t size : {size_t{0}, size_t{77}, gltf::kHashedBlock}) {
    const std::string content = random_bytes(size);
    EXPECT_EQ(gltf::hash_content(as_span(content), 5), gltf::hash_bytes(as_span(content), 5)) << size;
  }
  for (const size_t size : {gltf::kHashedBlock + 1, 4 * gltf::kHashedBlock, 5 * gltf::kHashedBlock - 3}) {
    std::string content = random_bytes(size);
    std::string words;
    const auto add = [&](uint64_t word) {
      for (int byte = 0; byte < 8; ++byte) words += static_cast<char>(word >> (8 * byte));
    };
    for (size_t begin = 0; begin < size; begin += gltf::kHashedBlock)
      add(gltf::hash_bytes(as_span(std::string_view(content).substr(begin, gltf::kHashedBlock))));
    add(size);
    const uint64_t expected = gltf::hash_bytes(as_span(words), 9);
    for (const size_t threads : kThreads)
      EXPECT_EQ(with_threads(threads, [&] { return gltf::hash_content(as_span(content), 9); }), expected) << size;
    for (const size_t changed : {size_t{0}, gltf::kHashedBlock, size - 1}) {
      content[changed] = static_cast<char>(content[changed] ^ 1);
      EXPECT_NE(gltf::hash_content(as_span(content), 9), expected) << changed;
      content[changed] = static_cast<char>(content[changed] ^ 1);
    }
  }
}

TEST(Triangles, CompactVerticesEqualsSerialLoop) {
  constexpr uint32_t kVertices = 150000;
  std::mt19937 random(1);
  for (const uint32_t every : {1U, 3U, 50000U}) { // uses about one of `every` vertices
    std::vector<uint32_t> indices(300000);
    for (uint32_t& index : indices)
      index = every == 1 ? static_cast<uint32_t>(&index - indices.data()) % kVertices
                         : 1000 + random() % ((kVertices - 1000) / every) * every;
    std::vector<uint32_t> used(indices);
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const size_t threads : kThreads) {
      std::vector<uint32_t> compact(indices);
      const std::vector<uint32_t> found =
          with_threads(threads, [&] { return gltf::compact_vertices(compact, kVertices); });
      if (used.size() == kVertices) {
        EXPECT_TRUE(found.empty());
        EXPECT_EQ(compact, indices);
        continue;
      }
      EXPECT_EQ(found, used);
      for (size_t i = 0; i < indices.size(); ++i) ASSERT_EQ(used[compact[i]], indices[i]) << i;
    }
  }
}

TEST(Triangles, FindsFirstIndexOutOfBounds) {
  std::vector<uint32_t> indices(200000, 6);
  EXPECT_FALSE(gltf::first_out_of_bounds({}, 0).has_value());
  EXPECT_FALSE(gltf::first_out_of_bounds(indices, 7).has_value());
  indices[150001] = 7;
  indices[40002] = 8;
  for (const size_t threads : kThreads)
    EXPECT_EQ(with_threads(threads, [&] { return gltf::first_out_of_bounds(indices, 7); }), 40002U);
}

// Returns a bumpy grid that uses every second row of its vertices; some need repair.
json grid(GltfBuilder& builder, int cells, int mode) {
  const auto side = static_cast<size_t>(cells) + 1;
  std::vector<float> positions, normals, texcoords;
  std::mt19937 random(static_cast<uint32_t>(cells));
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  for (size_t y = 0; y < 2 * side; ++y)
    for (size_t x = 0; x < side; ++x) {
      positions.insert(positions.end(), {static_cast<float>(x), static_cast<float>(y), uniform()});
      const bool bad = (x + y) % 97 == 5;
      normals.insert(normals.end(), {0.0f, bad ? 0.0f : 0.1f * uniform(), bad ? 0.0f : 1.0f});
      texcoords.insert(texcoords.end(), {uniform(), static_cast<float>(y)});
    }
  std::vector<uint32_t> indices;
  for (size_t y = 0; y < static_cast<size_t>(cells); ++y)
    for (size_t x = 0; x < static_cast<size_t>(cells); ++x) {
      const auto a = static_cast<uint32_t>(2 * y * side + x), b = a + static_cast<uint32_t>(2 * side);
      indices.insert(indices.end(), {a, a + 1, b, b, a + 1, b + 1});
    }
  json primitive;
  primitive["attributes"]["POSITION"] = builder.accessor(positions, kFloat, "VEC3");
  primitive["attributes"]["NORMAL"] = builder.accessor(normals, kFloat, "VEC3");
  primitive["attributes"]["TEXCOORD_0"] = builder.accessor(texcoords, kFloat, "VEC2");
  primitive["indices"] = builder.accessor(indices, kUnsignedInt, "SCALAR");
  primitive["mode"] = mode;
  return primitive;
}

GltfBuilder grids() {
  GltfBuilder builder = triangle();
  builder.push("materials", {{"normalTexture", {{"index", 0}}}});
  builder.push("materials", {{"normalTexture", {{"index", 0}, {"texCoord", 3}}}, {"name", "without coordinates"}});
  builder.push("textures", {{"source", 0}});
  builder.push("images", {{"bufferView", builder.view(from_base64(kPngBase64))}, {"mimeType", "image/png"}});
  json primitives = json::array();
  for (int i = 0; i < 6; ++i) {
    json primitive = grid(builder, i == 0 ? 200 : 20 + i, 4 + i % 3);
    primitive["material"] = i % 2;
    primitives.push_back(primitive);
    primitives.push_back({{"attributes", primitive["attributes"]}, {"mode", i % 4}}); // points and lines
  }
  builder.push("meshes", {{"primitives", primitives}});
  builder.root_node({{"mesh", 1}});
  return builder;
}

template <typename T>
void expect_same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  ASSERT_EQ(a.size(), b.size());
  if (!a.empty()) {
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(T)), 0);
  }
}

TEST(ThreadCount, DoesNotChangeScenes) {
  const TempFolder folder;
  const std::filesystem::path path = folder.write("grids.glb", grids().glb());
  const Loaded one = with_threads(1, [&] { return load_file(path); });
  ASSERT_TRUE(one.scene) << one.error;
  ASSERT_GE(one.warnings.size(), 2U);
  for (int round = 0; round < 3; ++round) {
    const Loaded four = with_threads(4, [&] { return load_file(path); });
    ASSERT_TRUE(four.scene);
    EXPECT_EQ(one.warnings, four.warnings);
    EXPECT_EQ(one.scene->content_hash, four.scene->content_hash);
    ASSERT_EQ(one.scene->meshes.size(), four.scene->meshes.size());
    for (size_t m = 0; m < one.scene->meshes.size(); ++m) {
      const Mesh &a = one.scene->meshes[m], &b = four.scene->meshes[m];
      ASSERT_EQ(a.primitives.size(), b.primitives.size());
      for (size_t p = 0; p < a.primitives.size(); ++p) {
        SCOPED_TRACE(p);
        expect_same_bits(a.primitives[p].positions, b.primitives[p].positions);
        expect_same_bits(a.primitives[p].normals, b.primitives[p].normals);
        expect_same_bits(a.primitives[p].tangents, b.primitives[p].tangents);
        expect_same_bits(a.primitives[p].indices, b.primitives[p].indices);
        ASSERT_EQ(a.primitives[p].texcoords.size(), b.primitives[p].texcoords.size());
        for (size_t set = 0; set < a.primitives[p].texcoords.size(); ++set)
          expect_same_bits(a.primitives[p].texcoords[set], b.primitives[p].texcoords[set]);
        expect_same_bits(a.primitives[p].stroke_offsets, b.primitives[p].stroke_offsets);
        EXPECT_EQ(a.primitives[p].stroke != Stroke::none, p % 2 == 1);
        EXPECT_EQ(a.primitives[p].tangents.empty(), p % 4 != 0 || m == 0);
      }
    }
  }
}

TEST(ThreadCount, DoesNotChangeErrors) {
  GltfBuilder builder = grids();
  const int bad = builder.accessor<uint8_t>({0, 1, 255, 2, 1, 255}, kUnsignedByte, "SCALAR");
  const int short_list = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3");
  for (const int primitive : {4, 6, 10}) {
    json& broken = builder.root["meshes"][1]["primitives"][static_cast<size_t>(primitive)];
    broken["indices"] = bad;
    broken["attributes"] = {{"POSITION", short_list}};
  }
  for (int round = 0; round < 3; ++round)
    for (const size_t threads : kThreads)
      EXPECT_EQ(with_threads(threads, [&] { return load(builder); }).error,
                "/meshes/1/primitives/4/indices: index 255 at 2, there are 3 vertices (ACCESSOR_INDEX_OOB)");
}

} // namespace
} // namespace kindling::test
