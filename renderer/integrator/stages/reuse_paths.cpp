// Links between the paths of several pixels, and the light that they bring.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/reuse_paths.h"

#include <array>
#include <cassert>
#include <cmath>
#include <span>

namespace kindling {
namespace {

ReusedSurface record_of(const SurfacePoint& surface) {
  return {surface.position, offset_ray_origin(surface, surface.geometric_normal), surface.geometric_normal,
          surface.shading_normal, surface.bsdf};
}

WayOf<float> way_between(const ReusedSurface& first, const ReusedSurface& second) {
  return kindling::way_between(first.position, second.position, second.geometric_normal);
}

// The BSDF of a second surface as it reflects light from one direction towards several others. It
// is reciprocal, so one set-up serves them all.
class LightFrom {
 public:
  LightFrom(const ReusedSurface& surface, const Frame& frame, const V3f& wi)
      : frame_(frame), bsdf_(surface.bsdf, frame.to_local(wi)), cosine_(wi.dot(frame.normal)) {}

  // f times the cosine of the light: all of it, and the part that is shared.
  struct Values {
    std::array<Rgb, kEvalsTogether> all, shared;
  };
  void towards(const EvalDirections& wo, Values& values) const {
    const EvalDirections local = to_local(frame_, wo);
    BsdfEvals evals;
    bsdf_.eval(local, evals);
    const bool narrow = bsdf_.alpha() > 0.0f && bsdf_.alpha() < kMinSharedAlpha;
    for (size_t i = 0; i < wo.size(); ++i) {
      const float scale = local[i].z > 0.0f ? cosine_ / local[i].z : 0.0f;
      values.all[i] = evals.value(i) * scale;
      values.shared[i] = narrow ? bsdf_.diffuse_value(local[i]) * scale : values.all[i];
    }
  }

 private:
  const Frame& frame_;
  GltfBsdf bsdf_;
  float cosine_;
};

} // namespace

V3f direction_between(const ReusedSurface& first, const ReusedSurface& second) {
  return way_between(first, second).direction;
}

void ReusedPath::note(const SurfacePoint& surface, const V3f& wo_world, const PathState& state) {
  if (state.bounce == 0) {
    first = record_of(surface);
    receives = true;
    wo = wo_world;
    throughput = state.throughput;
  } else {
    second = record_of(surface);
    gives = true;
    light = tail = own_of_light = own_of_tail = Rgb(0.0f);
  }
}

// Until here light[kIndirect] has had nothing but the tail: what the second surface emits, and
// light samples at the first one, are direct light.
void ReuseView::start_sharing(uint32_t slot, PathState& state) const {
  ReusedPath& path = paths[slot];
  if (!path.gives) return;
  path.tail = state.light[kIndirect];
  state.light[kIndirect] = Rgb(0.0f);
}

uint32_t ReuseView::link_paths(const PathStages& stages, uint32_t slot, const ReuseGroup& group) const {
  for (uint32_t place = 0; place < count; ++place) link(slot, place) = {};
  const ReusedPath& receiver = paths[slot];
  if (!receiver.receives) return 0;
  uint32_t givers = 0;
  for (uint32_t place = 0; place < count; ++place)
    if (group[place] != kNoPath && paths[group[place]].has_light()) givers |= 1U << place;
  if ((givers & 1U) != 0) {
    const WayOf<float> way = way_between(receiver.first, receiver.second);
    const float ratio = std::abs(way.solid_angle_per_area);
    link(slot, 0) = {receiver.value * ratio, receiver.pdf * ratio, way.direction};
  }
  if (givers <= 1) return 0;
  const Frame frame = Frame::around(receiver.first.shading_normal);
  GuidedBsdf bsdf(receiver.first.bsdf, nullptr, frame, receiver.wo);
  stages.guide(bsdf, receiver.first.position);
  uint32_t traced = 0;
  std::array<uint32_t, kEvalsTogether> places;
  std::array<float, kEvalsTogether> ratios;
  EvalDirections directions;
  const auto set_links = [&] {
    BsdfEvals evals;
    bsdf.eval(directions, evals);
    for (size_t i = 0; i < directions.size(); ++i) {
      const Rgb value = evals.value(i);
      if (is_black(value) || !(evals.pdfs[i] > 0.0f)) continue;
      link(slot, places[i]) = {value * ratios[i], evals.pdfs[i] * ratios[i], directions[i]};
      traced |= 1U << places[i];
    }
    directions.clear();
  };
  for (uint32_t place = 1; place < count; ++place) {
    if ((givers >> place & 1U) == 0) continue;
    const ReusedSurface& second = paths[group[place]].second;
    const WayOf<float> way = way_between(receiver.first, second);
    if (!(way.solid_angle_per_area > 0.0f) || !(way.direction.dot(receiver.first.geometric_normal) > 0.0f)) continue;
    if (!((second.origin - receiver.first.origin).length2() > 0.0f)) continue;
    places[directions.size()] = place, ratios[directions.size()] = way.solid_angle_per_area;
    directions.add(way.direction);
    if (directions.size() == kEvalsTogether) set_links();
  }
  if (directions.size() > 0) set_links();
  return traced;
}

accel::Ray ReuseView::link_ray(uint32_t slot, const ReuseGroup& group, uint32_t place,
                               const CameraSample& sample) const {
  const V3f& origin = paths[slot].first.origin;
  const V3f to_second = paths[group[place]].second.origin - origin;
  const float distance = to_second.length();
  return {.origin = origin,
          .t_min = 0.0f,
          .direction = to_second / distance,
          .t_max = distance,
          .key = hash_combine(ray_key(sample, kReuseDimension), place),
          .index = sample.address.index,
          .flags = kHitPartlyTransparent};
}

void ReuseView::share_light(uint32_t slot, const ReuseGroup& group) const {
  ReusedPath& giver = paths[slot];
  if (!giver.has_light()) return;
  float density = 0.0f;
  for (uint32_t place = 0; place < count; ++place)
    if (group[place] != kNoPath) density += link(group[place], place).density;
  if (!(density > 0.0f)) return;
  const Frame frame = Frame::around(giver.second.shading_normal);
  const auto share = [&](const V3f& wi, float scale, Rgb ReuseLink::*received, Rgb& own) {
    const LightFrom from(giver.second, frame, wi);
    std::array<uint32_t, kEvalsTogether> places;
    EvalDirections directions;
    const auto set_factors = [&] {
      LightFrom::Values values;
      from.towards(directions, values);
      for (size_t i = 0; i < directions.size(); ++i) {
        ReuseLink& to = link(group[places[i]], places[i]);
        to.*received = to.value * values.shared[i] * (scale / density);
        if (places[i] == 0)
          own = giver.throughput * giver.value * (values.all[i] - values.shared[i]) * (scale / giver.pdf);
      }
      directions.clear();
    };
    for (uint32_t place = 0; place < count; ++place) {
      if (group[place] == kNoPath) continue;
      const ReuseLink& to = link(group[place], place);
      if (!(to.density > 0.0f)) continue;
      places[directions.size()] = place;
      directions.add(-to.of_light);
      if (directions.size() == kEvalsTogether) set_factors();
    }
    if (directions.size() > 0) set_factors();
  };
  if (!is_black(giver.tail)) share(giver.tail_wi, 1.0f / giver.tail_pdf, &ReuseLink::of_tail, giver.own_of_tail);
  // Last, as it replaces the directions.
  if (!is_black(giver.light)) share(giver.light_wi, 1.0f, &ReuseLink::of_light, giver.own_of_light);
}

void ReuseView::receive(uint32_t slot, const ReuseGroup& group, PathState& state) const {
  const ReusedPath& path = paths[slot];
  if (!path.receives) return;
  Rgb light(0.0f);
  for (uint32_t place = 0; place < count; ++place) {
    const ReuseLink& from = link(slot, place);
    if (!(from.density > 0.0f)) continue;
    const ReusedPath& giver = paths[group[place]];
    light += from.of_light * giver.light + from.of_tail * giver.tail;
  }
  state.light[kIndirect] += path.throughput * light;
  if (path.gives) state.light[kIndirect] += path.own_of_light * path.light + path.own_of_tail * path.tail;
}

} // namespace kindling
