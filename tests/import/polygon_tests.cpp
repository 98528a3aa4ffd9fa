// Meshes from .ply, .obj and .stl files: the same tetrahedron in every form, and broken files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/load_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include <unistd.h>

namespace kindling {
namespace {

// Keeps the warnings.
class Recorder : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot& /*snapshot*/) override {}
  void on_warning(std::string_view message) override { warnings.emplace_back(message); }
  void on_info(std::string_view /*message*/) override {}
  std::vector<std::string> warnings;
};

class Polygons : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / ("kindling_polygons_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Result<Scene> load(const std::string& name, const std::string& contents, const ImportOptions& options = {}) {
    std::ofstream(folder_ / name, std::ios::binary) << contents;
    recorder_ = {};
    return load_scene(folder_ / name, options, &recorder_);
  }
  // The error without the path of the file; empty if it loads.
  std::string error(const std::string& name, const std::string& contents, const ImportOptions& options = {}) {
    const Result<Scene> scene = load(name, contents, options);
    if (scene.ok()) return {};
    const std::string prefix = (folder_ / name).string() + ": ";
    EXPECT_TRUE(scene.error().message.starts_with(prefix)) << scene.error().message;
    return scene.error().message.substr(prefix.size());
  }
  // Four triangles over four vertices, by position.
  void expect_tetrahedron(const std::string& name, const std::string& contents) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = load(name, contents);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    ASSERT_EQ(scene.value().meshes.size(), 1U);
    const Primitive& primitive = scene.value().meshes[0].primitives.at(0);
    EXPECT_EQ(primitive.positions.size(), 4U);
    ASSERT_EQ(primitive.triangle_count(), 4U);
    V3f sum(0.0f);
    for (const uint32_t index : primitive.indices) sum += primitive.positions.at(index);
    EXPECT_EQ(sum, V3f(3.0f, 6.0f, 9.0f)); // each of the three other vertices three times
    EXPECT_TRUE(recorder_.warnings.empty());
    EXPECT_EQ(scene.value().materials.at(0).metallic_factor, 0.0f);
    EXPECT_TRUE(scene.value().materials[0].double_sided);
    EXPECT_NE(scene.value().content_hash, 0U);
  }

  std::filesystem::path folder_;
  Recorder recorder_;
};

const char* const kVertices[] = {"0 0 0", "1 0 0", "0 2 0", "0 0 3"};
constexpr float kPositions[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
constexpr uint32_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

template <typename Number>
std::string bytes(Number number, bool turned = false) {
  std::string text(sizeof number, '\0');
  std::memcpy(text.data(), &number, sizeof number);
  if (turned) std::reverse(text.begin(), text.end());
  return text;
}

std::string ply_header(const std::string& format, int vertices, int faces, const std::string& more = {}) {
  return "ply\nformat " + format + " 1.0\ncomment made for a test\nelement vertex " + std::to_string(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\n" + more + "element face " + std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string text_ply() {
  std::string text = ply_header("ascii", 4, 4);
  for (const char* vertex : kVertices) text += std::string(vertex) + "\n";
  for (const auto& f : kFaces)
    text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
  return text;
}

std::string binary_ply(bool big) {
  std::string file = ply_header(big ? "binary_big_endian" : "binary_little_endian", 4, 4);
  for (const auto& p : kPositions)
    for (const float x : p) file += bytes(x, big);
  for (const auto& f : kFaces) {
    file += bytes(uint8_t{3});
    for (const uint32_t index : f) file += bytes(static_cast<int32_t>(index), big);
  }
  return file;
}

std::string obj() {
  std::string text = "# a comment\nmtllib none.mtl\no thing\n";
  for (const char* vertex : kVertices) text += "v " + std::string(vertex) + "\r\n";
  return text + "f 1 3 2\nf 1 2 4\nf -4 -1 -2\ns off\nf 2/ 3/ 4/\n";
}

std::string text_stl() {
  std::string text = "solid thing\n";
  for (const auto& f : kFaces) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const uint32_t index : f) text += std::string("  vertex ") + kVertices[index] + "\n";
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid thing\n";
}

std::string binary_stl(const std::string& begin = "") {
  std::string file = begin + std::string(80 - begin.size(), ' ') + bytes(uint32_t{4});
  for (const auto& f : kFaces) {
    file += std::string(12, '\0');
    for (const uint32_t index : f)
      for (const float x : kPositions[index]) file += bytes(x);
    file += std::string(2, '\0');
  }
  return file;
}

TEST_F(Polygons, AllFormsHoldTheSameMesh) {
  expect_tetrahedron("a.ply", text_ply());
  expect_tetrahedron("b.PLY", binary_ply(false));
  expect_tetrahedron("c.ply", binary_ply(true));
  expect_tetrahedron("d.obj", obj());
  expect_tetrahedron("e.stl", text_stl());
  expect_tetrahedron("f.Stl", binary_stl());
  expect_tetrahedron("g.stl", binary_stl("solid by an exporter"));
}

TEST_F(Polygons, PlyPropertiesAreReadByName) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement camera 1\nproperty float f\nproperty list uchar short l\nelement vertex 4\n"
      "property double z\nproperty float y\nproperty float x\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n"
      "element face 1\nproperty uchar flags\nproperty list uint ushort vertex_index\nend_header\n";
  const Result<Scene> scene =
      load("a.ply", header + "7 2 1 1\n3 2 1 0 0 5 255 0 128 .25 .5\n3 2 2 0 0 5 255 0 128 .25 .5\n"
                             "3 3 2 0 0 5 255 0 128 .25 .5\n3 3 1 0 0 5 255 0 128 .25 .5\n9 4 0 1 2 3\n");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const Primitive& primitive = scene.value().meshes[0].primitives[0];
  EXPECT_EQ(primitive.positions.at(0), V3f(1, 2, 3));
  EXPECT_EQ(primitive.normals.at(3), V3f(0, 0, 1));
  EXPECT_EQ(primitive.texcoords.at(0).at(0), V2f(0.25f, 0.5f));
  EXPECT_EQ(primitive.colors.at(0)[0], 1.0f);
  EXPECT_NEAR(primitive.colors.at(0)[2], 0.2158f, 1e-3f);
  EXPECT_EQ(primitive.indices, (std::vector<uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(scene.value().materials[0].base_color_factor[0], 1.0f);
}

TEST_F(Polygons, ObjCornersBecomeVertices) {
  const Result<Scene> scene =
      load("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\nvn 0 0 2\nvn 0 1 0\n"
                    "f 1/1/1 2/2/1 3/2/1 4/1/1\nf 1/1/2 2/2/2 3/2/2 # again\n");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const Primitive& primitive = scene.value().meshes[0].primitives[0];
  EXPECT_EQ(primitive.positions.size(), 7U); // corners with another normal are others
  EXPECT_EQ(primitive.triangle_count(), 3U);
  EXPECT_EQ(primitive.normals.at(0), V3f(0, 0, 1));
  EXPECT_EQ(primitive.texcoords.at(0).at(1), V2f(1.0f, 0.75f));
}

TEST_F(Polygons, BrokenPlyFilesAreRefused) {
  EXPECT_EQ(error("a.ply", ""), "the file is empty");
  EXPECT_EQ(error("a.ply", "plyx\n"), "line 1: expected 'ply'");
  EXPECT_EQ(error("a.ply", "ply\nformat ascii 1.0\n"), "the header has no end_header");
  EXPECT_EQ(error("a.ply", "ply\nformat morse 1.0\nend_header\n"),
            "line 2: format 'morse', expected ascii, binary_little_endian or binary_big_endian");
  EXPECT_EQ(error("a.ply", "ply\nproperty float x\nend_header\n"), "line 2: a property before any element");
  EXPECT_EQ(error("a.ply", ply_header("ascii", 4, 4, "property quad w\n")),
            "line 8: type 'quad', expected char, uchar, short, ushort, int, uint, float or double");
  const std::string text = text_ply(), binary = binary_ply(false);
  EXPECT_EQ(error("a.ply", text.substr(0, text.size() - 4)), "the file ends within 'face' 3 of 4");
  EXPECT_EQ(error("a.ply", binary.substr(0, binary.size() - 4)), "the file ends within 'face' 3 of 4");
  EXPECT_NE(
      error("a.ply", ply_header("binary_little_endian", 2000000000, 4)).find("declares 2000000000 of 'vertex', at "),
      std::string::npos);
  EXPECT_EQ(error("a.ply", ply_header("ascii", -1, 4)), "line 4: '-1', expected a count");
  EXPECT_EQ(error("a.ply", ply_header("ascii", 3, 1) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "face 0: index 3; there are 3 vertices");
  EXPECT_EQ(error("a.ply", ply_header("ascii", 3, 1) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
            "face 0: index -1; there are 3 vertices");
  EXPECT_EQ(error("a.ply", ply_header("ascii", 3, 1) + "0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n"),
            "line 12: 'x', expected a number of 'vertex' 1");
  EXPECT_NE(
      error("a.ply", ply_header("ascii", 3, 1) + "0 0 0\n1 0 0\n0 1 0\n200 0 1 2\n").find("a list of 200 numbers"),
      std::string::npos);
  EXPECT_NE(error("a.ply", ply_header("ascii", 1, 0) + "0 0 0\n").find("vertices without polygons (a point cloud?)"),
            std::string::npos);
}

TEST_F(Polygons, BrokenObjFilesAreRefused) {
  EXPECT_EQ(error("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), "line 4: index 4; there are 3 vertices so far");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf 0 1 1\n"), "line 2: index 0; there are 1 vertices so far");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf -2 1 1\n"), "line 2: index -2; there are 1 vertices so far");
  EXPECT_EQ(error("a.obj", "v 0 0\n"), "line 1: '', expected 3 numbers");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf 1/1 1 1\n"), "line 2: index 1; there are 0 texture coordinates so far");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nf 1/2/3/4 1 1\n"), "line 2: '1/2/3/4', expected v/vt/vn");
  EXPECT_EQ(error("a.obj", "hello\n"), "no vertices and no polygons; a mesh of triangles or polygons is needed");
}

TEST_F(Polygons, BrokenStlFilesAreRefused) {
  const std::string binary = binary_stl(), text = text_stl();
  EXPECT_EQ(error("a.stl", binary.substr(0, binary.size() - 60)),
            "224 bytes, but 284 go with the 4 facets that it declares");
  EXPECT_EQ(error("a.stl", "short"), "5 bytes; a binary STL file has at least 84, one of text begins with 'solid'");
  EXPECT_EQ(error("a.stl", text.substr(0, text.rfind(" endloop"))), "line 27: the file ends within a facet");
  EXPECT_EQ(error("a.stl", "solid\nvertex 0 0 0\n"),
            "line 2: a vertex outside of a loop; 'outer loop' is expected before");
  EXPECT_EQ(error("a.stl", "solid\nouter loop\nvertex 0 0 z\n"), "line 3: 'z', expected three numbers");
}

// Every prefix of a file, and every file with one byte changed, loads or is refused in one line.
TEST_F(Polygons, DamagedFilesDoNoHarm) {
  const std::pair<const char*, std::string> files[] = {{"a.ply", text_ply()},       {"a.ply", binary_ply(false)},
                                                       {"a.ply", binary_ply(true)}, {"a.obj", obj()},
                                                       {"a.stl", text_stl()},       {"a.stl", binary_stl()}};
  const auto check = [&](const char* name, const std::string& contents) {
    const Result<Scene> scene = load(name, contents);
    if (!scene.ok()) {
      EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
      return;
    }
    const Primitive& primitive = scene.value().meshes[0].primitives[0];
    for (const uint32_t index : primitive.indices) ASSERT_LT(index, primitive.positions.size());
  };
  for (const auto& [name, contents] : files)
    for (size_t i = 0; i < contents.size(); ++i) {
      check(name, contents.substr(0, i));
      std::string changed = contents;
      changed[i] = static_cast<char>(changed[i] ^ (1 << i % 8));
      check(name, changed);
    }
}

TEST_F(Polygons, RepairsAreReported) {
  const std::string text = ply_header("ascii", 4, 3) + "0 0 0\n1 0 0\n0 1 0\nnan 0 0\n3 0 1 2\n3 0 1 3\n2 0 1\n";
  const Result<Scene> scene = load("a.ply", text);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value().meshes[0].primitives[0].triangle_count(), 1U);
  ASSERT_EQ(recorder_.warnings.size(), 2U);
  EXPECT_NE(recorder_.warnings[0].find("face 2: a polygon of 2 corners"), std::string::npos) << recorder_.warnings[0];
  EXPECT_NE(recorder_.warnings[1].find("1 of 4 positions are not finite"), std::string::npos) << recorder_.warnings[1];
  ImportOptions strict;
  strict.strict = true;
  EXPECT_NE(error("a.ply", text, strict).find("a polygon of 2 corners"), std::string::npos);
}

TEST_F(Polygons, LimitsHold) {
  ImportOptions small;
  small.limits.max_total_elements = 10;
  EXPECT_NE(error("a.ply", text_ply(), small).find("at most 10 are accepted"), std::string::npos);
  EXPECT_NE(error("a.obj", obj(), small).find("at most 10 are accepted"), std::string::npos);
  EXPECT_NE(error("a.stl", binary_stl(), small).find("at most 10 are accepted"), std::string::npos);
  small = {};
  small.limits.max_file_bytes = 20;
  EXPECT_NE(error("a.obj", obj(), small), "");
}

TEST_F(Polygons, OtherFilesAreGltf) {
  EXPECT_NE(error("a.gltf", text_ply()).find("a PLY file, not glTF; rename it to a.ply"), std::string::npos);
  std::ofstream(folder_ / "a.ply") << text_ply();
  const auto files = list_scene_files(folder_ / "a.ply", {});
  ASSERT_TRUE(files.ok());
  EXPECT_EQ(files.value(), std::vector<std::filesystem::path>{folder_ / "a.ply"});
}

} // namespace
} // namespace kindling
