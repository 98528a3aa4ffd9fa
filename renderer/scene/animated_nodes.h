// The animated node tree of a Scene: transforms, visibility, morph weights and world matrices.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <optional>
#include <unordered_map>
#include <vector>

namespace kindling {

// Covers every node, also those outside of the scene shown, because skins may name joints there.
// The Scene must outlive this object.
class AnimatedNodes {
 public:
  // Starts at `time_s`, or in the rest pose if it is unset.
  AnimatedNodes(const Scene& scene, const std::optional<double>& time_s);

  // Applies all animations at `time_s`, later ones over earlier ones. The cost is proportional to
  // the number of animated nodes.
  void set_time(double time_s);

  [[nodiscard]] const M44f& to_world(int node) const { return to_world_[static_cast<size_t>(node)]; }
  [[nodiscard]] bool visible(int node) const {
    return visible_[static_cast<size_t>(node)] != 0;
  } // the node's own flag, without its ancestors
  // Returns the morph weights of a node with a mesh: animated, else the node's, else the mesh's.
  [[nodiscard]] const std::vector<float>& morph_weights(int node) const;
  // Returns, for each joint, its inverse bind matrix times its joint-to-world matrix.
  [[nodiscard]] std::vector<M44f> joint_matrices(const Skin& skin) const;

  // True if to_world(), respectively morph_weights(), may depend on the time.
  [[nodiscard]] bool moves(int node) const { return moves_[static_cast<size_t>(node)] != 0; }
  [[nodiscard]] bool has_animated_weights(int node) const { return weights_.count(node) != 0; }

 private:
  struct Entry {
    int node;
    int parent;
  };
  void apply(const AnimationChannel& channel, double time_s);
  void place(const Entry& entry);

  const Scene& scene_;
  std::vector<Transform> local_;
  std::vector<uint8_t> visible_;
  std::vector<uint8_t> moves_;
  std::vector<M44f> to_world_;
  std::vector<Entry> moving_;                           // parents first
  std::unordered_map<int, std::vector<float>> weights_; // only nodes whose weights are animated
  std::vector<float> value_;                            // values of the channel being applied
};

// Returns all nodes without a parent.
[[nodiscard]] std::vector<int> parentless_nodes(const Scene& scene);

// Calls visit(node, parent) for the roots and their descendants, parents first, siblings in order.
// It does not recurse, since trees may be deep. Each node is visited once, even if a broken file
// names it twice.
template <typename Visit>
void walk_nodes(const Scene& scene, const std::vector<int>& roots, const Visit& visit) {
  struct Entry {
    int node;
    int parent;
  };
  std::vector<Entry> stack;
  std::vector<uint8_t> seen(scene.nodes.size(), 0);
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, kNone});
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    const auto index = static_cast<size_t>(entry.node);
    if (seen[index]) continue;
    seen[index] = 1;
    visit(entry.node, entry.parent);
    const std::vector<int>& children = scene.nodes[index].children;
    for (auto child = children.rbegin(); child != children.rend(); ++child) stack.push_back({*child, entry.node});
  }
}

} // namespace kindling
