// Light selection, sampling and densities of a LightSet.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set_view.h"

#include "renderer/base/hash.h"
#include "renderer/base/prefetch.h"
#include "renderer/sampling/warp.h"

#include <array>
#include <cassert>

namespace kindling {

namespace {

// At distances above this many longest edges, distance and angle hardly vary over a triangle:
// sampling by area is as good and cheaper.
constexpr float kFarInEdges = 2.0f;

// Directional lights up to this far below the horizon may still be sampled: rounding must not hide
// them.
constexpr float kHorizon = 1e-5f;

template <typename Triangle>
bool sampled_by_solid_angle(const Triangle& t, const V3f& point) {
  const V3f to_centroid = (t.p0 + t.p1 + t.p2) * (1.0f / 3.0f) - point;
  const float longest2 = std::max((t.p1 - t.p0).length2(), std::max((t.p2 - t.p1).length2(), (t.p0 - t.p2).length2()));
  return to_centroid.length2() < square(kFarInEdges) * longest2;
}

// Returns the solid-angle density of a point that is uniform by area.
float area_density(const V3f& double_area_normal, const V3f& wi, float distance) {
  const float projected = 0.5f * std::fabs(double_area_normal.dot(wi));
  return projected > 0.0f ? square(distance) / projected : 0.0f;
}

float first_coordinate(double rest) { return std::min(static_cast<float>(rest), kOneMinusEpsilon); }

} // namespace

float LightSetView::directional_irradiance(const Punctual& light, const V3f& normal) {
  const bool any_side = normal == V3f(0.0f);
  float cosine = -normal.dot(light.axis);
  // A disk cut by the horizon, or a light that moves.
  if (light.sin_reach > 0.0f) cosine = std::max(cosine, 0.5f * (cosine + light.sin_reach));
  return light.luminance * (any_side ? 1.0f : std::max(cosine + kHorizon, 0.0f));
}

// Without a directional light above the horizon, or without an environment, their weight goes to
// the others. Among directional lights the weights are those of light_selection_weight() relative
// to the strongest of them.
void LightSetView::set_learned_weights(const V3f& normal, const LightProbabilities& learned,
                                       SelectionWeights& weights) const {
  weights.tree = tree.empty() ? 0.0f : learned[static_cast<size_t>(LightKind::tree)];
  weights.environment = environment_irradiance > 0.0f ? learned[static_cast<size_t>(LightKind::environment)] : 0.0f;
  weights.sum = weights.tree + weights.environment;
  for (size_t i = first_directional; i < punctuals.size(); ++i)
    weights.strongest = std::max(weights.strongest, directional_irradiance(punctuals[i], normal));
  if (!(weights.strongest > 0.0f)) return;
  float directional = 0.0f;
  for (size_t i = first_directional; i < punctuals.size(); ++i)
    directional += light_selection_weight(directional_irradiance(punctuals[i], normal), weights.strongest);
  weights.directional_scale = learned[static_cast<size_t>(LightKind::directional)] / directional;
  weights.sum += learned[static_cast<size_t>(LightKind::directional)];
}

LightSetView::SelectionWeights LightSetView::selection_weights(const V3f& point, const V3f& normal,
                                                               const LightProbabilities* learned) const {
  if (learned) {
    SelectionWeights result;
    set_learned_weights(normal, *learned, result);
    return result;
  }
  const float from_tree = tree.irradiance(point, normal);
  SelectionWeights result;
  result.strongest = std::max(from_tree, environment_irradiance);
  for (size_t i = first_directional; i < punctuals.size(); ++i) {
    result.strongest = std::max(result.strongest, directional_irradiance(punctuals[i], normal));
  }
  result.tree = light_selection_weight(from_tree, result.strongest);
  result.environment = light_selection_weight(environment_irradiance, result.strongest);
  result.sum = result.tree;
  for (size_t i = first_directional; i < punctuals.size(); ++i) {
    result.sum += light_selection_weight(directional_irradiance(punctuals[i], normal), result.strongest);
  }
  result.sum += result.environment;
  return result;
}

float LightSetView::environment_probability(const V3f& point, const V3f& normal,
                                            const LightProbabilities* learned) const {
  if (single_kind) return has_environment ? 1.0f : 0.0f;
  const SelectionWeights all = selection_weights(point, normal, learned);
  return all.sum > 0.0f ? all.environment / all.sum : 0.0f;
}

float LightSetView::tree_probability(const V3f& point, const V3f& normal, const LightProbabilities* learned) const {
  if (single_kind) return tree.empty() ? 0.0f : 1.0f;
  const SelectionWeights all = selection_weights(point, normal, learned);
  return all.sum > 0.0f ? all.tree / all.sum : 0.0f;
}

std::optional<LightSetView::Choice> LightSetView::choose_kind(const LightQuery& query) const {
  assert(query.u.x >= 0.0f && query.u.x <= 1.0f && query.u.y >= 0.0f && query.u.y <= 1.0f);
  if (empty()) return std::nullopt;
  Choice result;
  result.rest = static_cast<double>(query.u.x);
  if (single_kind && has_environment) {
    result.kind = LightKind::environment;
    return result;
  }
  if (single_kind && tree.by_intensity) return result;
  // A draw is a multiple of 2^-24. Digits below that give improbable lights their exact
  // probability.
  const auto digits = hash_combine(std::bit_cast<uint32_t>(query.digits), std::bit_cast<uint32_t>(query.u.y));
  result.rest += static_cast<double>(static_cast<uint32_t>(digits)) * 0x1p-56;
  if (single_kind) return result;
  // The order is: tree, directional lights, environment.
  const SelectionWeights all = selection_weights(query.point, query.normal, query.learned);
  result.rest *= static_cast<double>(all.sum);
  const auto chooses = [&](float weight) {
    if (result.rest < static_cast<double>(weight)) {
      result.rest /= static_cast<double>(weight);
      result.probability = weight / all.sum;
      return true;
    }
    result.rest -= static_cast<double>(weight);
    return false;
  };
  if (chooses(all.tree)) return result;
  for (size_t i = first_directional; i < punctuals.size(); ++i) {
    if (!chooses(light_selection_weight(directional_irradiance(punctuals[i], query.normal), all.strongest) *
                 all.directional_scale))
      continue;
    result.kind = LightKind::directional;
    result.directional = static_cast<uint32_t>(i);
    return result;
  }
  if (!(all.environment > 0.0f)) return std::nullopt;
  result.kind = LightKind::environment;
  result.rest /= static_cast<double>(all.environment);
  result.probability = all.environment / all.sum;
  return result;
}

std::optional<LightSample> LightSetView::sample_chosen(const LightQuery& query, const Choice& choice,
                                                       const std::optional<LightTree::Choice>& emitter) const {
  std::optional<LightSample> result;
  switch (choice.kind) {
  case LightKind::tree:
    if (!emitter) return std::nullopt;
    result = emitter->emitter < triangles.size()
                 ? sample_triangle(emitter->emitter, query.point, {first_coordinate(emitter->u), query.u.y}, query.time)
                 : sample_punctual(emitter->emitter - static_cast<uint32_t>(triangles.size()), query.point,
                                   {first_coordinate(emitter->u), query.u.y}, query.time);
    if (!result) return std::nullopt;
    result->pdf *= emitter->probability;
    result->emitter = emitter->emitter;
    break;
  case LightKind::directional:
    result = sample_punctual(choice.directional, query.point, {first_coordinate(choice.rest), query.u.y}, query.time);
    result->emitter = static_cast<uint32_t>(triangles.size()) + choice.directional;
    break;
  case LightKind::environment: result = environment.sample({first_coordinate(choice.rest), query.u.y}); break;
  }
  result->kind = choice.kind;
  result->kind_probability = choice.probability;
  result->pdf *= choice.probability;
  if (!(result->pdf > 0.0f && result->pdf < kInfinity)) return std::nullopt;
  return result;
}

std::optional<LightSample> LightSetView::sample(const LightQuery& query) const {
  const std::optional<Choice> choice = choose_kind(query);
  if (!choice) return std::nullopt;
  return sample_chosen(query, *choice,
                       choice->kind == LightKind::tree ? tree.choose(query.point, query.normal, choice->rest)
                                                       : std::nullopt);
}

// Works in steps over all queries of a group; each step prefetches the memory of the next one.
void LightSetView::sample(std::span<const LightQuery> queries, std::span<std::optional<LightSample>> samples) const {
  assert(samples.size() >= queries.size());
  constexpr size_t kGroup = 32;
  std::array<std::optional<Choice>, kGroup> choices;
  std::array<V2f, kGroup> draws;                                 // for the environment
  std::array<LightTree::Query, kGroup> descents;                 // through the tree
  std::array<std::optional<LightTree::Choice>, kGroup> emitters; // results of the descents
  for (size_t first = 0; first < queries.size(); first += kGroup) {
    const std::span<const LightQuery> group = queries.subspan(first, std::min(kGroup, queries.size() - first));
    size_t draw_count = 0, descent_count = 0;
    for (size_t i = 0; i < group.size(); ++i) {
      choices[i] = choose_kind(group[i]);
      if (!choices[i]) continue;
      if (choices[i]->kind == LightKind::environment)
        draws[draw_count++] = {first_coordinate(choices[i]->rest), group[i].u.y};
      else if (choices[i]->kind == LightKind::tree)
        descents[descent_count++] = {group[i].point, group[i].normal, choices[i]->rest};
    }
    if (draw_count > 0) environment.prefetch_samples(std::span(draws).first(draw_count));
    tree.choose(std::span(descents).first(descent_count), emitters);
    for (size_t i = 0; i < descent_count; ++i)
      if (emitters[i] && emitters[i]->emitter < triangles.size()) prefetch(&triangles[emitters[i]->emitter]);
    size_t descent = 0;
    for (size_t i = 0; i < group.size(); ++i) {
      std::optional<LightSample>& sample = samples[first + i];
      sample.reset();
      if (!choices[i]) continue;
      const bool in_tree = choices[i]->kind == LightKind::tree;
      sample = sample_chosen(group[i], *choices[i], in_tree ? emitters[descent++] : std::nullopt);
    }
  }
}

std::optional<LightSample> LightSetView::sample_triangle(uint32_t index, const V3f& point, const V2f& u,
                                                         float time) const {
  Triangle posed;
  if (moves(index)) [[unlikely]]
    posed = posed_triangle(index, time);
  const Triangle& t = moves(index) ? posed : triangles[index];
  const V3f normal = double_area_normal(t);
  const bool front = normal.dot(point - t.p0) > 0.0f;
  if (!front && !emissions[t.emission].two_sided) return std::nullopt;

  LightSample result;
  V2f barycentrics;
  if (sampled_by_solid_angle(t, point)) {
    const SphericalTriangle seen(t.p0, t.p1, t.p2, point);
    result.pdf = seen.pdf();
    if (!(result.pdf > 0.0f)) return std::nullopt;
    const SphericalTriangle::Sample sample = seen.sample(u);
    barycentrics = sample.barycentrics;
    const V3f on_light =
        t.p0 * (1.0f - barycentrics.x - barycentrics.y) + t.p1 * barycentrics.x + t.p2 * barycentrics.y;
    result.wi = sample.direction;
    result.distance = std::sqrt((on_light - point).length2());
  } else {
    barycentrics = sample_uniform_triangle(u);
    const V3f on_light =
        t.p0 * (1.0f - barycentrics.x - barycentrics.y) + t.p1 * barycentrics.x + t.p2 * barycentrics.y;
    const V3f to_light = on_light - point;
    result.distance = std::sqrt(to_light.length2());
    result.wi = to_light * (1.0f / result.distance);
    result.pdf = area_density(normal, result.wi, result.distance);
  }
  if (!(result.pdf > 0.0f && result.pdf < kInfinity)) return std::nullopt;
  result.radiance = emission_at(index, barycentrics.x, barycentrics.y);
  result.normal = normal * ((front ? 1.0f : -1.0f) / normal.length());
  result.radiance *= through_coat(emissions[t.emission], front, result.normal.dot(result.wi));
  return result;
}

float LightSetView::pdf_triangle(uint32_t triangle, const V3f& point, const V3f& normal, const V3f& wi, float distance,
                                 const LightProbabilities* learned, float time) const {
  assert(triangle < triangles.size());
  assert(std::fabs(wi.length2() - 1.0f) < 1e-3f);
  Triangle posed;
  if (moves(triangle)) [[unlikely]]
    posed = posed_triangle(triangle, time);
  const Triangle& t = moves(triangle) ? posed : triangles[triangle];
  float probability = tree.probability(triangle, point, normal);
  if (!(probability > 0.0f)) return 0.0f;
  probability *= tree_probability(point, normal, learned);
  const float density = sampled_by_solid_angle(t, point) ? SphericalTriangle(t.p0, t.p1, t.p2, point).pdf()
                                                         : area_density(double_area_normal(t), wi, distance);
  return density * probability < kInfinity ? density * probability : 0.0f;
}

Rgb LightSetView::emission_at(uint32_t index, float u, float v) const {
  const Emission& emission = emissions[triangles[index].emission];
  if (emission.texture == nullptr || uvs.empty()) return emission.factor;
  const V2f* uv = uvs.data() + size_t{index} * 3;
  return emission.factor * emission.texture->sample_rgb(uv[0] * (1.0f - u - v) + uv[1] * u + uv[2] * v);
}

Rgb LightSetView::emitted(uint32_t triangle, float u, float v, const V3f& wi, float time) const {
  assert(triangle < triangles.size());
  const Triangle t = moves(triangle) ? posed_triangle(triangle, time) : triangles[triangle];
  const Emission& emission = emissions[t.emission];
  const V3f normal = double_area_normal(t);
  const bool front = normal.dot(wi) < 0.0f;
  if (!emission.two_sided && !front) return Rgb(0.0f);
  return emission_at(triangle, u, v) * through_coat(emission, front, normal.dot(wi) / normal.length());
}

} // namespace kindling
