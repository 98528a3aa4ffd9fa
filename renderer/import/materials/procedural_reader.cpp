// Reads nodes in topological order, without recursion, and checks them against their definitions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials/procedural_reader.h"

#include "renderer/import/files/failure.h"
#include "renderer/import/materials/material_values.h"
#include "renderer/texture/procedural_texture.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace kindling::gltf {
namespace {

using nlohmann::json;
using Kind = ProceduralKind;
using R = ProceduralRule;
using S = ProceduralInput::Source;
using T = ProceduralType;

constexpr size_t kMaxPorts = 32; // inputs or outputs of a graph or a node

[[noreturn]] void fault(const std::string& pointer, std::string message) {
  throw ProceduralFault{pointer, std::move(message)};
}

const json& list_of(const json& object, const char* name, const std::string& pointer, size_t max_size) {
  static const json kEmpty = json::array();
  const json* list = member(object, name);
  if (list == nullptr) return kEmpty;
  const std::string place = fmt::format("{}/{}", pointer, name);
  if (!list->is_array()) fault(place, "expected an array of objects");
  if (list->size() > max_size) fault(place, fmt::format("{} entries, at most {} are accepted", list->size(), max_size));
  for (size_t i = 0; i < list->size(); ++i)
    if (!(*list)[i].is_object()) fault(fmt::format("{}/{}", place, i), "expected an object");
  return *list;
}

const std::string& text_of(const json& object, const char* name, const std::string& pointer) {
  const json* value = member(object, name);
  if (value == nullptr || !value->is_string()) fault(fmt::format("{}/{}", pointer, name), "expected a string");
  return value->get_ref<const std::string&>();
}

// Returns an index below `count`, or nothing if absent.
std::optional<size_t> index_of(const json& object, const char* name, const std::string& pointer, size_t count) {
  const json* value = member(object, name);
  if (value == nullptr) return std::nullopt;
  if (!value->is_number_integer() || (!value->is_number_unsigned() && value->get<int64_t>() < 0) ||
      value->get<uint64_t>() >= count)
    fault(fmt::format("{}/{}", pointer, name), fmt::format("expected an index below {}", count));
  return value->get<size_t>();
}

std::optional<T> find_type(std::string_view name) {
  for (size_t i = 0; i <= static_cast<size_t>(T::file); ++i)
    if (name_of(static_cast<T>(i)) == name) return static_cast<T>(i);
  return std::nullopt;
}

T type_of(const json& object, const std::string& pointer) {
  const std::string& name = text_of(object, "type", pointer);
  const std::optional<T> type = find_type(name);
  if (!type) {
    std::string accepted;
    for (size_t i = 0; i <= static_cast<size_t>(T::file); ++i)
      accepted += fmt::format("{}{}", i == 0 ? "" : ", ", name_of(static_cast<T>(i)));
    fault(pointer + "/type", fmt::format("{}, expected one of {}", in_quotes(name), accepted));
  }
  return *type;
}

V4f value_of(const json& value, T type, const std::string& pointer) {
  const auto number = [&](const json& item) {
    const double x = item.is_number() ? item.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(std::abs(x) <= 1e18)) fault(pointer, "expected numbers up to 1e18");
    return static_cast<float>(x);
  };
  const int channels = channels_of(type);
  if (type == T::boolean) {
    if (!value.is_boolean()) fault(pointer, "expected true or false");
    return V4f(value.get<bool>() ? 1.0f : 0.0f);
  }
  if (channels == 1) {
    const float x = number(value);
    if (type == T::integer && x != std::floor(x)) fault(pointer, "expected an integer");
    return V4f(x);
  }
  if (!value.is_array() || value.size() != static_cast<size_t>(channels))
    fault(pointer, fmt::format("expected an array of {} numbers", channels));
  V4f result(0.0f, 0.0f, 0.0f, 1.0f);
  for (int c = 0; c < channels; ++c) result[c] = number(value[static_cast<size_t>(c)]);
  return result;
}

bool allows(R rule, T type, T output, T first) {
  const bool color_or_vector = channels_of(type) > 0 && type != T::integer && type != T::boolean;
  switch (rule) {
  case R::same: return type == output;
  case R::same_or_float: return type == output || type == T::float_;
  case R::number: return type == T::float_;
  case R::integer: return type == T::integer;
  case R::boolean: return type == T::boolean;
  case R::vector2: return type == T::vector2;
  case R::vector3: return type == T::vector3;
  case R::color3: return type == T::color3;
  case R::numeric: return color_or_vector;
  case R::like_first: return type == first;
  case R::scalar: return type == T::float_ || type == T::integer;
  case R::string: return type == T::string;
  case R::file: return type == T::file;
  }
  return false;
}

T default_type(const ProceduralInputRule& rule, T output, T first) {
  switch (rule.rule) {
  case R::same:
  case R::same_or_float: return output;
  case R::like_first: return first;
  case R::integer: return T::integer;
  case R::boolean: return T::boolean;
  case R::vector2: return T::vector2;
  case R::vector3: return T::vector3;
  case R::color3: return T::color3;
  case R::string: return T::string;
  case R::file: return T::file;
  default: return T::float_;
  }
}

class GraphReader {
 public:
  GraphReader(const json& graph, const std::string& pointer, size_t texture_count)
      : pointer_(pointer), texture_count_(texture_count), inputs_(list_of(graph, "inputs", pointer, kMaxPorts)),
        nodes_(list_of(graph, "nodes", pointer, kMaxProceduralNodes)),
        outputs_(list_of(graph, "outputs", pointer, kMaxPorts)) {
    if (const json* name = member(graph, "name"); name != nullptr && name->is_string())
      result_.name = name->get<std::string>();
    if (const std::string& type = text_of(graph, "nodetype", pointer); type != "nodegraph")
      fault(pointer + "/nodetype", fmt::format("{}, expected 'nodegraph'", in_quotes(type)));
  }

  ProceduralGraph read() {
    position_.assign(nodes_.size(), -1);
    for (const size_t i : in_order()) {
      position_[i] = static_cast<int16_t>(result_.nodes.size());
      result_.nodes.push_back(read_node(i));
    }
    if (outputs_.empty()) fault(pointer_ + "/outputs", "none, expected at least one");
    for (size_t i = 0; i < outputs_.size(); ++i) result_.outputs.push_back(read_output(i));
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::string place_of(size_t node) const { return fmt::format("{}/nodes/{}", pointer_, node); }

  // Sorts nodes behind their inputs (Kahn 1962, "Topological Sorting of Large Networks"), ties by
  // number.
  [[nodiscard]] std::vector<size_t> in_order() const {
    std::vector<size_t> waits_for(nodes_.size(), 0);
    std::vector<std::vector<size_t>> readers(nodes_.size());
    for (size_t i = 0; i < nodes_.size(); ++i) {
      const json& ports = list_of(nodes_[i], "inputs", place_of(i), kMaxPorts);
      for (size_t p = 0; p < ports.size(); ++p) {
        const auto source = index_of(ports[p], "node", fmt::format("{}/inputs/{}", place_of(i), p), nodes_.size());
        if (!source) continue;
        ++waits_for[i];
        readers[*source].push_back(i);
      }
    }
    std::vector<size_t> order;
    for (size_t i = 0; i < nodes_.size(); ++i)
      if (waits_for[i] == 0) order.push_back(i);
    for (size_t done = 0; done < order.size(); ++done)
      for (const size_t reader : readers[order[done]])
        if (--waits_for[reader] == 0) order.push_back(reader);
    if (order.size() < nodes_.size()) {
      const auto first = static_cast<size_t>(
          std::find_if(waits_for.begin(), waits_for.end(), [](size_t count) { return count > 0; }) - waits_for.begin());
      fault(place_of(first), "its inputs depend on its own output, expected a graph without cycles");
    }
    return order;
  }

  ProceduralNode read_node(size_t i) {
    const json& object = nodes_[i];
    const std::string place = place_of(i);
    const std::string& name = text_of(object, "nodetype", place);
    const ProceduralDefinition* definition = find_procedural_definition(name);
    if (definition == nullptr) fault(place + "/nodetype", fmt::format("{} is not a known node type", in_quotes(name)));
    ProceduralNode node{.kind = definition->kind};
    const bool several = !definition->outputs.empty();
    if (!several) {
      node.type = type_of(object, place);
      if (((definition->output_types >> static_cast<unsigned>(node.type)) & 1U) == 0)
        fault(place + "/type",
              fmt::format("{} is not an output type of {}", in_quotes(name_of(node.type)), definition->name));
    }
    const json& ports = list_of(object, "inputs", place, kMaxPorts);
    std::vector<const json*> given(definition->inputs.size(), nullptr);
    std::vector<std::string> places(definition->inputs.size(), place);
    for (size_t p = 0; p < ports.size(); ++p) {
      const std::string port = fmt::format("{}/inputs/{}", place, p);
      const size_t number = input_number(*definition, ports[p], p, port);
      if (given[number] != nullptr)
        fault(port, fmt::format("input {} appears twice", in_quotes(definition->inputs[number].name)));
      given[number] = &ports[p];
      places[number] = port;
    }
    for (size_t n = 0; n < given.size(); ++n) {
      const ProceduralInputRule& rule = definition->inputs[n];
      const T first = node.inputs.empty() ? T::float_ : node.inputs[0].type;
      if (given[n] != nullptr) {
        node.inputs.push_back(read_input(*given[n], rule, node.type, first, places[n]));
      } else {
        ProceduralInput input{.source = rule.source, .type = default_type(rule, node.type, first)};
        input.value = V4f(rule.value);
        node.inputs.push_back(input);
      }
      if (node.inputs.back().source == S::uv0) result_.texcoord_sets |= 1U;
    }
    // The draft's example has it beside the inputs.
    if (const json* value = member(object, "value");
        value != nullptr && node.kind == Kind::constant && given[0] == nullptr)
      node.inputs[0].value = value_of(*value, node.type, place + "/value");
    if (several) node.type = node.inputs[0].type;
    check(node, *definition, place);
    return node;
  }

  [[nodiscard]] static size_t input_number(const ProceduralDefinition& definition, const json& port, size_t number,
                                           const std::string& place) {
    const json* name = member(port, "name");
    if (name == nullptr && number < definition.inputs.size()) return number;
    if (name != nullptr && name->is_string()) {
      for (size_t n = 0; n < definition.inputs.size(); ++n)
        if (definition.inputs[n].name == name->get_ref<const std::string&>()) return n;
    }
    std::string accepted;
    for (const ProceduralInputRule& rule : definition.inputs)
      accepted += fmt::format("{}{}", accepted.empty() ? "" : ", ", rule.name);
    fault(place + "/name", fmt::format("not an input of {}, expected one of {}", definition.name, accepted));
  }

  ProceduralInput read_input(const json& port, const ProceduralInputRule& rule, T output, T first,
                             const std::string& place) {
    ProceduralInput input;
    input.type = type_of(port, place);
    if (!allows(rule.rule, input.type, output, first)) {
      fault(place + "/type",
            fmt::format("{} for input {}, expected {}", in_quotes(name_of(input.type)), in_quotes(rule.name),
                        rule.rule == R::numeric ? "a float, a color or a vector"
                                                : name_of(default_type(rule, output, first))));
    }
    if (const auto source = index_of(port, "node", place, nodes_.size())) {
      if (rule.constant) fault(place + "/node", fmt::format("{} must be constant", in_quotes(rule.name)));
      connect(port, *source, input.type, place, input.node, input.output);
      input.source = S::node;
      return input;
    }
    const json* from = &port;
    std::string from_place = place;
    if (const auto source = index_of(port, "input", place, inputs_.size())) {
      from = &inputs_[*source];
      from_place = fmt::format("{}/inputs/{}", pointer_, *source);
      if (type_of(*from, from_place) != input.type)
        fault(place + "/type", fmt::format("{} from a graph input of type {}", in_quotes(name_of(input.type)),
                                           in_quotes(name_of(type_of(*from, from_place)))));
    }
    if (input.type == T::file) {
      const auto texture = index_of(*from, "texture", from_place, texture_count_);
      if (!texture) fault(from_place, "no texture, expected an index of textures");
      input.texture = static_cast<int>(*texture);
      return input;
    }
    const json* value = member(*from, "value");
    if (value == nullptr) fault(from_place, "no value, expected one of value, node, input");
    if (input.type == T::string) {
      input.variant = word_number(rule, *value, from_place + "/value");
    } else {
      input.value = value_of(*value, input.type, from_place + "/value");
    }
    return input;
  }

  static int8_t word_number(const ProceduralInputRule& rule, const json& value, const std::string& place) {
    if (!value.is_string()) fault(place, "expected a string");
    std::string accepted;
    for (size_t n = 0; n < rule.words.size(); ++n) {
      if (rule.words[n].empty() || rule.words[n] == value.get_ref<const std::string&>()) return static_cast<int8_t>(n);
      accepted += fmt::format("{}{}", n == 0 ? "" : ", ", rule.words[n]);
    }
    fault(place, fmt::format("{}, expected one of {}", in_quotes(value.get_ref<const std::string&>()), accepted));
  }

  // Resolves a port that refers to node `source`, which has been read already.
  void connect(const json& port, size_t source, T type, const std::string& place, int16_t& node, int8_t& output) const {
    node = position_[source];
    const ProceduralNode& from = result_.nodes[static_cast<size_t>(node)];
    const size_t output_count = std::max(definition_of(from.kind).outputs.size(), size_t{1});
    const auto number = index_of(port, "output", place, output_count);
    if (!number && output_count > 1) fault(place, fmt::format("no output, expected an index below {}", output_count));
    output = static_cast<int8_t>(number.value_or(0));
    const T given = output_count > 1 ? T::float_ : from.type;
    if (given != type)
      fault(place + "/type",
            fmt::format("{} from node {} of type {}", in_quotes(name_of(type)), source, in_quotes(name_of(given))));
  }

  // Checks that concern several inputs.
  void check(const ProceduralNode& node, const ProceduralDefinition& definition, const std::string& place) {
    const auto at = [&](size_t n) { return static_cast<int>(std::clamp(node.inputs[n].value.x, -1e6f, 1e6f)); };
    const auto expect = [&](size_t n, int low, int high) {
      if (at(n) < low || at(n) > high)
        fault(place, fmt::format("{} of {}, expected {} to {}", definition.inputs[n].name, at(n), low, high));
    };
    const int channels = channels_of(node.inputs[0].type);
    switch (node.kind) {
    case Kind::texcoord:
      expect(0, 0, kMaxProceduralTexcoordSets - 1);
      result_.texcoord_sets |= 1U << static_cast<unsigned>(at(0));
      break;
    case Kind::geomcolor: expect(0, 0, 0); break;
    case Kind::image:
      if (node.inputs[0].texture < 0) fault(place, "no file, expected an index of textures");
      break;
    case Kind::fractal2d:
    case Kind::fractal3d: expect(1, 0, kMaxProceduralOctaves); break;
    case Kind::worleynoise2d:
    case Kind::worleynoise3d: expect(2, 0, 1); break;
    case Kind::place2d: expect(5, 0, 1); break;
    case Kind::extract: expect(1, 0, channels - 1); break;
    case Kind::combine2:
      if (channels + channels_of(node.inputs[1].type) != channels_of(node.type))
        fault(place, fmt::format("inputs of {} and {} channels do not make a {}", channels,
                                 channels_of(node.inputs[1].type), name_of(node.type)));
      break;
    case Kind::separate2:
    case Kind::separate3:
    case Kind::separate4:
      if (static_cast<size_t>(channels) != definition.outputs.size())
        fault(place, fmt::format("an input of {} channels", channels));
      break;
    default: break;
    }
  }

  ProceduralOutput read_output(size_t i) const {
    const json& port = outputs_[i];
    const std::string place = fmt::format("{}/outputs/{}", pointer_, i);
    ProceduralOutput output{.type = type_of(port, place)};
    if (!allows(R::numeric, output.type, T::float_, T::float_))
      fault(place + "/type", fmt::format("{}, expected a float, a color or a vector", in_quotes(name_of(output.type))));
    const auto source = index_of(port, "node", place, nodes_.size());
    if (!source) fault(place, "no node, expected an index of nodes");
    connect(port, *source, output.type, place, output.node, output.output);
    return output;
  }

  const std::string& pointer_;
  size_t texture_count_;
  const json& inputs_;
  const json& nodes_;
  const json& outputs_;
  std::vector<int16_t> position_; // index in the result of each node of the file
  ProceduralGraph result_;
};

} // namespace

ProceduralGraph read_procedural_graph(const json& graph, const std::string& pointer, size_t texture_count) {
  if (!graph.is_object()) fault(pointer, "expected an object");
  ProceduralGraph result = GraphReader(graph, pointer, texture_count).read();
  for (size_t i = 0; i < result.outputs.size(); ++i) {
    const ProceduralTexture compiled(result, i, [](int, bool) { return 0; });
    if (compiled.instruction_count() > kMaxProceduralInstructions)
      fault(fmt::format("{}/outputs/{}", pointer, i),
            fmt::format("{} instructions, at most {} are accepted", compiled.instruction_count(),
                        kMaxProceduralInstructions));
    if (compiled.register_count() > kMaxProceduralRegisters)
      fault(fmt::format("{}/outputs/{}", pointer, i),
            fmt::format("{} values are needed at a time, at most {} are accepted", compiled.register_count(),
                        kMaxProceduralRegisters));
  }
  return result;
}

} // namespace kindling::gltf
