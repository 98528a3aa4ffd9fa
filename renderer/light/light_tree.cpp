// Descending the light tree, and retracing the way to an emitter.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_tree.h"

namespace kindling {

namespace {

// Cosines this far below zero still count as positive: rounding must not hide a light. (Also an angle, near 90 degrees.)
constexpr float kHorizon = 1e-5f;

// cos(max(a - b, 0)) of angles in [0, pi] that are given by their cosines and sines.
inline float cos_of_difference(float cos_a, float sin_a, float cos_b, float sin_b) {
  return cos_a > cos_b ? 1.0f : cos_a * cos_b + sin_a * sin_b;
}

inline float sine(float cosine) {
  const float sine2 = 1.0f - cosine * cosine;
  return std::sqrt(sine2 > 0.0f ? sine2 : 0.0f);
}

// In the order in which choose() adds up.
inline float sum_of(const float (&values)[8]) {
  float sum = 0.0f;
  for (const float value : values) sum += value;
  return sum;
}

} // namespace

// One pass over eight lanes without branches: the compiler turns it into vector instructions.
LightTree::Lanes LightTree::importances(const Node& node, const V3f& point, const V3f& normal) {
  Lanes result;
  const float any_side = normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f ? 1.0f : 0.0f;
  const float px = point.x, py = point.y, pz = point.z;
  const float nx = normal.x, ny = normal.y, nz = normal.z;
  for (uint32_t i = 0; i < kWidth; ++i) {
    const float dx = node.center_x[i] - px;
    const float dy = node.center_y[i] - py;
    const float dz = node.center_z[i] - pz;
    const float distance2 = dx * dx + dy * dy + dz * dz;
    const float radius2 = node.radius[i] * node.radius[i];
    const float far2 = distance2 > radius2 ? distance2 : radius2; // inside of the bounds distance says nothing
    const float inverse2 = 1.0f / (far2 > 1e-20f ? far2 : 1e-20f);
    const float inverse = std::sqrt(inverse2);
    // The bounds' sphere seen from the point: a cone of half-angle u.
    const float sin2_u = radius2 * inverse2;
    const float sin_u = std::sqrt(sin2_u);
    const float cos_u = std::sqrt(sin2_u < 1.0f ? 1.0f - sin2_u : 0.0f);
    const bool inside = distance2 <= radius2;

    const float cos_i = (nx * dx + ny * dy + nz * dz) * inverse;
    const float near_i = cos_of_difference(cos_i, sine(cos_i), cos_u, sin_u) + kHorizon;
    const float received = inside ? 1.0f : near_i > any_side ? near_i : any_side;

    const float cos_o = node.cos_normals[i];
    const float sin_o = sine(cos_o);
    const float cos_t = -(node.axis_x[i] * dx + node.axis_y[i] * dy + node.axis_z[i] * dz) * inverse;
    const float sin_t = sine(cos_t);
    const float front_u = cos_of_difference(cos_t, sin_t, cos_u, sin_u);
    const float back_u = cos_of_difference(-cos_t, sin_t, cos_u, sin_u);
    const float front_o = cos_of_difference(front_u, sine(front_u), cos_o, sin_o) + kHorizon;
    const float back_o = cos_of_difference(back_u, sine(back_u), cos_o, sin_o) + kHorizon;
    const float front = front_o > node.cos_emission[i] ? front_o : 0.0f;
    const float back = (back_o > node.cos_emission[i] ? back_o : 0.0f) * node.back[i];
    const float brighter = front > back ? front : back;
    const float emitted = inside ? 1.0f : brighter;

    const float importance = node.intensity[i] * emitted * received * inverse2;
    result.value[i] = importance > 0.0f ? importance : 0.0f;
  }
  return result;
}

std::optional<LightTree::Choice> LightTree::choose_by_importance(const V3f& point, const V3f& normal, double u) const {
  if (nodes_.empty()) return std::nullopt;
  Choice choice{0, 1.0f, u};
  const Node* node = nodes_.data();
  for (;;) {
    const Lanes lanes = importances(*node, point, normal);
    const float* weights = lanes.value;
    float cumulative[kWidth];
    float sum = 0.0f;
    for (uint32_t i = 0; i < kWidth; ++i) cumulative[i] = sum += weights[i];
    if (!(sum > 0.0f)) return std::nullopt;
    const double target = choice.u * static_cast<double>(sum);
    const auto rounded = static_cast<float>(target);
    uint32_t lane = 0;
    for (uint32_t i = 0; i < kWidth; ++i) lane += cumulative[i] <= rounded ? 1 : 0;
    if (lane == kWidth) { // rounded up to the sum
      lane = kWidth - 1;
      while (!(weights[lane] > 0.0f)) --lane;
    }
    const double before = lane > 0 ? static_cast<double>(cumulative[lane - 1]) : 0.0;
    choice.u = std::clamp((target - before) / static_cast<double>(weights[lane]), 0.0, 0x1.fffffffffffffp-1);
    choice.probability *= weights[lane] / sum;
    const uint32_t child = node->child[lane];
    if ((child & kEmitterBit) != 0) {
      choice.emitter = child & ~kEmitterBit;
      return choice;
    }
    node = &nodes_[child];
  }
}

float LightTree::probability_by_importance(uint32_t emitter, const V3f& point, const V3f& normal) const {
  uint32_t place = places_.empty() ? kNowhere : places_[emitter];
  if (place == kNowhere) return 0.0f;
  float result = 1.0f;
  for (;;) {
    const uint32_t node = place / kWidth;
    const Lanes lanes = importances(nodes_[node], point, normal);
    const float sum = sum_of(lanes.value);
    if (!(sum > 0.0f)) return 0.0f;
    result *= lanes.value[place % kWidth] / sum;
    if (node == 0 || !(result > 0.0f)) return result;
    place = parents_[node];
  }
}

float LightTree::irradiance(const V3f& point, const V3f& normal) const {
  if (nodes_.empty()) return 0.0f;
  return sum_of(importances(nodes_[0], point, normal).value) * total_intensity_;
}

} // namespace kindling
