// KHR_texture_procedurals: the draft's example, invalid graphs, and the fallback texture.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace kindling::test {
namespace {

constexpr const char* kName = "KHR_texture_procedurals";

json input(const char* name, const char* type, json rest) {
  json port = {{"name", name}, {"nodetype", "input"}, {"type", type}};
  port.update(rest);
  return port;
}

// Lists are vectors, because nlohmann::json reads a braced list of one object as that object.
using List = std::vector<json>;

json node(const char* kind, const char* type, const List& inputs = {}) {
  return {{"nodetype", kind},
          {"type", type},
          {"inputs", inputs},
          {"outputs", json::array({json{{"nodetype", "output"}, {"type", type}}})}};
}

json graph(const List& nodes, const char* type = "color3") {
  json output = {{"nodetype", "output"}, {"type", type}, {"node", nodes.size() - 1}};
  return {{"nodetype", "nodegraph"}, {"type", type}, {"nodes", nodes}, {"outputs", json::array({output})}};
}

// Returns a triangle whose base color is output `slot` of these graphs.
Loaded with_graphs(json graphs, json slot = {{"index", 0}}, bool required = false) {
  GltfBuilder builder;
  const json attributes = {{"POSITION", builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3")},
                           {"TEXCOORD_0", builder.accessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2")}};
  builder.root["extensionsUsed"] = {kName};
  if (required) builder.root["extensionsRequired"] = {kName};
  builder.root["extensions"][kName]["procedurals"] = std::move(graphs);
  builder.push("textures", {{"source", 0}});
  builder.push("images", {{"uri", "data:image/png;base64," + std::string(kPngBase64)}});
  builder.push("materials", {{"pbrMetallicRoughness",
                              {{"baseColorTexture", {{"index", 0}, {"extensions", {{kName, std::move(slot)}}}}}}}});
  builder.root_node({{"mesh", builder.mesh({{"attributes", attributes}, {"material", 0}})}});
  return load(builder);
}

// The checkerboard of the draft's README.
constexpr const char* kDraftExample = R"({"name": "My_Checker", "nodetype": "nodegraph", "type": "color3",
  "inputs": [{"name": "color1", "nodetype": "input", "type": "color3", "value": [1.0, 0.0, 0.0]},
             {"name": "color2", "nodetype": "input", "type": "color3", "value": [0.0, 1.0, 0.0]},
             {"name": "uvtiling", "nodetype": "input", "type": "vector2", "value": [8.0, 8.0]},
             {"name": "uvoffset", "nodetype": "input", "type": "vector2", "value": [0.0, 0.0]}],
  "outputs": [{"name": "out", "nodetype": "output", "type": "color3", "node": 5}],
  "nodes": [
    {"name": "N_mtlxmult", "nodetype": "multiply", "type": "vector2",
     "inputs": [{"name": "in1", "nodetype": "input", "type": "vector2", "node": 6}, {"name": "in2", "nodetype": "input", "type": "vector2", "input": 2}],
     "outputs": [{"nodetype": "output", "name": "out", "type": "vector2"}]},
    {"name": "N_mtlxsubtract", "nodetype": "subtract", "type": "vector2",
     "inputs": [{"name": "in1", "nodetype": "input", "type": "vector2", "node": 0}, {"name": "in2", "nodetype": "input", "type": "vector2", "input": 3}],
     "outputs": [{"nodetype": "output", "name": "out", "type": "vector2"}]},
    {"name": "N_mtlxfloor", "nodetype": "floor", "type": "vector2",
     "inputs": [{"name": "in", "nodetype": "input", "type": "vector2", "node": 1}],
     "outputs": [{"nodetype": "output", "name": "out", "type": "vector2"}]},
    {"name": "N_mtlxdotproduct", "nodetype": "dotproduct", "type": "float",
     "inputs": [{"name": "in1", "nodetype": "input", "type": "vector2", "node": 2}, {"name": "in2", "nodetype": "input", "type": "vector2", "value": [1.0, 1.0]}],
     "outputs": [{"nodetype": "output", "name": "out", "type": "float"}]},
    {"name": "N_modulo", "nodetype": "modulo", "type": "float",
     "inputs": [{"name": "in1", "nodetype": "input", "type": "float", "node": 3}, {"name": "in2", "nodetype": "input", "type": "float", "value": 2.0}],
     "outputs": [{"nodetype": "output", "name": "out", "type": "float"}]},
    {"name": "N_mtlxmix", "nodetype": "mix", "type": "color3",
     "inputs": [{"name": "bg", "nodetype": "input", "type": "color3", "input": 1}, {"name": "fg", "nodetype": "input", "type": "color3", "input": 0},
                {"name": "mix", "nodetype": "input", "type": "float", "node": 4}],
     "outputs": [{"nodetype": "output", "name": "out", "type": "color3"}]},
    {"name": "texcoord", "nodetype": "texcoord", "type": "vector2",
     "inputs": [{"name": "index", "nodetype": "input", "type": "integer", "value": 0}],
     "outputs": [{"nodetype": "output", "name": "out", "type": "vector2"}]}]})";

TEST(Procedurals, ReadsExampleOfDraft) {
  for (const bool required : {false, true}) {
    const Loaded loaded = with_graphs(json::array({json::parse(kDraftExample)}), {{"index", 0}}, required);
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
    ASSERT_EQ(loaded.scene->procedurals.size(), 1U);
    const ProceduralGraph& read = loaded.scene->procedurals[0];
    EXPECT_EQ(read.name, "My_Checker");
    EXPECT_EQ(read.nodes.size(), 7U);
    EXPECT_EQ(read.texcoord_sets, 1U);
    // Each reads earlier ones.
    for (size_t i = 0; i < read.nodes.size(); ++i)
      for (const ProceduralInput& from : read.nodes[i].inputs) EXPECT_LT(from.node, static_cast<int>(i));
    const TextureSlot& slot = loaded.scene->materials[0].base_color_texture;
    EXPECT_EQ(slot.procedural, 0);
    EXPECT_EQ(slot.texture, kNone);
    EXPECT_TRUE(slot.present());
    EXPECT_EQ(loaded.scene->textures[0].image, nullptr); // the fallback is not loaded
  }
}

// Checks that a fault is a warning with the texture as fallback, and an error if the extension is
// required.
void expect_fault(const List& list, const json& slot, std::string_view start) {
  const json graphs = list;
  const Loaded tolerant = with_graphs(graphs, slot, false);
  ASSERT_TRUE(tolerant.scene) << tolerant.error;
  ASSERT_EQ(tolerant.warnings.size(), 1U) << start;
  EXPECT_TRUE(tolerant.warnings[0].starts_with(start)) << tolerant.warnings[0];
  EXPECT_TRUE(tolerant.warnings[0].ends_with("; the texture is used in its place")) << tolerant.warnings[0];
  EXPECT_EQ(tolerant.scene->materials[0].base_color_texture.texture, 0);
  EXPECT_EQ(tolerant.scene->materials[0].base_color_texture.procedural, kNone);
  EXPECT_NE(tolerant.scene->textures[0].image, nullptr);
  const Loaded strict = with_graphs(graphs, slot, true);
  ASSERT_FALSE(strict.scene) << start;
  EXPECT_TRUE(strict.error.starts_with(start)) << strict.error;
}

TEST(Procedurals, ReportsFaultsOfNodes) {
  const std::string at = std::string("/extensions/") + kName + "/procedurals/0";
  const json color = node("constant", "color3", {input("value", "color3", {{"value", {1, 2, 3}}})});
  const auto fault = [&](const List& nodes, std::string_view place) {
    expect_fault({graph(nodes)}, {{"index", 0}}, at + std::string(place));
  };
  fault({node("wood", "color3", {})}, "/nodes/0/nodetype: 'wood' is not a known node type");
  fault({node("constant", "plaid", {})}, "/nodes/0/type: 'plaid', expected one of float, color3,");
  fault({node("position", "color3", {})}, "/nodes/0/type: 'color3' is not an output type of position");
  fault({node("constant", "color3", {input("value", "color3", {{"value", {1, 2}}})})},
        "/nodes/0/inputs/0/value: expected an array of 3 numbers");
  fault({node("constant", "color3", {input("value", "color3", {{"value", {1, 2, "x"}}})})},
        "/nodes/0/inputs/0/value: expected numbers");
  fault({node("constant", "color3", {input("value", "color3", json::object())})}, "/nodes/0/inputs/0: no value");
  fault({node("constant", "color3", {input("color", "color3", {{"value", {1, 2, 3}}})})},
        "/nodes/0/inputs/0/name: not an input of constant, expected one of value");
  fault({color, node("add", "color3", {input("in1", "color3", {{"node", 0}}), input("in1", "color3", {{"node", 0}})})},
        "/nodes/1/inputs/1: input 'in1' appears twice");
  fault({color, node("add", "color3", {input("in1", "vector3", {{"node", 0}})})},
        "/nodes/1/inputs/0/type: 'vector3' for input 'in1', expected color3");
  fault({node("position", "vector3", {}), node("add", "color3", {input("in1", "color3", {{"node", 0}})})},
        "/nodes/1/inputs/0/type: 'color3' from node 0 of type 'vector3'");
  fault({color, node("add", "color3", {input("in1", "color3", {{"node", -1}})})},
        "/nodes/1/inputs/0/node: expected an index below 2");
  fault({color, node("add", "color3", {input("in1", "color3", {{"node", 0.5}})})},
        "/nodes/1/inputs/0/node: expected an index");
  fault({color, node("add", "color3", {input("in1", "color3", {{"node", 1}})})},
        "/nodes/1: its inputs depend on its own output");
  fault({node("constant", "integer", {}), node("fractal3d", "color3", {input("octaves", "integer", {{"value", 17}})})},
        "/nodes/0/type: 'integer' is not an output type");
  fault({node("fractal3d", "color3", {input("octaves", "integer", {{"value", 17}})})},
        "/nodes/0: octaves of 17, expected 0 to 16");
  fault({node("texcoord", "vector2", {input("index", "integer", {{"value", 8}})}), color}, "/nodes/0: index of 8");
  fault({node("separate2", "multioutput", {input("in", "color3", {{"value", {1, 2, 3}}})}), color},
        "/nodes/0: an input of 3 channels");
  fault({node("separate3", "multioutput", {input("in", "color3", {{"value", {1, 2, 3}}})}),
         node("convert", "color3", {input("in", "float", {{"node", 0}})})},
        "/nodes/1/inputs/0: no output, expected an index below 3");
  fault({node("image", "color3", {input("file", "filename", {{"texture", 1}})})},
        "/nodes/0/inputs/0/texture: expected an index below 1");
  fault({node("image", "color3")}, "/nodes/0: no file");
  fault({node("position", "vector3", {input("space", "string", {{"value", "tangent"}})}), color},
        "/nodes/0/inputs/0/value: 'tangent', expected one of object, model, world");
}

TEST(Procedurals, ReportsFaultsOfGraphs) {
  const std::string at = std::string("/extensions/") + kName + "/procedurals/0";
  const json color = node("constant", "color3");
  json two = graph(List{color});
  two["outputs"].push_back(two["outputs"][0]);
  expect_fault({two}, {{"index", 0}}, "/materials/0: KHR_texture_procedurals index 0 without output, the graph has 2");
  expect_fault({two}, {{"index", 0}, {"output", 2}}, "/materials/0: KHR_texture_procedurals output 2");
  expect_fault({two}, {{"index", 1}}, "/materials/0: KHR_texture_procedurals index 1, there are 1");
  expect_fault({two}, {{"index", "one"}}, "/materials/0: KHR_texture_procedurals index -2");
  expect_fault({two}, json::array(), "/materials/0: KHR_texture_procedurals index -2");
  expect_fault({json::array()}, {{"index", 0}}, at + ": expected an object");
  expect_fault({json{{"nodetype", "material"}}}, {{"index", 0}}, at + "/nodetype: 'material', expected 'nodegraph'");
  expect_fault({graph(List(257, color))}, {{"index", 0}}, at + "/nodes: 257 entries, at most 256 are accepted");
  json without = graph(List{color});
  without["outputs"] = json::array();
  expect_fault({without}, {{"index", 0}}, at + "/outputs: none");
  EXPECT_TRUE(with_graphs(json::array({two}), {{"index", 0}, {"output", 1}}).warnings.empty());
  // Nodes with many instructions each.
  List many{node("texcoord", "vector2")};
  for (int i = 0; i < 255; ++i)
    many.push_back(
        node("place2d", "vector2",
             {input("texcoord", "vector2", {{"node", i}}), input("rotate", "float", {{"value", 1.0 + i}}),
              input("scale", "vector2", {{"value", {2 + i, 3}}}), input("pivot", "vector2", {{"value", {i, 3}}})}));
  expect_fault({graph(many, "vector2")}, {{"index", 0}}, at + "/outputs/0: ");
}

// Values are added up, then multiplied with the sum one after the other: all are needed until then.
TEST(Procedurals, LimitsTheValuesThatAreNeededAtATime) {
  const auto graph_of = [](int values) {
    List nodes{node("texcoord", "vector2")};
    const auto binary = [&](const char* kind, int first, const json& second) {
      nodes.push_back(
          node(kind, "vector2", {input("in1", "vector2", {{"node", first}}), input("in2", "vector2", second)}));
      return static_cast<int>(nodes.size()) - 1;
    };
    for (int i = 1; i <= values; ++i) binary("modulo", 0, {{"value", {0.01 * i, 0.03}}});
    int last = 0;
    for (const char* kind : {"add", "multiply"})
      for (int i = 1; i <= values; ++i) last = binary(kind, last, {{"node", i}});
    return graph(nodes, "vector2");
  };
  EXPECT_TRUE(with_graphs(json::array({graph_of(60)})).warnings.empty());
  expect_fault({graph_of(70)}, {{"index", 0}},
               std::string("/extensions/") + kName +
                   "/procedurals/0/outputs/0: 71 values are needed at a time, at most 64 are accepted");
}

TEST(Procedurals, IgnoresTexcoordAndTransformOfSlot) {
  GltfBuilder builder;
  builder.root["extensionsUsed"] = {kName, "KHR_texture_transform"};
  builder.root["extensions"][kName]["procedurals"] =
      List{graph(List{node("texcoord", "vector2", {input("index", "integer", {{"value", 1}})}),
                      node("convert", "color3", {input("in", "vector2", {{"node", 0}})})})};
  builder.push("textures", json::object());
  builder.push("materials",
               {{"emissiveTexture",
                 {{"index", 0},
                  {"texCoord", 3},
                  {"extensions", {{kName, {{"index", 0}}}, {"KHR_texture_transform", {{"scale", {2, 2}}}}}}}}});
  const Loaded loaded = load(builder);
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty());
  const TextureSlot& slot = loaded.scene->materials[0].emissive_texture;
  EXPECT_EQ(slot.scale, V2f(1.0f));
  EXPECT_EQ(slot.texcoord_sets(), 2U);
}

TEST(Procedurals, LoadsImagesOfGraphs) {
  json with_input = graph(List{node("image", "color3", {input("file", "filename", {{"input", 0}})})});
  with_input["inputs"] = List{{{"nodetype", "input"}, {"type", "filename"}, {"texture", 0}}};
  for (const json& each :
       {with_input, graph(List{node("image", "color3", {input("file", "filename", {{"texture", 0}})})})}) {
    const Loaded loaded = with_graphs(json::array({each}));
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
    EXPECT_NE(loaded.scene->textures[0].image, nullptr);
  }
}

} // namespace
} // namespace kindling::test
