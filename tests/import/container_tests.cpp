// Files, containers, buffers and URIs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/file_bytes.h"
#include "renderer/import/files/number_range.h"
#include "renderer/import/files/other_formats.h"
#include "renderer/import/files/uri.h"
#include "renderer/import/files/utf8.h"
#include "tests/import/gltf_builder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace kindling::test {
namespace {

size_t triangle_count(const Loaded& loaded) {
  return loaded.scene && !loaded.scene->meshes.empty() && !loaded.scene->meshes[0].primitives.empty()
             ? loaded.scene->meshes[0].primitives[0].triangle_count()
             : 0;
}

std::string_view span_text(const Result<gltf::OwnedBytes>& bytes) { return gltf::as_text(bytes.value().span()); }

TEST(Hash, EqualsPublishedXxh64) {
  // XXH64 with seed 0 of "", "a" and one input of more than 32 bytes, from the reference
  // implementation.
  const auto hash = [](std::string_view text) {
    return gltf::hash_bytes(std::as_bytes(std::span(text.data(), text.size())));
  };
  EXPECT_EQ(hash(""), 0xef46db3751d8e999ULL);
  EXPECT_EQ(hash("a"), 0xd24ec4f1a98c6e5bULL);
  EXPECT_EQ(hash("The quick brown fox jumps over the lazy dog"), 0x0b242d361fda71bcULL);
}

TEST(Uri, DecodesPercent) {
  EXPECT_EQ(gltf::percent_decode("a%20b%C3%A4%41"), "a b\xc3\xa4"
                                                    "A");
  EXPECT_EQ(gltf::percent_decode("100%"), "100%");
  EXPECT_EQ(gltf::percent_decode("%zz%2"), "%zz%2");
}

TEST(Uri, DecodesData) {
  EXPECT_EQ(span_text(gltf::decode_data_uri("data:;base64,aGVsbG8=")), "hello");
  EXPECT_EQ(span_text(gltf::decode_data_uri("DATA:text/plain;BASE64,aGVsbG8")), "hello");
  EXPECT_EQ(span_text(gltf::decode_data_uri("data:;base64,aGVsbG8%3D")), "hello");
  EXPECT_EQ(span_text(gltf::decode_data_uri("data:,a%20b")), "a b");
  EXPECT_EQ(span_text(gltf::decode_data_uri("data:,")), "");
  EXPECT_FALSE(gltf::decode_data_uri("data:;base64,####").ok());
  EXPECT_FALSE(gltf::decode_data_uri("data:;base64,a").ok());
  EXPECT_FALSE(gltf::decode_data_uri("data:;base64").ok());
}

TEST(Uri, RefusesPathsOutsideTheFolder) {
  const std::filesystem::path folder = "/scenes";
  EXPECT_EQ(gltf::resolve_uri(folder, "a/b%20c.bin").value(), folder / "a/b c.bin");
  EXPECT_EQ(gltf::resolve_uri(folder, "..a/b...bin").value(), folder / "..a/b...bin");
  for (const char* bad : {"../a.bin", "a/../../b.bin", "%2e%2e/a.bin", "a\\..\\b", "..", "/etc/passwd", "%2Fetc/passwd",
                          "file:///etc/passwd", "http://example.com/a.bin", "C:/a.bin", "\\\\server\\a", "", "a%00b"}) {
    EXPECT_FALSE(gltf::resolve_uri(folder, bad).ok()) << bad;
  }
}

TEST(Container, NamesAConverterForOtherFormats) {
  const auto described = [](std::string_view text, const char* name) {
    return gltf::describe_other_format(std::as_bytes(std::span(text.data(), text.size())), name);
  };
  EXPECT_EQ(described("ply\nformat ascii 1.0\n", "house.gltf"), "a PLY file, not glTF; rename it to house.ply");
  EXPECT_EQ(described("#usda 1.0\n", "house.scene"),
            "a USD file, not glTF; convert it with Blender (File > Export > glTF 2.0)");
  EXPECT_EQ(described("PK\x03\x04", "Toy.USDZ"),
            "a USDZ archive, not glTF; convert it with Blender (File > Export > glTF 2.0)");
  EXPECT_EQ(described(" {\"asset\": {}}", "named.obj"), "");
  EXPECT_EQ(described("hello", "a.gltf"), "");
}

TEST(Container, GltfWithDataUriEqualsGlb) {
  const GltfBuilder builder = triangle();
  const Loaded text = load(builder);
  const Loaded binary = load_text(builder.glb(), {}, "test.glb");
  EXPECT_EQ(triangle_count(text), 1U) << text.error;
  EXPECT_EQ(triangle_count(binary), 1U) << binary.error;
  EXPECT_EQ(text.scene->meshes[0].primitives[0].positions, binary.scene->meshes[0].primitives[0].positions);
  EXPECT_TRUE(text.warnings.empty());
}

TEST(Container, DetectsGlbByMagicBytes) { EXPECT_EQ(triangle_count(load_text(triangle().glb(), {}, "test.gltf")), 1U); }

TEST(Container, ReadsExternalBuffersOfAnyName) {
  const TempFolder folder;
  for (const auto& [uri, file] :
       {std::pair("plain.bin", "plain.bin"), std::pair("with%20space.bin", "with space.bin"),
        std::pair("sub/M%C3%BCll%E2%99%BB.bin", "sub/M\xc3\xbcll\xe2\x99\xbb.bin"),
        std::pair("raw \xe2\x9d\xa4.bin", "raw \xe2\x9d\xa4.bin"), std::pair("50%25.bin", "50%.bin")}) {
    GltfBuilder builder = triangle();
    builder.root["buffers"] = json::array({json{{"byteLength", builder.bin.size()}, {"uri", uri}}});
    folder.write(file, builder.bin);
    const Loaded loaded = load_file(folder.write("test.gltf", builder.gltf()));
    EXPECT_EQ(triangle_count(loaded), 1U) << uri << ": " << loaded.error;
  }
}

TEST(Container, ContentHashCoversEveryFile) {
  const TempFolder folder;
  GltfBuilder builder = triangle();
  builder.root["buffers"] = json::array({json{{"byteLength", builder.bin.size()}, {"uri", "a.bin"}}});
  folder.write("a.bin", builder.bin);
  const auto path = folder.write("test.gltf", builder.gltf());
  const uint64_t first = load_file(path).scene->content_hash;
  EXPECT_EQ(load_file(path).scene->content_hash, first);
  builder.bin[4] = 'x';
  folder.write("a.bin", builder.bin);
  EXPECT_NE(load_file(path).scene->content_hash, first);
}

TEST(Container, RefusesBuffersOutsideTheFolder) {
  for (const std::string uri : {"../a.bin", "/a.bin", "file:///a.bin", "http://example.com/a.bin"}) {
    GltfBuilder builder = triangle();
    builder.root["buffers"] = json::array({json{{"byteLength", builder.bin.size()}, {"uri", uri}}});
    const Loaded loaded = load(builder);
    EXPECT_EQ(loaded.kind, ErrorKind::scene_invalid);
    const bool relative = uri.starts_with("..");
    EXPECT_TRUE(loaded.error.starts_with(relative ? "/buffers/0/uri: '../a.bin' leaves the folder"
                                                  : "/buffers/0/uri: absolute URI '" + uri + "'"))
        << loaded.error;
  }
}

TEST(Container, ReportsUnreadableFiles) {
  const TempFolder folder;
  Loaded loaded = load_file(folder.path() / "absent.gltf");
  EXPECT_EQ(loaded.kind, ErrorKind::input_output);
  EXPECT_EQ(loaded.error, "no such file");
  std::filesystem::create_directory(folder.path() / "folder.gltf");
  loaded = load_file(folder.path() / "folder.gltf");
  EXPECT_EQ(loaded.kind, ErrorKind::input_output);
  EXPECT_EQ(loaded.error, "is not a regular file");

  GltfBuilder builder = triangle();
  builder.root["buffers"] = json::array({json{{"byteLength", builder.bin.size()}, {"uri", "absent.bin"}}});
  loaded = load(builder);
  EXPECT_EQ(loaded.kind, ErrorKind::input_output);
  EXPECT_EQ(loaded.error, "/buffers/0/uri: 'absent.bin' no such file (IO_ERROR)");
}

TEST(Container, RefusesBrokenGlb) {
  const std::string good = triangle().glb();
  const auto error = [&](auto&& change) {
    std::string bytes = good;
    change(bytes);
    return load_text(bytes, kStrict, "test.glb").error;
  };
  EXPECT_NE(error([](std::string& b) { b.clear(); }).find("GLB_UNEXPECTED_END_OF_HEADER"), std::string::npos);
  EXPECT_NE(error([](std::string& b) { b[0] = 'x'; }).find("GLB_INVALID_MAGIC"), std::string::npos);
  EXPECT_NE(error([](std::string& b) { b[4] = 1; }).find("GLB_INVALID_VERSION"), std::string::npos);
  EXPECT_NE(error([](std::string& b) { b.pop_back(); }).find("GLB_LENGTH_MISMATCH"), std::string::npos);
  EXPECT_NE(error([](std::string& b) { b[14] = 1; }).find("GLB_CHUNK_TOO_BIG"), std::string::npos);
  EXPECT_NE(error([](std::string& b) { b[16] = 'X'; }).find("GLB_UNEXPECTED_FIRST_CHUNK"), std::string::npos);
  const std::string text = make_glb(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4}]})", "");
  EXPECT_NE(load_text(text, kStrict, "test.glb").error.find("BUFFER_MISSING_GLB_DATA"), std::string::npos);
}

TEST(Container, ReplacesBytesThatAreNotUtf8) {
  const auto repaired = [](std::string_view text) { return gltf::replace_invalid_utf8(text); };
  for (const char* valid :
       {"", "abc", "\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x98\x80", "\xf4\x8f\xbf\xbf", "\xee\x80\x80"})
    EXPECT_EQ(repaired(valid), valid);
  const std::string bad = "\xef\xbf\xbd";
  EXPECT_EQ(repaired("a\xe9z"), "a" + bad + "z");
  EXPECT_EQ(repaired("\xe2\x82"), bad); // one start, cut off
  EXPECT_EQ(repaired("\xe2\x82z"), bad + "z");
  EXPECT_EQ(repaired("\xc0\x80"), bad + bad);                     // longer than needed
  EXPECT_EQ(repaired("\xe0\x80\x80"), bad + bad + bad);           // likewise
  EXPECT_EQ(repaired("\xed\xa0\x80"), bad + bad + bad);           // a surrogate
  EXPECT_EQ(repaired("\xf4\x90\x80\x80"), bad + bad + bad + bad); // above U+10FFFF
  EXPECT_EQ(repaired("\x80\xff"), bad + bad);
}

TEST(Container, WarnsOfTrailingBytes) {
  const Loaded loaded = load_text(triangle().glb() + "tail", {}, "test.glb");
  EXPECT_EQ(triangle_count(loaded), 1U);
  EXPECT_TRUE(loaded.warned("GLB_EXTRA_DATA"));
}

TEST(Container, RefusesOtherVersions) {
  EXPECT_EQ(
      load_text(R"({"asset":{"version":"1.0"}})").error,
      "/asset/version: glTF 1.0, expected 2.0; convert it with gltf-pipeline (npm): gltf-pipeline -i test.gltf -o "
      "test_2.glb (UNKNOWN_ASSET_MAJOR_VERSION)");
  EXPECT_EQ(load_text(R"({"asset":{"version":"two"}})").error,
            "/asset/version: 'two', expected a version like 2.0 (PATTERN_MISMATCH)");
  EXPECT_TRUE(load_text(R"({"asset":{"version":"2.7"}})").scene);
  EXPECT_FALSE(load_text(R"({"asset":{"version":"2.7","minVersion":"2.1"}})").scene);
  EXPECT_EQ(load_text("{}").error, "'asset' is missing (UNDEFINED_PROPERTY)");
}

TEST(Container, NumbersThatOverflowAreLimited) {
  using gltf::limit_numbers;
  constexpr const char* kMax = "1.7976931348623157e308";
  EXPECT_EQ(limit_numbers(R"({"a":[1e309,-1E+400,1e308,1e-400,-0.5]})"),
            fmt::format(R"({{"a":[{},-{},1e308,1e-400,-0.5]}})", kMax, kMax));
  EXPECT_EQ(limit_numbers(R"({"1e309":"1e309 \\\" 1e309","b":)" + std::string(400, '7') + "}"),
            fmt::format(R"({{"1e309":"1e309 \\\" 1e309","b":{}}})", kMax));
  for (const char* unchanged : {R"("1e309)", R"("\)", "-", ""}) EXPECT_EQ(limit_numbers(unchanged), unchanged);
  GltfBuilder builder = triangle();
  builder.root["nodes"][0]["extras"] = "MARK";
  std::string text = builder.gltf();
  text.replace(text.find("\"MARK\""), 6, "1e400");
  EXPECT_EQ(load_text(text).error.rfind("not valid JSON: ", 0), 0U) << load_text(text).error;
  const Loaded loaded = load_text(text, kLenient);
  EXPECT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warned("number overflow parsing '1e400' (INVALID_JSON); the largest number is used"));
}

TEST(Container, ErrorsOfLongTextsAreShort) {
  const std::string text = R"({"asset":{"version":"2.0"},"extras":)" + std::string(20000, '[') + "\u00e9x";
  const std::string error = load_text(text).error;
  EXPECT_EQ(error.rfind("not valid JSON: parse error at line 1, column 20037", 0), 0U) << error;
  EXPECT_LT(error.size(), 300U);
  EXPECT_NE(error.find(" ... "), std::string::npos) << error;
}

TEST(Container, SurvivesDeepJson) {
  const size_t depth = 200000;
  const std::string deep = std::string(depth, '[') + std::string(depth, ']');
  EXPECT_TRUE(load_text(R"({"asset":{"version":"2.0"},"extras":)" + deep + "}").scene);
  EXPECT_FALSE(load_text(std::string(depth, '[')).scene);
  EXPECT_FALSE(load_text(std::string(depth, '{')).scene);
}

TEST(Container, EnforcesLimits) {
  const GltfBuilder builder = triangle();
  ImportOptions options;
  options.limits.max_file_bytes = 100;
  EXPECT_EQ(load(builder, options).kind, ErrorKind::input_output);
  options = {};
  options.limits.max_json_bytes = 100;
  EXPECT_NE(load(builder, options).error.find("at most 100 are accepted"), std::string::npos);
  options = {};
  options.limits.max_total_elements = 5;
  EXPECT_NE(load(builder, options).error.find("at most 5 are accepted"), std::string::npos);
  options = {};
  options.limits.max_nodes = 0;
  EXPECT_NE(load(builder, options).error.find("/nodes: 1 nodes, at most 0"), std::string::npos);
}

TEST(Container, RefusesHugeSceneFromSmallFile) {
  GltfBuilder builder;
  // A billion points without data in the file.
  const int position = builder.push("accessors", {{"componentType", kFloat}, {"count", 1000000000}, {"type", "VEC3"}});
  builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}})}});
  EXPECT_NE(load(builder).error.find("are accepted for a file of this size"), std::string::npos);
}

TEST(Container, RefusesManyVerticesWithoutData) {
  GltfBuilder builder;
  const int position = builder.push("accessors", {{"componentType", kFloat}, {"count", 4000000000}, {"type", "VEC3"}});
  const int indices = builder.accessor<uint32_t>({0, 1, 3999999999U}, kUnsignedInt, "SCALAR");
  builder.root_node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}, {"indices", indices}})}});
  EXPECT_NE(load(builder).error.find("are accepted for a file of this size"), std::string::npos);
}

TEST(Container, LoadsRepeatedElementsInLinearTime) {
  // Each of these takes minutes if some step is quadratic.
  GltfBuilder builder;
  for (int i = 0; i < 30000; ++i) {
    builder.push("images", {{"uri", "absent" + std::to_string(i) + ".png"}});
    builder.push("textures", {{"source", i}});
    builder.push("materials", {{"emissiveTexture", {{"index", i}}}});
    builder.push("nodes", json::object());
    builder.push("scenes", {{"nodes", {i}}});
  }
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  ASSERT_EQ(loaded.warnings.size(), 101U);
  EXPECT_EQ(loaded.warnings.back(), "and 29900 other warnings");
}

TEST(Container, AcceptsByteOrderMarkAndIntegersAsFloats) {
  GltfBuilder builder = triangle();
  builder.root["scene"] = 0.0;
  builder.root["nodes"][0]["mesh"] = 0.0;
  EXPECT_EQ(triangle_count(load_text("\xef\xbb\xbf" + builder.gltf())), 1U);
}

} // namespace
} // namespace kindling::test
