// Builder of procedural graphs for tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_graph.h"
#include "renderer/texture/procedural_texture.h"

#include <array>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling::test {

// The value of an input: the output of a node, or a constant.
struct Given {
  ProceduralInput input;

  struct Node {
    int number;
    int output = 0;
  };
  Given(Node node) { // NOLINT: implicit on purpose
    input.source = ProceduralInput::Source::node;
    input.node = static_cast<int16_t>(node.number);
    input.output = static_cast<int8_t>(node.output);
  }
  Given(float x) { input.value = V4f(x); } // NOLINT
  Given(const V2f& v) {                    // NOLINT
    input.type = ProceduralType::vector2;
    input.value = V4f(v.x, v.y, 0.0f, 1.0f);
  }
  Given(const V3f& v) { // NOLINT
    input.type = ProceduralType::vector3;
    input.value = V4f(v.x, v.y, v.z, 1.0f);
  }
  Given(const V4f& v) { // NOLINT
    input.type = ProceduralType::vector4;
    input.value = v;
  }
};

// Builds a graph node by node; inputs that are not given have their defaults.
class GraphBuilder {
 public:
  using Kind = ProceduralKind;
  using Type = ProceduralType;
  using Node = Given::Node;

  Node add(Kind kind, Type type, const std::vector<std::pair<std::string_view, Given>>& given = {}) {
    const ProceduralDefinition& definition = definition_of(kind);
    ProceduralNode node{.kind = kind, .type = type};
    for (const ProceduralInputRule& rule : definition.inputs) {
      ProceduralInput input{.source = rule.source, .type = type, .value = V4f(rule.value)};
      for (const auto& [name, value] : given) {
        if (name != rule.name) continue;
        input = value.input;
        if (input.source == ProceduralInput::Source::node) {
          const ProceduralNode& from = graph_.nodes[static_cast<size_t>(input.node)];
          input.type = definition_of(from.kind).outputs.empty() ? from.type : Type::float_;
        } else if (rule.rule == ProceduralRule::same) {
          input.type = type;
        }
      }
      node.inputs.push_back(input);
    }
    if (!definition.outputs.empty()) node.type = node.inputs[0].type;
    graph_.nodes.push_back(std::move(node));
    return {static_cast<int>(graph_.nodes.size()) - 1, 0};
  }

  // Sets a string input; `variant` is the index of the word.
  void set_word(Node node, size_t input, int variant) {
    graph_.nodes[static_cast<size_t>(node.number)].inputs[input].variant = static_cast<int8_t>(variant);
  }

  ProceduralGraph graph(Node result) {
    const ProceduralNode& from = graph_.nodes[static_cast<size_t>(result.number)];
    const Type type = definition_of(from.kind).outputs.empty() ? from.type : Type::float_;
    ProceduralGraph graph = graph_;
    graph.outputs.push_back({static_cast<int16_t>(result.number), static_cast<int8_t>(result.output), type, V4f(0.0f)});
    graph.texcoord_sets = 0xff;
    return graph;
  }
  ProceduralTexture texture(Node result) {
    return ProceduralTexture(graph(result), 0, [](int, bool) { return -1; });
  }

 private:
  ProceduralGraph graph_;
};

// Returns the streams of a texture, all with the value `p` and a square footprint of side `width`.
inline std::array<ProceduralSample, kProceduralStreams> streams_at(const ProceduralTexture& texture, const V3f& p,
                                                                   float width = 0.0f) {
  std::array<ProceduralSample, kProceduralStreams> samples;
  for (size_t k = 0; k < texture.streams.size(); ++k) {
    samples[k].value = V4f(p.x, p.y, p.z, 1.0f);
    samples[k].across[0] = V4f(width, 0.0f, 0.0f, 0.0f);
    samples[k].across[1] = V4f(0.0f, width, 0.0f, 0.0f);
  }
  return samples;
}

inline V4f value_at(const ProceduralTexture& texture, const V3f& p, float width = 0.0f, const V2f& shift = V2f(0.0f)) {
  const auto samples = streams_at(texture, p, width);
  return texture.evaluate({samples.data(), texture.streams.size()}, {}, shift);
}

} // namespace kindling::test
