// Small files that ask for much memory are refused before it is allocated, whatever asks for it.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include "renderer/scene/pose.h"

#include <gtest/gtest.h>

#include <string>

namespace kindling::test {
namespace {

constexpr size_t kFloor = size_t{1} << 24; // ImportLimits::max_elements_of_small_file

// Expects a refusal at a place, also from a load that repairs other faults.
void expect_refused(const GltfBuilder& builder, const std::string& place) {
  for (const ImportOptions& options : {kStrict, kLenient}) {
    const Loaded loaded = load(builder, options);
    EXPECT_FALSE(loaded.scene) << place;
    EXPECT_EQ(loaded.kind, ErrorKind::scene_invalid);
    EXPECT_TRUE(loaded.error.starts_with(place)) << loaded.error;
    EXPECT_NE(loaded.error.find("are accepted for a file of this size"), std::string::npos) << loaded.error;
  }
}

int zeros(GltfBuilder& builder, size_t count, int component_type, const char* type) {
  return builder.push("accessors", {{"componentType", component_type}, {"count", count}, {"type", type}});
}

// A triangle and an animation whose channels share one sampler of `keys` keys.
GltfBuilder shared_keys(size_t keys, size_t channels) {
  GltfBuilder builder = triangle();
  std::vector<float> times(keys);
  for (size_t i = 0; i < keys; ++i) times[i] = static_cast<float>(i);
  const int input = builder.accessor(times, kFloat, "SCALAR");
  const int output = builder.accessor(std::vector<float>(4 * keys, 0.5f), kFloat, "VEC4");
  json list = json::array();
  for (size_t c = 0; c < channels; ++c)
    list.push_back({{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}});
  builder.push("animations",
               {{"samplers", json::array({json{{"input", input}, {"output", output}}})}, {"channels", list}});
  return builder;
}

TEST(ImportBudget, KeysCountForEachChannel) {
  constexpr size_t kKeys = 2000;
  EXPECT_TRUE(load(shared_keys(kKeys, 100)).scene);
  const size_t channels = kFloor / (5 * kKeys); // a time and four numbers for each key
  expect_refused(shared_keys(kKeys, channels + 1), "/animations/0/channels/");
}

// A mesh of vertices without data, on nodes with a skin or with a weight.
GltfBuilder deformed(size_t vertices, size_t nodes, bool skinned) {
  GltfBuilder builder;
  const int position = zeros(builder, vertices, kFloat, "VEC3");
  json primitive = {{"attributes", {{"POSITION", position}}}};
  if (skinned) {
    primitive["attributes"]["JOINTS_0"] = zeros(builder, vertices, kUnsignedShort, "VEC4");
    primitive["attributes"]["WEIGHTS_0"] = zeros(builder, vertices, kFloat, "VEC4");
  } else {
    primitive["targets"] = json::array({json{{"POSITION", position}}});
  }
  const int mesh = builder.mesh(primitive);
  builder.root_node({{"name", "joint"}});
  if (skinned) builder.push("skins", {{"joints", {0}}});
  for (size_t n = 0; n < nodes; ++n) {
    json node = {{"mesh", mesh}};
    if (skinned)
      node["skin"] = 0;
    else
      node["weights"] = {0.5};
    builder.root_node(std::move(node));
  }
  return builder;
}

TEST(ImportBudget, DeformedVerticesCountForEachNode) {
  constexpr size_t kVertices = 300000;
  for (const bool skinned : {true, false}) {
    EXPECT_TRUE(load(deformed(kVertices, 20, skinned), kLenient).scene);
    expect_refused(deformed(kVertices, 60, skinned), "/nodes/");
  }
}

// Each target in use is as much work as the vertices.
TEST(ImportBudget, MorphTargetsCountForEachNode) {
  constexpr size_t kVertices = 1000, kTargets = 200;
  const auto with_nodes = [](size_t nodes, float weight) {
    GltfBuilder builder;
    const int position = zeros(builder, kVertices, kFloat, "VEC3");
    const int target = builder.accessor(std::vector<float>(3 * kVertices, 0.25f), kFloat, "VEC3");
    const int mesh = builder.mesh(
        {{"attributes", {{"POSITION", position}}}, {"targets", std::vector<json>(kTargets, {{"POSITION", target}})}});
    builder.root["meshes"][0]["weights"] = std::vector<float>(kTargets, weight);
    for (size_t n = 0; n < nodes; ++n) builder.root_node({{"mesh", mesh}});
    return builder;
  };
  EXPECT_TRUE(load(with_nodes(20, 0.5f)).scene);
  expect_refused(with_nodes(100, 0.5f), "/nodes/");
  EXPECT_TRUE(load(with_nodes(100, 0.0f)).scene);
}

// Undeformed, they are instances of one mesh.
TEST(ImportBudget, NodesThatShareAMeshAreFree) {
  GltfBuilder builder;
  const int mesh = builder.mesh({{"attributes", {{"POSITION", zeros(builder, 300000, kFloat, "VEC3")}}}});
  for (int n = 0; n < 500; ++n) builder.root_node({{"mesh", mesh}});
  EXPECT_TRUE(load(builder).scene);
}

TEST(ImportBudget, JointsCount) {
  GltfBuilder builder = triangle();
  json joints = json::array();
  for (int i = 0; i < 1000; ++i) joints.push_back(0);
  for (int s = 0; s < 3; ++s) builder.push("skins", {{"joints", joints}});
  ImportOptions options = kLenient;
  EXPECT_TRUE(load(builder, options).scene);
  options.limits.max_elements_of_small_file = 10000;
  options.limits.elements_per_byte = 0;
  const Loaded loaded = load(builder, options);
  EXPECT_TRUE(loaded.error.starts_with("/skins/1/joints: ")) << loaded.error;
}

// `{}` has three bytes as text, and thousands as a struct.
TEST(ImportBudget, ObjectsCountByTheirSizeInMemory) {
  for (const auto& [name, count] : {std::pair("materials", size_t{60000}), std::pair("nodes", size_t{140000})}) {
    std::string text = std::string(R"({"asset":{"version":"2.0"},")") + name + R"(":[{})";
    for (size_t i = 1; i < count; ++i) text += ",{}";
    text += "]}";
    ImportOptions options = kLenient;
    const Loaded loaded = load_text(text, options);
    EXPECT_TRUE(loaded.error.starts_with(std::string("/") + name + ": ")) << loaded.error;
    EXPECT_NE(loaded.error.find("are accepted for a file of this size"), std::string::npos) << loaded.error;
  }
}

// All parts of a file share one budget.
TEST(ImportBudget, IsThatOfTheWholeFile) {
  GltfBuilder builder = shared_keys(1000, 10);
  ImportOptions options = kStrict;
  options.limits.elements_per_byte = 0;
  options.limits.max_elements_of_small_file = 1U << 20;
  ASSERT_TRUE(load(builder, options).scene);
  // The smallest budget that suffices, by bisection; less is refused at one place or another.
  uint64_t refused = 0, accepted = 1U << 20;
  while (accepted - refused > 1) {
    options.limits.max_elements_of_small_file = (refused + accepted) / 2;
    (load(builder, options).scene ? accepted : refused) = options.limits.max_elements_of_small_file;
  }
  const uint64_t keys = 10 * 1000 * 5;
  EXPECT_GT(accepted, keys); // and the objects and the mesh
  EXPECT_LT(accepted, keys + 2000);
}

} // namespace
} // namespace kindling::test
