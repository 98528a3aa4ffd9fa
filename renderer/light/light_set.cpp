// Light selection, sampling and densities of a LightSet.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set_view.h"

#include "renderer/base/hash.h"
#include "renderer/base/prefetch.h"
#include <array>
#include <cassert>

namespace kindling {

namespace {

// Directional lights up to this far below the horizon may still be sampled: rounding must not hide
// them.
constexpr float kHorizon = 1e-5f;

// Returns the unit normal on a side of a triangle, given its double_area_normal().
template <typename Real, typename Condition>
Imath::Vec3<Real> normal_on_side(const Imath::Vec3<Real>& normal, const Condition& front) {
  return normal * (select(front, Real(1.0f), Real(-1.0f)) / length_of(normal));
}

// True if both queries have the same selection weights.
bool same_weights(const LightQuery& a, const LightQuery& b) {
  return a.point == b.point && a.normal == b.normal && a.learned == b.learned;
}

constexpr size_t kGroup = 32; // queries that are sampled in steps

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

float LightSetView::unlearned_kind_probability(const V3f& point, const V3f& normal, const LightSample& sample) const {
  if (single_kind) return 1.0f;
  const SelectionWeights all = selection_weights(point, normal, nullptr);
  if (!(all.sum > 0.0f)) return 0.0f;
  if (sample.kind == LightKind::tree) return all.tree / all.sum;
  if (sample.kind == LightKind::environment) return all.environment / all.sum;
  const Punctual& light = punctuals[sample.emitter - triangles.size()];
  return light_selection_weight(directional_irradiance(light, normal), all.strongest) / all.sum;
}

void LightSetView::choose_kind(const LightQuery& query, const SelectionWeights& weights,
                               std::optional<Choice>& choice) const {
  assert(query.u.x >= 0.0f && query.u.x <= 1.0f && query.u.y >= 0.0f && query.u.y <= 1.0f);
  choice.reset();
  if (empty()) return;
  Choice& result = choice.emplace();
  result.rest = static_cast<double>(query.u.x);
  if (single_kind && has_environment) {
    result.kind = LightKind::environment;
    return;
  }
  if (single_kind && tree.by_intensity) return;
  // A draw is a multiple of 2^-24. Digits below that give improbable lights their exact
  // probability.
  const auto digits = hash_combine(std::bit_cast<uint32_t>(query.digits), std::bit_cast<uint32_t>(query.u.y));
  result.rest += static_cast<double>(static_cast<uint32_t>(digits)) * 0x1p-56;
  if (single_kind) return;
  // The order is: tree, directional lights, environment.
  result.rest *= static_cast<double>(weights.sum);
  const auto chooses = [&](float weight) {
    if (result.rest < static_cast<double>(weight)) {
      result.rest /= static_cast<double>(weight);
      result.probability = weight / weights.sum;
      return true;
    }
    result.rest -= static_cast<double>(weight);
    return false;
  };
  if (chooses(weights.tree)) return;
  for (size_t i = first_directional; i < punctuals.size(); ++i) {
    if (!chooses(light_selection_weight(directional_irradiance(punctuals[i], query.normal), weights.strongest) *
                 weights.directional_scale))
      continue;
    result.kind = LightKind::directional;
    result.directional = static_cast<uint32_t>(i);
    return;
  }
  if (!(weights.environment > 0.0f)) {
    choice.reset();
    return;
  }
  result.kind = LightKind::environment;
  result.rest /= static_cast<double>(weights.environment);
  result.probability = weights.environment / weights.sum;
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
  case LightKind::environment: {
    const V2f u(first_coordinate(choice.rest), query.u.y);
    if (query.presampled != nullptr)
      query.presampled->set_sample(u, result.emplace());
    else
      result = environment.sample(u);
    break;
  }
  }
  if (!complete(choice, *result)) return std::nullopt;
  return result;
}

bool LightSetView::complete(const Choice& choice, LightSample& sample) {
  sample.kind = choice.kind;
  sample.kind_probability = choice.probability;
  sample.pdf *= choice.probability;
  return sample.pdf > 0.0f && sample.pdf < kInfinity;
}

std::optional<LightSample> LightSetView::sample(const LightQuery& query) const {
  std::optional<Choice> choice;
  choose_kind(query, single_kind ? SelectionWeights{} : selection_weights(query.point, query.normal, query.learned),
              choice);
  if (!choice) return std::nullopt;
  return sample_chosen(query, *choice,
                       choice->kind == LightKind::tree ? tree.choose(query.point, query.normal, choice->rest)
                                                       : std::nullopt);
}

// The steps of sample() where nothing is to be chosen.
void LightSetView::sample_tables(std::span<const LightQuery> queries,
                                 std::span<std::optional<LightSample>> samples) const {
  const auto place = [](const LightQuery& query) { return V2f(std::min(query.u.x, kOneMinusEpsilon), query.u.y); };
  for (const LightQuery& query : queries) query.presampled->prefetch(place(query));
  for (size_t i = 0; i < queries.size(); ++i) {
    LightSample& sample = samples[i].emplace();
    queries[i].presampled->set_sample(place(queries[i]), sample);
    if (!complete({.kind = LightKind::environment}, sample)) samples[i].reset();
  }
}

// Works in steps over all queries; each step prefetches the memory of the next one.
void LightSetView::sample_group(std::span<const LightQuery> group,
                                std::span<std::optional<LightSample>> samples) const {
  assert(group.size() <= kGroup);
  std::array<std::optional<Choice>, kGroup> choices;
  std::array<V2f, kGroup> draws;                                 // for the environment
  std::array<EnvironmentView::Cell, kGroup> cells;               // of these draws
  std::array<LightSample*, kGroup> on_sky;                       // their samples
  std::array<LightTree::Query, kGroup> descents;                 // through the tree
  std::array<std::optional<LightTree::Choice>, kGroup> emitters; // results of the descents
  std::array<ChosenTriangle, kGroup> on_triangles;
  const std::optional<LightTree::Choice> no_emitter;
  const auto draws_sky = [&](size_t i) {
    return choices[i] && choices[i]->kind == LightKind::environment && group[i].presampled == nullptr;
  };
  size_t draw_count = 0, descent_count = 0;
  SelectionWeights weights; // of all queries at one point
  for (size_t i = 0; i < group.size(); ++i) {
    if (!single_kind && (i == 0 || !same_weights(group[i - 1], group[i])))
      weights = selection_weights(group[i].point, group[i].normal, group[i].learned);
    choose_kind(group[i], weights, choices[i]);
    if (!choices[i]) continue;
    const V2f u(first_coordinate(choices[i]->rest), group[i].u.y); // on the environment
    if (draws_sky(i))
      draws[draw_count++] = u;
    else if (choices[i]->kind == LightKind::environment)
      group[i].presampled->prefetch(u);
    else if (choices[i]->kind == LightKind::tree)
      descents[descent_count++] = {group[i].point, group[i].normal, choices[i]->rest};
  }
  environment.find_cells(std::span(draws).first(draw_count), std::span(cells).first(draw_count));
  tree.choose(std::span(descents).first(descent_count), emitters);
  for (size_t i = 0; i < descent_count; ++i)
    if (emitters[i] && emitters[i]->emitter < triangles.size()) prefetch(&triangles[emitters[i]->emitter]);
  size_t descent = 0, triangle_count = 0, sky_count = 0;
  for (size_t i = 0; i < group.size(); ++i) {
    std::optional<LightSample>& sample = samples[i];
    sample.reset();
    if (!choices[i]) continue;
    if (draws_sky(i)) {
      on_sky[sky_count++] = &sample.emplace();
      continue;
    }
    if (choices[i]->kind == LightKind::environment) { // a copy of the result of sample_chosen() would take longer
      group[i].presampled->set_sample({first_coordinate(choices[i]->rest), group[i].u.y}, sample.emplace());
      if (!complete(*choices[i], *sample)) sample.reset();
      continue;
    }
    const bool in_tree = choices[i]->kind == LightKind::tree;
    const std::optional<LightTree::Choice>& emitter = in_tree ? emitters[descent++] : no_emitter;
    if (emitter && emitter->emitter < std::min(triangles.size(), size_t{first_moving}))
      on_triangles[triangle_count++] = {static_cast<uint32_t>(i), &*emitter};
    else
      sample = sample_chosen(group[i], *choices[i], emitter);
  }
  for (size_t i = 0; i < triangle_count; i += Lanes::kCount)
    sample_triangles(std::span(on_triangles).subspan(i, std::min(Lanes::kCount, triangle_count - i)), group, choices,
                     samples);
  environment.sample_cells(std::span(draws).first(sky_count), std::span(cells).first(sky_count),
                           std::span(on_sky).first(sky_count));
  for (size_t i = 0; i < group.size() && sky_count > 0; ++i) {
    if (!draws_sky(i)) continue;
    if (!complete(*choices[i], *samples[i])) samples[i].reset();
  }
}

void LightSetView::sample(std::span<const LightQuery> queries, std::span<std::optional<LightSample>> samples) const {
  assert(samples.size() >= queries.size());
  const bool sky_alone = single_kind && has_environment;
  for (size_t first = 0; first < queries.size(); first += kGroup) {
    const std::span<const LightQuery> group = queries.subspan(first, std::min(kGroup, queries.size() - first));
    const auto has_table = [](const LightQuery& query) { return query.presampled != nullptr; };
    if (sky_alone && std::all_of(group.begin(), group.end(), has_table))
      sample_tables(group, samples.subspan(first));
    else
      sample_group(group, samples.subspan(first));
  }
}

Rgb LightSetView::emission_at(uint32_t index, float u, float v) const {
  const Emission& emission = emissions[triangles[index].emission];
  if (emission.texture == nullptr || uvs.empty()) return emission.factor;
  const V2f* uv = uvs.data() + size_t{index} * 3;
  return emission.factor * emission.texture->sample_rgb(uv[0] * (1.0f - u - v) + uv[1] * u + uv[2] * v);
}

[[gnu::always_inline]] inline bool LightSetView::set_point(uint32_t index, const PointOnTriangle<float>& point,
                                                           bool front, const V3f& normal, LightSample& sample) const {
  const Emission& emission = emissions[triangles[index].emission];
  if (!front && !emission.two_sided) return false;
  if (!(point.pdf > 0.0f && point.pdf < kInfinity)) return false;
  sample.wi = point.wi;
  sample.distance = point.distance;
  sample.pdf = point.pdf;
  sample.radiance = emission_at(index, point.barycentrics.x, point.barycentrics.y);
  sample.normal = normal;
  sample.radiance *= through_coat(emission, front, normal.dot(point.wi));
  return true;
}

// Lanes without a query repeat the last one.
void LightSetView::sample_triangles(std::span<const ChosenTriangle> chosen, std::span<const LightQuery> queries,
                                    std::span<const std::optional<Choice>> choices,
                                    std::span<std::optional<LightSample>> samples) const {
  assert(!chosen.empty() && chosen.size() <= Lanes::kCount);
  LaneVectors p0, p1, p2, points;
  LaneNumbers u_x, u_y;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    const ChosenTriangle& at = chosen[std::min(lane, chosen.size() - 1)];
    const Triangle& t = triangles[at.emitter->emitter];
    p0.set(lane, t.p0), p1.set(lane, t.p1), p2.set(lane, t.p2);
    points.set(lane, queries[at.query].point);
    u_x[lane] = first_coordinate(at.emitter->u);
    u_y[lane] = queries[at.query].u.y;
  }
  const TriangleLanes t{p0.load(), p1.load(), p2.load()};
  const Imath::Vec3<Lanes> point = points.load();
  const Imath::Vec3<Lanes> normal = double_area_normal(t);
  const LaneMask front = normal.dot(point - t.p0) > 0.0f;
  const PointOnTriangle<Lanes> sampled = sample_point(t, normal, point, {u_x.load(), u_y.load()});

  LaneVectors unit_normals;
  unit_normals.store(normal_on_side(normal, front));
  Lanes columns[Lanes::kCount] = {sampled.wi.x, sampled.wi.y,           sampled.wi.z,           sampled.distance,
                                  sampled.pdf,  sampled.barycentrics.x, sampled.barycentrics.y, 0.0f};
  LaneRows rows;
  rows.store_columns(columns);
  for (size_t lane = 0; lane < chosen.size(); ++lane) {
    const ChosenTriangle& at = chosen[lane];
    const float* const row = rows[lane];
    LightSample& sample = samples[at.query].emplace();
    const bool seen = set_point(at.emitter->emitter, {{row[0], row[1], row[2]}, row[3], row[4], {row[5], row[6]}},
                                front[lane] != 0, unit_normals[lane], sample);
    sample.pdf *= at.emitter->probability;
    sample.emitter = at.emitter->emitter;
    if (!seen || !complete(*choices[at.query], sample)) samples[at.query].reset();
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
  if (!set_point(index, sample_point(t, normal, point, u), front, normal_on_side(normal, front), result))
    return std::nullopt;
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
