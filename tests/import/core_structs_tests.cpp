// tinygltf's structs from a parsed JSON tree: their content, and the unchanged tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/core_structs.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kindling::gltf {
namespace {

using nlohmann::json;

TEST(CoreStructs, LeavesTreeUnchanged) {
  for (const bool with_views : {true, false}) {
    json root = json::parse(R"({
      "asset": {"version": "2.0", "generator": "test", "extras": [1]},
      "extensionsUsed": ["KHR_lights_punctual"],
      "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
      "buffers": [{"byteLength": 12}],
      "accessors": [{"componentType": 5125, "count": 3, "type": "SCALAR", "extras": {"a": 1}},
                    {"componentType": 5126, "count": 3, "type": "VEC3"}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
      "nodes": [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}],
      "animations": [{"samplers": [{"input": 1, "output": 1}],
                      "channels": [{"sampler": 0, "target": {"path": "pointer"}}]}]})");
    if (with_views) root["bufferViews"] = json::parse(R"([{"buffer": 0, "byteLength": 12.0}])");
    if (with_views) root["extras"] = {{"id", 7}};
    Warnings warnings(true);
    const CorePlaces places = check_json(root, warnings);
    const json checked = root;
    const tinygltf::Model core = read_core_structs(root, places);
    EXPECT_EQ(root, checked);

    EXPECT_EQ(core.asset.generator, "test");
    EXPECT_EQ(core.bufferViews.size(), with_views ? 1U : 0U);
    ASSERT_EQ(core.accessors.size(), 2U);
    EXPECT_EQ(core.accessors[0].bufferView, -1);
    ASSERT_EQ(core.meshes.size(), 1U);
    EXPECT_EQ(core.meshes[0].primitives[0].indices, 0);
    ASSERT_EQ(core.animations.size(), 1U);
    ASSERT_EQ(core.animations[0].channels.size(), 1U);
    EXPECT_EQ(core.animations[0].channels[0].target_node, -1);
    EXPECT_TRUE(core.buffers.empty());
    EXPECT_TRUE(core.lights.empty());
    EXPECT_TRUE(core.nodes[0].extensions.empty());
  }
}

} // namespace
} // namespace kindling::gltf
