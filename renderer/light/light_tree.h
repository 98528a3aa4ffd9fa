// A light tree: selects an emitter with a probability close to its fraction of the irradiance.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/light/light_node.h"

#include <cstdint>
#include <optional>
#include <span>

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
// Immutable, thread-safe.
struct LightTreeView {
  struct Choice {
    uint32_t emitter = 0; // index into the constructor's emitters
    float probability = 0.0f;
    double u = 0.0; // remainder of the random number: again uniform in [0, 1)
  };

  // Selects an emitter; u in [0, 1). `normal` is unit: light below its horizon is not wanted; zero:
  // light from all directions. Empty: nothing reaches the point. That may be detected below the
  // root, too, so the sum of all probabilities may be less than one.
  [[nodiscard]] std::optional<Choice> choose(const V3f& point, const V3f& normal, double u) const {
    if (!by_intensity) return choose_by_importance(point, normal, u);
    const auto first = static_cast<double>(few_probability[0]);
    if (u < first) return Choice{few[0], few_probability[0], u / first};
    return Choice{few[1], few_probability[1], (u - first) / (1.0 - first)};
  }
  // The same choices for many points, interleaved to hide memory latency. A query is not
  // initialized, so that arrays of them cost nothing.
  struct Query {
    V3f point;
    V3f normal;
    double u;
  };
  void choose(std::span<const Query> queries, std::span<std::optional<Choice>> choices) const;
  // Returns the probability with which choose() selects this emitter; 0 if never.
  [[nodiscard]] float probability(uint32_t emitter, const V3f& point, const V3f& normal) const {
    if (!by_intensity) return probability_by_importance(emitter, point, normal);
    return emitter == few[0] ? few_probability[0] : emitter == few[1] ? few_probability[1] : 0.0f;
  }
  // Returns the root's estimate of the unoccluded irradiance (luminance) of all emitters. Zero only
  // if none can reach the point.
  [[nodiscard]] float irradiance(const V3f& point, const V3f& normal) const;

  [[nodiscard]] bool empty() const { return nodes.empty(); }

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

  std::span<const LightNode> nodes;   // root first
  std::span<const uint32_t> emitters; // in the order of the leaves
  std::span<const uint32_t> places;   // by emitter: node * 8 + lane, or kNowhere
  float total_intensity = 0.0f;       // of all emitters; intensities of the nodes are relative to it
  bool by_intensity = false;          // up to two emitters: choices do not depend on the point
  uint32_t few[2] = {kNowhere, kNowhere};
  float few_probability[2] = {1.0f, 0.0f};
};

// Built in parallel, independent of the thread count.
class LightTree : public LightTreeView {
 public:
  LightTree() = default;
  explicit LightTree(std::span<const EmitterBounds> bounds);

  [[nodiscard]] size_t memory_bytes() const { return arrays_.bytes(); }

 private:
  OwnedArrays arrays_;
};

} // namespace kindling
