// Reads and checks animation channels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/nodes/animations.h"

#include "renderer/import/document/accessor.h"
#include "renderer/import/json/extensions.h"
#include "renderer/import/meshes/meshes.h"
#include "renderer/scene/animated_members.h"
#include "renderer/scene/animation.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>
#include <optional>

namespace kindling::gltf {
namespace {

using nlohmann::json;

struct Target {
  int node = kNone;
  AnimatedProperty property = AnimatedProperty::translation;
  int weight = kNone;
  AnimatedMember member;
};

std::optional<AnimatedProperty> property_of(std::string_view path) {
  if (path == "translation") return AnimatedProperty::translation;
  if (path == "rotation") return AnimatedProperty::rotation;
  if (path == "scale") return AnimatedProperty::scale;
  if (path == "weights") return AnimatedProperty::weights;
  return std::nullopt;
}

bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (text.substr(0, prefix.size()) != prefix) return false;
  text.remove_prefix(prefix.size());
  return true;
}

std::optional<int> take_index(std::string_view& text) {
  int index = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc() || index < 0) return std::nullopt;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return index;
}

// Resolves pointers of KHR_animation_pointer to properties of nodes: "/nodes/3/rotation",
// "/nodes/3/weights/1", "/nodes/3/extensions/KHR_node_visibility/visible". animated_members.h has
// all others.
std::optional<Target> parse_pointer(std::string_view text, Scene& scene) {
  Target target;
  if (const auto member = find_animated_member(scene, text)) {
    target.property = AnimatedProperty::member;
    target.member = *member;
    return target;
  }
  if (!take_prefix(text, "/nodes/")) return std::nullopt;
  const auto node = take_index(text);
  if (!node || static_cast<size_t>(*node) >= scene.nodes.size() || text.empty()) return std::nullopt;
  target.node = *node;
  if (text == "/extensions/KHR_node_visibility/visible") {
    target.property = AnimatedProperty::visible;
    return target;
  }
  if (take_prefix(text, "/weights/")) {
    const auto weight = take_index(text);
    if (!weight || !text.empty()) return std::nullopt;
    target.property = AnimatedProperty::weights;
    target.weight = *weight;
    return target;
  }
  const auto property = property_of(text.substr(1));
  if (!property || text.front() != '/') return std::nullopt;
  target.property = *property;
  return target;
}

std::optional<Target> find_target(const tinygltf::AnimationChannel& core, const json& object,
                                  const std::string& pointer, Scene& scene, Warnings& warnings) {
  if (core.target_path == "pointer") {
    const json* extension = find_extension(object["target"], "KHR_animation_pointer");
    if (extension == nullptr) return std::nullopt;
    const auto& text = (*extension)["pointer"].get_ref<const std::string&>();
    const auto target = parse_pointer(text, scene);
    if (!target) {
      warnings.add("pointer", pointer + "/target/extensions/KHR_animation_pointer/pointer",
                   fmt::format("animating {} has no effect", in_quotes(text)));
    }
    return target;
  }
  if (core.target_node < 0) return std::nullopt; // the specification ignores such channels
  const auto property = property_of(core.target_path);
  if (!property) {
    warnings.add("path", pointer + "/target/path",
                 fmt::format("animating {} has no effect", in_quotes(core.target_path)), "VALUE_NOT_IN_LIST");
    return std::nullopt;
  }
  return Target{core.target_node, *property};
}

// True for an accessor with neither a bufferView nor sparse values: all zero.
bool lacks_data(const Document& document, int accessor) {
  const tinygltf::Accessor& core = document.core.accessors[static_cast<size_t>(accessor)];
  return core.bufferView < 0 && !core.sparse.isSparse;
}

std::vector<float> read_times(const Document& document, int accessor, bool cubic, const std::string& pointer,
                              ElementBudget& budget) {
  const AccessorView view = view_accessor(document, accessor, pointer);
  require_format(view, {.components = 1}, pointer, "key times", "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT");
  if (cubic && view.count < 2) {
    fail(pointer, "1 key with CUBICSPLINE, expected at least 2", "ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS");
  }
  budget.charge(view.count, pointer);
  std::vector<float> times = read_vectors<float>(view);
  if (!all_finite(times)) fail(pointer, "a time that is not finite", "ACCESSOR_INVALID_FLOAT");
  if (lacks_data(document, accessor)) return times; // import_animations() skips the channel
  if (times.front() < 0.0f) {
    fail(pointer, fmt::format("first key at {} s, expected times from 0", times.front()),
         "ACCESSOR_ANIMATION_INPUT_NEGATIVE");
  }
  for (size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) continue;
    fail(pointer, fmt::format("key {} at {} s is not after the one before at {} s", i, times[i], times[i - 1]),
         "ACCESSOR_ANIMATION_INPUT_NON_INCREASING");
  }
  return times;
}

void read_values(const Document& document, int accessor, size_t scalars, const std::string& pointer,
                 ElementBudget& budget, AnimationChannel& channel) {
  const AccessorView view = view_accessor(document, accessor, pointer);
  constexpr std::string_view kFormat = "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT";
  AccessorFormat format;
  switch (channel.property) {
  case AnimatedProperty::translation:
  case AnimatedProperty::scale: format = {.components = 3}; break;
  case AnimatedProperty::rotation: format = {.components = 4, .normalized_int = true}; break;
  case AnimatedProperty::weights: format = {.components = 1, .normalized_int = true}; break;
  case AnimatedProperty::visible: format = {.components = 1, .is_float = false, .plain_int = true}; break;
  case AnimatedProperty::member:
    format = {.components = channel.member.owner == AnimatedMember::Owner::mesh ? 1 : channel.components,
              .normalized_int = true,
              .plain_int = true};
    break;
  }
  require_format(view, format, pointer, "these values", kFormat);
  const size_t expected = scalars / static_cast<size_t>(format.components);
  if (view.count != expected) {
    fail(pointer, fmt::format("{} values for {} keys, expected {}", view.count, channel.times_s.size(), expected),
         "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT");
  }
  budget.charge(view.count, pointer);
  channel.values.resize(scalars);
  read_floats(view, {}, channel.values.data(), format.components);
  if (!all_finite(channel.values)) fail(pointer, "a value that is not finite", "ACCESSOR_INVALID_FLOAT");
}

void normalize_rotations(std::vector<float>& values, const std::string& pointer) {
  for (size_t i = 0; i < values.size(); i += 4) {
    double square = 0.0;
    for (size_t c = 0; c < 4; ++c) square += static_cast<double>(values[i + c]) * static_cast<double>(values[i + c]);
    if (!(square > 1e-12)) {
      fail(pointer, fmt::format("quaternion {} has length 0, expected length 1", i / 4),
           "ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION");
    }
    const double scale = 1.0 / std::sqrt(square);
    for (size_t c = 0; c < 4; ++c) values[i + c] = static_cast<float>(static_cast<double>(values[i + c]) * scale);
  }
}

// Checks that the node can have the target, and returns the number of values per key.
int check_target(const Document& document, Scene& scene, const Target& target, const std::string& pointer) {
  if (target.property == AnimatedProperty::member)
    return static_cast<int>(animated_values(scene, target.member).size());
  const Node& node = scene.nodes[static_cast<size_t>(target.node)];
  switch (target.property) {
  case AnimatedProperty::visible: return 1;
  case AnimatedProperty::weights: {
    const size_t targets = node.mesh == kNone ? 0 : morph_target_count(document, static_cast<size_t>(node.mesh));
    if (targets == 0)
      fail(pointer, fmt::format("weights of node {}, whose mesh has no morph targets", target.node),
           "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS");
    if (target.weight == kNone) return static_cast<int>(targets);
    if (static_cast<size_t>(target.weight) >= targets)
      fail(pointer,
           fmt::format("weight {} of node {}, whose mesh has {} morph targets", target.weight, target.node, targets));
    return 1;
  }
  default:
    if (node.matrix) {
      fail(pointer,
           fmt::format("node {} has a matrix, expected a node with translation, rotation and scale", target.node),
           "ANIMATION_CHANNEL_TARGET_NODE_MATRIX");
    }
    return target.property == AnimatedProperty::rotation ? 4 : 3;
  }
}

} // namespace

void import_animations(Document& document, Scene& scene, Warnings& warnings) {
  ElementBudget budget(document);
  for (size_t a = 0; a < document.core.animations.size(); ++a) {
    const tinygltf::Animation& core = document.core.animations[a];
    const json& object = (*document.json)["animations"][a];
    Animation animation;
    animation.name = core.name;
    for (size_t c = 0; c < core.channels.size(); ++c) {
      const std::string pointer = fmt::format("/animations/{}/channels/{}", a, c);
      const auto index = static_cast<size_t>(core.channels[c].sampler);
      if (index >= core.samplers.size()) {
        fail(pointer + "/sampler", fmt::format("{}, the animation has {} samplers", index, core.samplers.size()),
             "UNRESOLVED_REFERENCE");
      }
      const auto target = find_target(core.channels[c], object["channels"][c], pointer, scene, warnings);
      if (!target) continue;
      const tinygltf::AnimationSampler& sampler = core.samplers[index];
      AnimationChannel channel;
      channel.node = target->node;
      channel.property = target->property;
      channel.weight = target->weight;
      channel.member = target->member;
      channel.components = check_target(document, scene, *target, pointer + "/target");
      channel.interpolation = sampler.interpolation == "STEP"          ? Interpolation::step
                              : sampler.interpolation == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                                       : Interpolation::linear;
      if (channel.property == AnimatedProperty::visible) channel.interpolation = Interpolation::step;
      const bool cubic = channel.interpolation == Interpolation::cubic_spline;
      const std::string place = fmt::format("/animations/{}/samplers/{}", a, index);
      channel.times_s = read_times(document, sampler.input, cubic, place + "/input", budget);
      const size_t scalars = channel.times_s.size() * static_cast<size_t>(channel.components) * (cubic ? 3 : 1);
      read_values(document, sampler.output, scalars, place + "/output", budget, channel);
      if (lacks_data(document, sampler.input)) { // all times are zero
        warnings.add("no keys", pointer, "an animation without key times has no effect");
        continue;
      }
      if (is_rotation(channel) && !cubic) normalize_rotations(channel.values, place + "/output");
      animation.channels.push_back(std::move(channel));
    }
    scene.animations.push_back(std::move(animation));
  }
}

} // namespace kindling::gltf
