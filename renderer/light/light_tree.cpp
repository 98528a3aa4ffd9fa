// Descends the light tree, and retraces the path to an emitter.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_tree.h"

#include "renderer/base/prefetch.h"
#include "renderer/light/lanes.h"

#include <array>
#include <cassert>
#include <cstddef>

namespace kindling {

namespace {

// Returns the estimated unoccluded irradiance (luminance) of each child at the point, on a surface
// with this normal (unit; zero: from any side). Zero only if the child certainly contributes
// nothing.
inline Float8 importances(const LightNode& node, const V3f& point, const V3f& normal) {
  // Cosines this far below zero still count as positive: rounding must not hide a light.
  constexpr float kBelowHorizon = 1e-5f;
  // Minimum fraction for a family that may emit from the edge of its bounds, where the estimate is
  // unreliable.
  constexpr float kMin = 0.01f;
  // Emitters are spread over the sphere, so the mean of 1 / distance^2 is bounded inside of it.
  // Tuned for minimum variance in a hall of a thousand bulbs, like the 0.42 below.
  constexpr float kClamp2 = 0.35f;
  const Float8 dx = to_float(node.x) * node.step + (node.origin[0] - point.x);
  const Float8 dy = to_float(node.y) * node.step + (node.origin[1] - point.y);
  const Float8 dz = to_float(node.z) * node.step + (node.origin[2] - point.z);
  const Float8 r = to_float(node.radius) * node.step;
  const Float8 distance2 = dx * dx + dy * dy + dz * dz;
  const Float8 radius2 = r * r;
  const Float8 clamped2 = larger(larger(distance2, radius2 * kClamp2), splat(1e-20f));
  const Float8 inverse2 = 1.0f / clamped2;
  const Float8 inverse = square_root(clamped2) * inverse2; // root and quotient are computed in parallel
  const Float8 sin_u = smaller(r * inverse, splat(1.0f));  // of the half-angle of the sphere seen from the point

  // The mean cosine of a sphere above the horizon is that of its center. For a sphere cut by the
  // horizon 0.42 (center + radius) is a good approximation, which reaches zero where the sphere has
  // set.
  const Float8 cos_i = (dx * normal.x + dy * normal.y + dz * normal.z) * inverse;
  const bool any_side = normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f;
  const Float8 received = larger(larger(cos_i, (cos_i + sin_u) * 0.42f + kBelowHorizon), splat(any_side ? 1.0f : 0.0f));

  const Float8 cos_t = (to_float(node.axis_x) * dx + to_float(node.axis_y) * dy + to_float(node.axis_z) * dz) *
                       (inverse * (-1.0f / 127.0f));
  // |c| averaged over the directions within the sphere.
  const Float8 abs_t = absolute(cos_t);
  const Float8 spread_t = larger(abs_t, sin_u * 0.5f + abs_t * 0.25f);
  const Float8 sent =
      to_float(node.odd) * (1.0f / 255.0f) * cos_t + to_float(node.flat) * (1.0f / 255.0f) * (spread_t - 0.5f) + 0.5f;
  // cos(a + u) >= cos a - 2 sin(u / 2) >= cos a - sqrt(2) sin u.
  const Float8 edge = to_float(node.cos_reach) * (1.0f / 127.0f) - sin_u * 1.41422f;
  const Int8 reaches = (cos_t > edge) | (distance2 <= radius2);

  return where(reaches, from_upper_bits(node.even) * larger(sent, splat(kMin)) * received * inverse2);
}

} // namespace

// Descends one level. Returns false at the end: at an emitter, or where nothing reaches the point
// (choice.probability is 0).
inline bool LightTreeView::step(Descent& descent) const {
  const LightNode& node = nodes[descent.node];
  Choice& choice = descent.choice;
  prefetch(emitters.data() + node.first_emitter);
  const Float8 weights = importances(node, descent.point, descent.normal);
  const Float8 sums = running_sums(weights);
  const float sum = sums[7];
  if (!(sum > 0.0f)) {
    choice.probability = 0.0f;
    return false;
  }
  // The choice uses single precision, which is faster; the remainder of u keeps all digits.
  uint32_t lane = std::min(count_up_to(sums, static_cast<float>(choice.u) * sum), kWidth - 1);
  // u was rounded up to the sum, or two sums that should be equal differ.
  while (!(weights[lane] > 0.0f)) lane = (lane + kWidth - 1) % kWidth;
  const float weight = weights[lane];
  const auto before = static_cast<double>(sums_before(sums, lane));
  choice.u = std::clamp((choice.u * static_cast<double>(sum) - before) / static_cast<double>(weight), 0.0,
                        0x1.fffffffffffffp-1);
  choice.probability *= weight / sum;
  if (!node.is_inner(lane)) {
    choice.emitter = node.emitter(lane); // an index into emitters until end()
    return false;
  }
  descent.node = node.child(lane);
  return true;
}

std::optional<LightTreeView::Choice> LightTreeView::end(const Descent& descent) const {
  if (!(descent.choice.probability > 0.0f)) return std::nullopt;
  Choice choice = descent.choice;
  choice.emitter = emitters[choice.emitter];
  return choice;
}

std::optional<LightTreeView::Choice> LightTreeView::choose_by_importance(const V3f& point, const V3f& normal,
                                                                         double u) const {
  if (nodes.empty()) return std::nullopt;
  Descent descent{point, normal, 0, {0, 1.0f, u}};
  while (step(descent)) {
  }
  return end(descent);
}

// All descents advance one level before any continues, so that memory latency and dependency chains
// overlap.
void LightTreeView::descend(std::span<Descent> descents) const {
  assert(descents.size() <= kMaxGroup);
  std::array<uint32_t, kMaxGroup> going;
  uint32_t count = 0;
  for (uint32_t i = 0; i < descents.size(); ++i) going[count++] = i;
  while (count > 0) {
    uint32_t remaining = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t index = going[i];
      if (!step(descents[index])) continue;
      const LightNode* next = &nodes[descents[index].node];
      prefetch(next);
      prefetch(reinterpret_cast<const std::byte*>(next) + 64);
      going[remaining++] = index;
    }
    count = remaining;
  }
}

void LightTreeView::choose(std::span<const Query> queries, std::span<std::optional<Choice>> choices) const {
  assert(choices.size() >= queries.size());
  if (by_intensity || nodes.empty()) {
    for (size_t i = 0; i < queries.size(); ++i) choices[i] = choose(queries[i].point, queries[i].normal, queries[i].u);
    return;
  }
  std::array<Descent, kMaxGroup> descents;
  for (size_t first = 0; first < queries.size(); first += kMaxGroup) {
    const size_t count = std::min(kMaxGroup, queries.size() - first);
    for (size_t i = 0; i < count; ++i) {
      const Query& query = queries[first + i];
      descents[i] = {query.point, query.normal, 0, {0, 1.0f, query.u}};
    }
    descend(std::span(descents).first(count));
    for (size_t i = 0; i < count; ++i) choices[first + i] = end(descents[i]);
  }
}

float LightTreeView::probability_by_importance(uint32_t emitter, const V3f& point, const V3f& normal) const {
  assert(places.empty() || emitter < places.size());
  uint32_t place = places.empty() ? kNowhere : places[emitter];
  if (place == kNowhere) return 0.0f;
  float result = 1.0f;
  for (;;) {
    const uint32_t number = place / kWidth;
    const LightNode& node = nodes[number];
    const Float8 weights = importances(node, point, normal);
    const float sum = running_sums(weights)[7];
    if (!(sum > 0.0f)) return 0.0f;
    result *= weights[place % kWidth] / sum;
    if (number == 0 || !(result > 0.0f)) return result;
    place = node.parent;
  }
}

float LightTreeView::irradiance(const V3f& point, const V3f& normal) const {
  if (nodes.empty()) return 0.0f;
  return running_sums(importances(nodes[0], point, normal))[7] * total_intensity;
}

} // namespace kindling
