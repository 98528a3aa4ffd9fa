// Descending the light tree, and retracing the way to an emitter.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_tree.h"

namespace kindling {

std::optional<LightTree::Choice> LightTree::choose_by_importance(const V3f& point, const V3f& normal, double u) const {
  if (nodes_.empty()) return std::nullopt;
  Choice choice{0, 1.0f, u};
  const LightNode* node = nodes_.data();
  for (;;) {
    __builtin_prefetch(emitters_.data() + node->first_emitter);
    const Float8 weights = node->importances(point, normal);
    const Float8 sums = running_sums(weights);
    const float sum = sums[7];
    if (!(sum > 0.0f)) return std::nullopt;
    const double target = choice.u * static_cast<double>(sum);
    uint32_t lane = std::min(count_up_to(sums, static_cast<float>(target)), kWidth - 1);
    // Rounded up to the sum, or two sums that should be equal are not.
    while (!(weights[lane] > 0.0f)) lane = (lane + kWidth - 1) % kWidth;
    const double before = lane > 0 ? static_cast<double>(sums[lane - 1]) : 0.0;
    const float weight = weights[lane];
    choice.u = std::clamp((target - before) / static_cast<double>(weight), 0.0, 0x1.fffffffffffffp-1);
    choice.probability *= weight / sum;
    if (!node->is_inner(lane)) {
      choice.emitter = emitters_[node->emitter(lane)];
      return choice;
    }
    node = &nodes_[node->child(lane)];
  }
}

float LightTree::probability_by_importance(uint32_t emitter, const V3f& point, const V3f& normal) const {
  uint32_t place = places_.empty() ? kNowhere : places_[emitter];
  if (place == kNowhere) return 0.0f;
  float result = 1.0f;
  for (;;) {
    const uint32_t number = place / kWidth;
    const LightNode& node = nodes_[number];
    const Float8 weights = node.importances(point, normal);
    const float sum = running_sums(weights)[7];
    if (!(sum > 0.0f)) return 0.0f;
    result *= weights[place % kWidth] / sum;
    if (number == 0 || !(result > 0.0f)) return result;
    place = node.parent;
  }
}

float LightTree::irradiance(const V3f& point, const V3f& normal) const {
  if (nodes_.empty()) return 0.0f;
  return running_sums(nodes_[0].importances(point, normal))[7] * total_intensity_;
}

} // namespace kindling
