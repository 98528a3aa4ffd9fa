// A light tree: selects an emitter with a probability close to its fraction of the irradiance.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/huge_pages.h"
#include "renderer/base/math.h"
#include "renderer/light/light_node.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

// Position, orientation and intensity of one emitter, as the tree uses them. World space.
struct EmitterBounds {
  V3f center{0.0f};
  float radius = 0.0f;        // of a bounding sphere
  V3f axis{0.0f, 0.0f, 1.0f}; // unit, the center of its normals
  float cos_normals = 1.0f;   // cosine of the maximum angle between a normal and the axis; -1: anywhere
  float cos_emission = 0.0f;  // cosine of the maximum angle between light and a normal; falloff follows the cosine
  float intensity = 0.0f;     // luminance of W / sr along the axis; not positive: never selected
  float back = 0.0f;          // weight of the back side: 1 for two-sided emitters, 0 for one-sided
};

// Importance-driven descent through a hierarchy of bounds (Conty Estevez and Kulla, "Importance
// Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018; bounds as in pbrt-v4, section
// 12.6.3), without splitting, with eight children per node, and with estimates of the mean cosines
// at both ends instead of bounds. The importance of a child is zero only if it certainly
// contributes nothing, so every contributing emitter has a positive probability. Up to two emitters
// are selected by their intensity alone.
//
// Immutable, thread-safe, without allocation after construction. Built in parallel, independent of
// the thread count.
class LightTree {
 public:
  LightTree() = default;
  explicit LightTree(std::span<const EmitterBounds> emitters);

  struct Choice {
    uint32_t emitter = 0; // index into the constructor's emitters
    float probability = 0.0f;
    double u = 0.0; // remainder of the random number: again uniform in [0, 1)
  };

  // Selects an emitter; u in [0, 1). `normal` is unit: light below its horizon is not wanted; zero:
  // light from all directions. Empty: nothing reaches the point. That may be detected below the
  // root, too, so the sum of all probabilities may be less than one.
  [[nodiscard]] std::optional<Choice> choose(const V3f& point, const V3f& normal, double u) const {
    if (!by_intensity_) return choose_by_importance(point, normal, u);
    const auto first = static_cast<double>(few_probability_[0]);
    if (u < first) return Choice{few_[0], few_probability_[0], u / first};
    return Choice{few_[1], few_probability_[1], (u - first) / (1.0 - first)};
  }
  // The same choices for many points, interleaved to hide memory latency.
  struct Query {
    V3f point;
    V3f normal;
    double u = 0.0;
  };
  void choose(std::span<const Query> queries, std::span<std::optional<Choice>> choices) const;
  // Returns the probability with which choose() selects this emitter; 0 if never.
  [[nodiscard]] float probability(uint32_t emitter, const V3f& point, const V3f& normal) const {
    if (!by_intensity_) return probability_by_importance(emitter, point, normal);
    return emitter == few_[0] ? few_probability_[0] : emitter == few_[1] ? few_probability_[1] : 0.0f;
  }
  // Returns the root's estimate of the unoccluded irradiance (luminance) of all emitters. Zero only
  // if none can reach the point.
  [[nodiscard]] float irradiance(const V3f& point, const V3f& normal) const;

  [[nodiscard]] bool empty() const { return nodes_.empty(); }
  // True if choices do not depend on the point.
  [[nodiscard]] bool by_intensity() const { return by_intensity_; }
  [[nodiscard]] size_t memory_bytes() const {
    return nodes_.size() * sizeof(LightNode) + (emitters_.size() + places_.size()) * sizeof(uint32_t);
  }

 private:
  friend class LightTreeBuilder;
  static constexpr uint32_t kWidth = LightNode::kWidth;
  static constexpr uint32_t kNowhere = ~0U;

  // State of a descent.
  struct Descent {
    V3f point;
    V3f normal;
    uint32_t node = 0;
    Choice choice;
  };
  static constexpr size_t kMaxGroup = 32;

  [[nodiscard]] bool step(Descent& descent) const;
  [[nodiscard]] std::optional<Choice> end(const Descent& descent) const;
  void descend(std::span<Descent> descents) const;
  [[nodiscard]] std::optional<Choice> choose_by_importance(const V3f& point, const V3f& normal, double u) const;
  [[nodiscard]] float probability_by_importance(uint32_t emitter, const V3f& point, const V3f& normal) const;

  HugePageVector<LightNode> nodes_;   // root first
  HugePageVector<uint32_t> emitters_; // in the order of the leaves
  HugePageVector<uint32_t> places_;   // by emitter: node * 8 + lane, or kNowhere
  float total_intensity_ = 0.0f;      // of all emitters; intensities of the nodes are relative to it
  bool by_intensity_ = false;         // up to two emitters
  uint32_t few_[2] = {kNowhere, kNowhere};
  float few_probability_[2] = {1.0f, 0.0f};
};

} // namespace kindling
