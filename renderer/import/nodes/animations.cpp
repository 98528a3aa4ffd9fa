// Reads and checks animation channels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/nodes/animations.h"

#include "renderer/import/document/accessor.h"
#include "renderer/import/json/extensions.h"
#include "renderer/import/meshes/meshes.h"
#include "renderer/scene/animated_members.h"
#include "renderer/scene/animation.h"

#include <ImathMatrixAlgo.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
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

// Returns the times of the keys, in increasing order; equal ones only where that is repaired.
std::vector<float> read_times(const Document& document, int accessor, bool cubic, const std::string& pointer,
                              Warnings& warnings) {
  const AccessorView view = view_accessor(document, accessor, pointer);
  require_format(view, {.components = 1}, pointer, "key times", "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT");
  if (view.count == 0) fail(pointer, "no keys", "ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS");
  if (cubic && view.count < 2) {
    warnings.repair("cubic key", pointer, "1 key with CUBICSPLINE, expected at least 2",
                    "ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS", "its value is constant");
  }
  std::vector<float> times = read_vectors<float>(view);
  if (!all_finite(times)) fail(pointer, "a time that is not finite", "ACCESSOR_INVALID_FLOAT");
  if (lacks_data(document, accessor)) return times; // import_animations() skips the channel
  if (times.front() < 0.0f) {
    warnings.repair("negative time", pointer, fmt::format("first key at {} s, expected times from 0", times.front()),
                    "ACCESSOR_ANIMATION_INPUT_NEGATIVE", "it is used");
  }
  for (size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) continue;
    const std::string fault =
        fmt::format("key {} at {} s is not after the one before at {} s", i, times[i], times[i - 1]);
    constexpr const char* kCode = "ACCESSOR_ANIMATION_INPUT_NON_INCREASING";
    if (times[i] < times[i - 1]) fail(pointer, fault, kCode);
    warnings.repair("repeated time", pointer, fault, kCode, "the value jumps there");
  }
  return times;
}

// Reads `scalars` numbers. More values than keys are accepted if that is repaired.
void read_values(const Document& document, int accessor, size_t scalars, const std::string& pointer,
                 AnimationChannel& channel, Warnings& warnings) {
  AccessorView view = view_accessor(document, accessor, pointer);
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
    const std::string fault =
        fmt::format("{} values for {} keys, expected {}", view.count, channel.times_s.size(), expected);
    constexpr const char* kCode = "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT";
    if (view.count < expected || view.sparse_count > 0) fail(pointer, fault, kCode);
    warnings.repair("values", pointer, fault, kCode, "the first ones are used");
    view.count = expected;
  }
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

// Gives repeated times an order: of keys at one time the first is moved to the float before, so
// that the value jumps, and those between the first and the last are dropped.
void separate_times(AnimationChannel& channel) {
  if (std::adjacent_find(channel.times_s.begin(), channel.times_s.end()) == channel.times_s.end()) return;
  const size_t count = channel.times_s.size();
  const size_t width = channel.values.size() / count;
  std::vector<float> times, values;
  for (size_t k = 0; k < count; ++k) {
    float time_s = channel.times_s[k];
    if (k + 1 < count && channel.times_s[k + 1] == time_s) {
      time_s = std::nextafter(time_s, -INFINITY);
      if (channel.times_s[k] == 0.0f || (!times.empty() && times.back() >= time_s)) continue;
    }
    times.push_back(time_s);
    const auto from = channel.values.begin() + static_cast<std::ptrdiff_t>(k * width);
    values.insert(values.end(), from, from + static_cast<std::ptrdiff_t>(width));
  }
  channel.times_s = std::move(times);
  channel.values = std::move(values);
}

// Splits a matrix without shear and with axes of some length into translation, rotation, scale.
std::optional<Transform> split_matrix(const M44f& matrix) {
  V3f axes[3];
  Transform transform;
  for (int row = 0; row < 3; ++row) {
    axes[row] = {matrix[row][0], matrix[row][1], matrix[row][2]};
    transform.scale[row] = axes[row].length();
    transform.translation[row] = matrix[3][row];
    if (!(transform.scale[row] > 0.0f) || !std::isfinite(transform.scale[row])) return std::nullopt;
    axes[row] /= transform.scale[row];
  }
  constexpr float kShear = 1e-4f; // cosine between axes; the rounding of exporters stays far below
  if (std::abs(axes[0].dot(axes[1])) > kShear || std::abs(axes[0].dot(axes[2])) > kShear ||
      std::abs(axes[1].dot(axes[2])) > kShear)
    return std::nullopt;
  if (axes[0].cross(axes[1]).dot(axes[2]) < 0.0f) {
    axes[0] = -axes[0];
    transform.scale[0] = -transform.scale[0];
  }
  M44f rotation;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rotation[row][column] = axes[row][column];
  transform.rotation = Imath::extractQuat(rotation).normalized();
  return transform;
}

// Checks that the node can have the target, and returns the number of values per key. Splits the
// matrix of the node where that is repaired.
int check_target(const Document& document, Scene& scene, const Target& target, const std::string& pointer,
                 Warnings& warnings) {
  if (target.property == AnimatedProperty::member)
    return static_cast<int>(animated_values(scene, target.member).size());
  Node& node = scene.nodes[static_cast<size_t>(target.node)];
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
      const std::string fault =
          fmt::format("node {} has a matrix, expected a node with translation, rotation and scale", target.node);
      constexpr const char* kCode = "ANIMATION_CHANNEL_TARGET_NODE_MATRIX";
      const std::optional<Transform> parts = split_matrix(*node.matrix);
      if (!parts) fail(pointer, fault, kCode);
      warnings.repair("matrix channel", pointer, fault, kCode, "the matrix is split into these");
      node.local = *parts;
      node.matrix.reset();
    }
    return target.property == AnimatedProperty::rotation ? 4 : 3;
  }
}

struct Reader {
  Document& document;
  Scene& scene;
  Warnings& warnings;
};

// Returns channel `c` of animation `a`; none if it has no effect. Throws its fault.
std::optional<AnimationChannel> read_channel(const Reader& reader, size_t a, size_t c) {
  const Document& document = reader.document;
  const tinygltf::Animation& core = document.core.animations[a];
  const json& object = (*document.json)["animations"][a]["channels"][c];
  const std::string pointer = fmt::format("/animations/{}/channels/{}", a, c);
  const auto index = static_cast<size_t>(core.channels[c].sampler);
  if (index >= core.samplers.size()) {
    fail(pointer + "/sampler", fmt::format("{}, the animation has {} samplers", index, core.samplers.size()),
         "UNRESOLVED_REFERENCE");
  }
  const auto target = find_target(core.channels[c], object, pointer, reader.scene, reader.warnings);
  if (!target) return std::nullopt;
  const tinygltf::AnimationSampler& sampler = core.samplers[index];
  if (sampler.input < 0) return std::nullopt; // replaced by check_json()
  AnimationChannel channel;
  channel.node = target->node;
  channel.property = target->property;
  channel.weight = target->weight;
  channel.member = target->member;
  channel.components = check_target(document, reader.scene, *target, pointer + "/target", reader.warnings);
  channel.interpolation = sampler.interpolation == "STEP"          ? Interpolation::step
                          : sampler.interpolation == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                                   : Interpolation::linear;
  if (channel.property == AnimatedProperty::visible) channel.interpolation = Interpolation::step;
  const bool cubic = channel.interpolation == Interpolation::cubic_spline;
  const std::string place = fmt::format("/animations/{}/samplers/{}", a, index);
  channel.times_s = read_times(document, sampler.input, cubic, place + "/input", reader.warnings);
  const size_t scalars = channel.times_s.size() * static_cast<size_t>(channel.components) * (cubic ? 3 : 1);
  read_values(document, sampler.output, scalars, place + "/output", channel, reader.warnings);
  if (lacks_data(document, sampler.input)) { // all times are zero
    reader.warnings.add("no keys", pointer, "an animation without key times has no effect");
    return std::nullopt;
  }
  separate_times(channel);
  if (is_rotation(channel) && !cubic) normalize_rotations(channel.values, place + "/output");
  return channel;
}

// Charges the numbers of all channels before any is read: each has a copy of its keys. An accessor
// with a fault has none.
void charge_keys(Document& document) {
  ElementBudget budget(document);
  const auto numbers_of = [&](int accessor) -> uint64_t {
    try {
      const AccessorView view = view_accessor(document, accessor, "");
      return view.count * static_cast<uint64_t>(view.components);
    } catch (const ImportFailure&) {
      return 0;
    }
  };
  for (size_t a = 0; a < document.core.animations.size(); ++a) {
    const tinygltf::Animation& core = document.core.animations[a];
    std::vector<uint64_t> numbers; // by sampler
    for (const tinygltf::AnimationSampler& sampler : core.samplers)
      numbers.push_back(
          sampler.input < 0 || sampler.output < 0 ? 0 : numbers_of(sampler.input) + numbers_of(sampler.output));
    for (size_t c = 0; c < core.channels.size(); ++c) {
      const auto sampler = static_cast<size_t>(core.channels[c].sampler);
      if (sampler < numbers.size()) budget.charge(numbers[sampler], fmt::format("/animations/{}/channels/{}", a, c));
    }
  }
}

} // namespace

void import_animations(Document& document, Scene& scene, Warnings& warnings) {
  charge_keys(document);
  const Reader reader{document, scene, warnings};
  for (size_t a = 0; a < document.core.animations.size(); ++a) {
    const tinygltf::Animation& core = document.core.animations[a];
    Animation animation;
    animation.name = core.name;
    for (size_t c = 0; c < core.channels.size(); ++c) {
      try {
        if (auto channel = read_channel(reader, a, c)) animation.channels.push_back(std::move(*channel));
      } catch (const ImportFailure& fault) {
        warnings.repair(fmt::format("channel {}", code_of(fault)), fault, "the channel is ignored");
      }
    }
    scene.animations.push_back(std::move(animation));
  }
}

} // namespace kindling::gltf
