// Loads eight structs at a time into lanes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/lanes/gathered_vertices.h"

#include "renderer/integrator/lanes/load_structs.h"

#include <cassert>

namespace kindling {
namespace {

// The light sample of vertices that have none.
const LightSample kNoLight{.wi = V3f(0.0f, 0.0f, 1.0f), .distance = kInfinity, .pdf = 1.0f};

} // namespace

GatheredVertices::GatheredVertices(const VertexQueue& queue, const PathStages& stages, PathContext& context)
    : count(queue.count), special(0) {
  assert(count > 0);
  for (uint32_t i = 0; i < Lanes::kCount; ++i) {
    const uint32_t from = std::min(i, count - 1);
    numbers[i] = queue.numbers[from], members[i] = queue.members[from];
    rays[i] = &context.rays[numbers[i]];
    states[i] = &context.states[context.active[numbers[i]]];
    const SurfacePoint& surface = members[i]->surface;
    special |= states[i]->in_medium || surface.guarded || surface.alpha < 1.0f ? 1U << i : 0U;
    has_roulette[i] = states[i]->roulette_bounces() >= stages.settings.roulette_start_bounce ? -1 : 0;
  }
  constexpr size_t kSurface = offsetof(ShadeGroup::Member, surface);
  constexpr size_t kDraws = offsetof(ShadeGroup::Member, sampled) + offsetof(SurfaceDraws, draws);
  const auto place = columns_at(members, kSurface + offsetof(SurfacePoint, position));
  static_assert(offsetof(SurfacePoint, position_error) == offsetof(SurfacePoint, position) + 3 * sizeof(float));
  const auto geometric = columns_at(members, kSurface + offsetof(SurfacePoint, geometric_normal));
  const auto shading = columns_at(members, kSurface + offsetof(SurfacePoint, shading_normal));
  const auto first_draws = columns_at(members, kDraws + offsetof(BounceDraws, choice));
  static_assert(offsetof(BounceDraws, direction) == offsetof(BounceDraws, choice) + 2 * sizeof(float));
  const auto more_draws = columns_at(members, kDraws + offsetof(BounceDraws, light));
  static_assert(offsetof(BounceDraws, roulette) == offsetof(BounceDraws, light) + 2 * sizeof(float));
  const auto ray = columns_at(rays, offsetof(accel::Ray, direction));
  const auto arriving = columns_at(states, offsetof(PathState, throughput));
  const auto cone = columns_at(states, offsetof(PathState, cone));
  static_assert(offsetof(PathState, guiding) == offsetof(PathState, cone) + 2 * sizeof(float));

  position = vector_of(place);
  position_error = place[3];
  normal = vector_of(geometric);
  frame = FrameOf<Lanes>::around(vector_of(shading));
  parameters = bsdf_parameters_at(members, kSurface + offsetof(SurfacePoint, bsdf));
  wo_world = -vector_of(ray);
  wo = frame.to_local(wo_world);
  throughput = vector_of(arriving);
  spread = cone[1], guiding = cone[2];
  choice = first_draws[1];
  direction_draws = {first_draws[2], first_draws[3]};
  roulette = more_draws[2];
}

void GatheredVertices::turn_to_tangents() {
  constexpr size_t kLayers = offsetof(ShadeGroup::Member, surface) + offsetof(SurfacePoint, layers);
  const auto tangent = columns_at(members, kLayers + offsetof(SurfaceLayers, tangent));
  frame = FrameOf<Lanes>::with_tangent(frame.normal, vector_of(tangent));
  wo = frame.to_local(wo_world);
}

LayerParametersOf<Lanes> GatheredVertices::layers() const {
  constexpr size_t kLayers =
      offsetof(ShadeGroup::Member, surface) + offsetof(SurfacePoint, layers) + offsetof(SurfaceLayers, bsdf);
  const auto coat = columns_at(members, kLayers + offsetof(LayerParameters, clearcoat));
  static_assert(offsetof(LayerParameters, clearcoat_roughness) == offsetof(LayerParameters, clearcoat) + sizeof(float));
  const auto coat_normal = columns_at(members, kLayers + offsetof(LayerParameters, clearcoat_normal));
  const auto sheen = columns_at(members, kLayers + offsetof(LayerParameters, sheen_color));
  static_assert(offsetof(LayerParameters, sheen_roughness) ==
                offsetof(LayerParameters, sheen_color) + 3 * sizeof(float));
  LayerParametersOf<Lanes> layers;
  layers.clearcoat = coat[0], layers.clearcoat_roughness = coat[1];
  layers.clearcoat_normal = vector_of(coat_normal);
  layers.sheen_color = vector_of(sheen), layers.sheen_roughness = sheen[3];
  layers.anisotropy = columns_at(members, kLayers + offsetof(LayerParameters, anisotropy))[0];
  return layers;
}

GatheredLights::GatheredLights(const GatheredVertices& vertices, const ShadeGroup& group, uint32_t number) {
  std::array<const LightSample*, Lanes::kCount> lights;
  for (uint32_t i = 0; i < Lanes::kCount; ++i) {
    const ShadeGroup::Member& member = *vertices.members[i];
    const std::optional<LightSample>* const light =
        number < member.light_count ? &group.lights[member.first_light + number] : nullptr;
    const bool is_there = light && *light;
    lights[i] = is_there ? &**light : &kNoLight;
    there |= is_there ? 1U << i : 0U;
    is_delta[i] = lights[i]->delta ? -1 : 0;
    is_environment[i] = lights[i]->kind == LightKind::environment ? -1 : 0;
  }
  const auto place = columns_at(lights, offsetof(LightSample, wi));
  static_assert(offsetof(LightSample, distance) == offsetof(LightSample, wi) + 3 * sizeof(float));
  const auto light = columns_at(lights, offsetof(LightSample, radiance));
  static_assert(offsetof(LightSample, pdf) == offsetof(LightSample, radiance) + 3 * sizeof(float));
  wi = vector_of(place), distance = place[3];
  radiance = vector_of(light), pdf = light[3];
  normal = vector_of(columns_at(lights, offsetof(LightSample, normal)));
}

} // namespace kindling
