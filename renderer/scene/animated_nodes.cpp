// Applies the animations to the node tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/animated_nodes.h"

#include "renderer/scene/animation.h"
#include "renderer/scene/pose.h"

#include <cassert>
#include <utility>

namespace kindling {
namespace {

bool targets_node(const AnimationChannel& channel) {
  return channel.node != kNone && !channel.times_s.empty() && channel.components > 0 &&
         channel.property != AnimatedProperty::member;
}

bool changes_transform(const AnimationChannel& channel) {
  return channel.property == AnimatedProperty::translation || channel.property == AnimatedProperty::rotation ||
         channel.property == AnimatedProperty::scale;
}

} // namespace

AnimatedNodes::AnimatedNodes(const Scene& scene, const std::optional<double>& time_s)
    : scene_(scene), moves_(scene.nodes.size(), 0), to_world_(scene.nodes.size()) {
  local_.reserve(scene.nodes.size());
  visible_.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) {
    local_.push_back(node.local);
    visible_.push_back(node.visible ? 1 : 0);
  }
  if (time_s) {
    for (const Animation& animation : scene.animations) {
      for (const AnimationChannel& channel : animation.channels) {
        if (!targets_node(channel)) continue;
        apply(channel, *time_s);
        const auto node = static_cast<size_t>(channel.node);
        if (changes_transform(channel) && !scene.nodes[node].matrix) moves_[node] = 1;
      }
    }
  }
  walk_nodes(scene, parentless_nodes(scene), [&](int node, int parent) {
    const auto i = static_cast<size_t>(node);
    if (parent != kNone && moves_[static_cast<size_t>(parent)]) moves_[i] = 1;
    if (moves_[i]) moving_.push_back({node, parent});
    place({node, parent});
  });
}

void AnimatedNodes::set_time(double time_s) {
  for (const Animation& animation : scene_.animations) {
    for (const AnimationChannel& channel : animation.channels) {
      if (targets_node(channel)) apply(channel, time_s);
    }
  }
  for (const Entry& entry : moving_) place(entry);
}

const std::vector<float>& AnimatedNodes::morph_weights(int node) const {
  const auto animated = weights_.find(node);
  if (animated != weights_.end()) return animated->second;
  const Node& n = scene_.nodes[static_cast<size_t>(node)];
  return n.weights.empty() ? scene_.meshes[static_cast<size_t>(n.mesh)].weights : n.weights;
}

std::vector<M44f> AnimatedNodes::joint_matrices(const Skin& skin) const {
  std::vector<M44f> matrices;
  matrices.reserve(skin.joints.size());
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    const M44f& joint_to_world = to_world(skin.joints[j]);
    matrices.push_back(j < skin.inverse_bind_matrices.size() ? skin.inverse_bind_matrices[j] * joint_to_world
                                                             : joint_to_world);
  }
  return matrices;
}

void AnimatedNodes::apply(const AnimationChannel& channel, double time_s) {
  const auto node = static_cast<size_t>(channel.node);
  assert(node < local_.size());
  value_.resize(static_cast<size_t>(channel.components));
  sample_channel(channel, time_s, value_);
  switch (channel.property) {
  case AnimatedProperty::translation: local_[node].translation = {value_[0], value_[1], value_[2]}; break;
  case AnimatedProperty::rotation: local_[node].rotation = Quatf(value_[3], value_[0], value_[1], value_[2]); break;
  case AnimatedProperty::scale: local_[node].scale = {value_[0], value_[1], value_[2]}; break;
  case AnimatedProperty::weights:
    if (channel.weight == kNone) {
      weights_[channel.node] = value_;
    } else { // one weight of the list is replaced
      std::vector<float> weights = morph_weights(channel.node);
      const auto index = static_cast<size_t>(channel.weight);
      if (weights.size() <= index) weights.resize(index + 1, 0.0f);
      weights[index] = value_[0];
      weights_[channel.node] = std::move(weights);
    }
    break;
  case AnimatedProperty::visible: visible_[node] = value_[0] != 0.0f; break;
  case AnimatedProperty::member: break; // not a node property; see animate_members()
  }
}

void AnimatedNodes::place(const Entry& entry) {
  const auto i = static_cast<size_t>(entry.node);
  const M44f local = scene_.nodes[i].matrix ? *scene_.nodes[i].matrix : to_matrix(local_[i]);
  to_world_[i] = entry.parent == kNone ? local : local * to_world_[static_cast<size_t>(entry.parent)];
}

M44f to_matrix(const Transform& transform) {
  M44f m = transform.rotation.toMatrix44();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[row][column] *= transform.scale[row];
  }
  for (int column = 0; column < 3; ++column) m[3][column] = transform.translation[column];
  return m;
}

std::vector<int> parentless_nodes(const Scene& scene) {
  std::vector<uint8_t> has_parent(scene.nodes.size(), 0);
  for (const Node& node : scene.nodes) {
    for (const int child : node.children) has_parent[static_cast<size_t>(child)] = 1;
  }
  std::vector<int> roots;
  for (size_t i = 0; i < has_parent.size(); ++i) {
    if (!has_parent[i]) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

} // namespace kindling
