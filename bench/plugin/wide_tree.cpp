// Chooses the nodes of the wide tree by dynamic programming, and quantizes their children.
// SPDX-License-Identifier: Apache-2.0
#include "bench/plugin/wide_tree.h"

namespace compressed_bvh {

namespace {

// Costs of testing a node, a block of a leaf, and a triangle more in it, relative to each other
// (section 3.1 of the paper, which has no blocks).
constexpr double kNodeCost = 1.0, kBlockCost = 0.6, kTriangleCost = 0.02;

// The least cost of a subtree as a forest of at most i + 1 trees, and how it comes about.
struct Choice {
  enum class Kind : uint8_t { leaf, inner, distribute };
  float cost = 0.0f;
  Kind kind = Kind::leaf;
  uint8_t left = 0, right = 0; // of `distribute`, and of `inner` for its eight children: trees of either side
};

class Widener {
 public:
  Widener(const std::vector<BinaryNode>& binary, size_t leaf_size)
      : binary_(binary), leaf_size_(leaf_size), counts_(binary.size()), choices_(binary.size() * kForests) {}

  WideTree widen() {
    WideTree tree;
    if (binary_.empty()) return tree;
    tree.box = binary_.front().box;
    choose();
    tree.nodes.emplace_back();
    // A root that would be a leaf is a node with this leaf alone.
    struct Task {
      uint32_t binary;
      uint32_t node;
      bool whole; // a leaf in place of a node
    };
    std::vector<Task> tasks{{0, 0, choice(0, 1).kind == Choice::Kind::leaf}};
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      std::vector<uint32_t> children;
      if (task.whole) {
        children.push_back(task.binary);
      } else {
        const Choice& inner = choice(task.binary, 1);
        gather(task.binary + 1, inner.left, children);
        gather(binary_[task.binary].right, inner.right, children);
      }
      const std::array<int, kWidth> slots = assign_slots(binary_[task.binary].box, children);
      WideNode node = quantize(binary_[task.binary].box, children, slots);
      node.first_child = static_cast<uint32_t>(tree.nodes.size());
      node.first_leaf = static_cast<uint32_t>(tree.leaves.size());
      for (size_t slot = 0; slot < kWidth; ++slot) {
        if (slots[slot] < 0) continue;
        const uint32_t child = children[static_cast<size_t>(slots[slot])];
        const auto bit = static_cast<uint8_t>(1U << slot);
        if (choice(child, 1).kind == Choice::Kind::leaf) {
          node.leaf |= bit;
          const auto first = static_cast<uint32_t>(tree.order.size());
          collect(child, tree.order);
          tree.leaves.push_back({first, static_cast<uint32_t>(tree.order.size()) - first});
        } else {
          node.inner |= bit;
          tasks.push_back({child, static_cast<uint32_t>(tree.nodes.size()), false});
          tree.nodes.emplace_back();
        }
      }
      tree.nodes[task.node] = node;
    }
    return tree;
  }

 private:
  static constexpr size_t kForests = kWidth - 1; // of 1 to 7 trees

  Choice& choice(uint32_t node, size_t trees) { return choices_[node * kForests + trees - 1]; }

  // Children follow their parent, so backwards all costs of children are known.
  void choose() {
    for (size_t n = binary_.size(); n-- > 0;) {
      const auto node = static_cast<uint32_t>(n);
      const uint32_t left = node + 1, right = binary_[n].right;
      counts_[n] = right == 0 ? 1 : counts_[left] + counts_[right];
      const double area = binary_[n].box.area();
      constexpr float kNever = std::numeric_limits<float>::infinity();
      const float as_leaf =
          counts_[n] <= leaf_size_
              ? static_cast<float>(area * (kBlockCost + kTriangleCost * static_cast<double>(counts_[n])))
              : kNever;
      if (right == 0) {
        for (size_t trees = 1; trees <= kForests; ++trees) choice(node, trees) = {as_leaf, Choice::Kind::leaf, 0, 0};
        continue;
      }
      Choice inner = distribute(left, right, kWidth);
      inner.cost += static_cast<float>(area * kNodeCost);
      inner.kind = Choice::Kind::inner;
      choice(node, 1) = as_leaf <= inner.cost ? Choice{as_leaf, Choice::Kind::leaf, inner.left, inner.right} : inner;
      for (size_t trees = 2; trees <= kForests; ++trees) {
        const Choice split = distribute(left, right, trees);
        choice(node, trees) = split.cost < choice(node, trees - 1).cost ? split : choice(node, trees - 1);
      }
    }
  }

  Choice distribute(uint32_t left, uint32_t right, size_t trees) {
    Choice best{std::numeric_limits<float>::infinity(), Choice::Kind::distribute, 1, 1};
    for (size_t k = 1; k < trees; ++k) {
      if (k > kForests || trees - k > kForests) continue;
      const float cost = choice(left, k).cost + choice(right, trees - k).cost;
      if (cost < best.cost)
        best = {cost, Choice::Kind::distribute, static_cast<uint8_t>(k), static_cast<uint8_t>(trees - k)};
    }
    return best;
  }

  // The roots of the trees of a subtree as a forest of at most `trees`.
  void gather(uint32_t node, size_t trees, std::vector<uint32_t>& roots) {
    const Choice& chosen = choice(node, trees);
    if (chosen.kind != Choice::Kind::distribute) {
      roots.push_back(node);
      return;
    }
    gather(node + 1, chosen.left, roots);
    gather(binary_[node].right, chosen.right, roots);
  }

  // The primitives of a subtree, which are the leaves among its consecutive nodes.
  void collect(uint32_t node, std::vector<uint32_t>& order) const {
    for (size_t n = node; n < node + 2 * counts_[node] - 1; ++n)
      if (binary_[n].right == 0) order.push_back(binary_[n].primitive);
  }

  // The child of each slot or -1. The child that gains most by its best slot chooses first (the
  // paper has an auction, whose result is little better).
  std::array<int, kWidth> assign_slots(const Box& box, const std::vector<uint32_t>& children) const {
    std::array<int, kWidth> slots{};
    slots.fill(-1);
    std::array<bool, kWidth> placed{};
    for (size_t round = 0; round < children.size(); ++round) {
      double best = -std::numeric_limits<double>::infinity();
      size_t best_child = kWidth, best_slot = 0;
      for (size_t child = 0; child < children.size(); ++child) {
        if (placed[child]) continue;
        for (size_t slot = 0; slot < kWidth; ++slot) {
          if (slots[slot] >= 0) continue;
          double gain = 0.0;
          for (size_t k = 0; k < 3; ++k) {
            const double offset = binary_[children[child]].box.middle(k) - box.middle(k);
            gain += (slot >> k & 1) != 0 ? offset : -offset;
          }
          if (best_child == kWidth || gain > best) {
            best = gain;
            best_child = child;
            best_slot = slot;
          }
        }
      }
      slots[best_slot] = static_cast<int>(best_child);
      placed[best_child] = true;
    }
    return slots;
  }

  // Planes of children are rounded outwards, and checked as they are decoded.
  WideNode quantize(const Box& box, const std::vector<uint32_t>& children, const std::array<int, kWidth>& slots) const {
    WideNode node;
    node.origin = box.low;
    for (size_t k = 0; k < 3; ++k) {
      const double size = static_cast<double>(box.high[k]) - box.low[k];
      int exponent = size > 0.0 ? static_cast<int>(std::ceil(std::log2(size / 255.0))) : -126;
      exponent = std::clamp(exponent, -126, 127);
      while (exponent < 127 && decoded(box.low[k], 255, exponent) < box.high[k]) ++exponent;
      node.exponent[k] = static_cast<int8_t>(exponent);
      for (size_t slot = 0; slot < kWidth; ++slot) {
        node.low[k][slot] = 255; // empty
        if (slots[slot] < 0) continue;
        const Box& child = binary_[children[static_cast<size_t>(slots[slot])]].box;
        const double scale = std::ldexp(1.0, -exponent);
        int low = static_cast<int>(std::floor((static_cast<double>(child.low[k]) - box.low[k]) * scale));
        int high = static_cast<int>(std::ceil((static_cast<double>(child.high[k]) - box.low[k]) * scale));
        low = std::clamp(low, 0, 255);
        high = std::clamp(high, 0, 255);
        while (low > 0 && decoded(box.low[k], low, exponent) > child.low[k]) --low;
        while (high < 255 && decoded(box.low[k], high, exponent) < child.high[k]) ++high;
        node.low[k][slot] = static_cast<uint8_t>(low);
        node.high[k][slot] = static_cast<uint8_t>(high);
      }
    }
    return node;
  }

  static double decoded(float origin, int plane, int exponent) {
    return static_cast<double>(origin) + std::ldexp(static_cast<double>(plane), exponent);
  }

  const std::vector<BinaryNode>& binary_;
  size_t leaf_size_;
  std::vector<uint32_t> counts_; // primitives of each subtree
  std::vector<Choice> choices_;
};

} // namespace

WideTree widen(const std::vector<BinaryNode>& binary, size_t leaf_size) {
  return Widener(binary, std::clamp<size_t>(leaf_size, 1, kLeafSize)).widen();
}

} // namespace compressed_bvh
