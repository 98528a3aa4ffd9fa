// Parts of Whitted shading that need no sink: ambient light, cached terms, environment, thin walls.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_shader.h"

#include "renderer/bsdf/bsdf_ranges.h"

namespace kindling {
namespace {

Rgb ambient_of(const WhittedSettings& settings, const LightSetView& lights) {
  if (settings.ambient) return *settings.ambient;
  if (settings.environment_light || !lights.has_environment) return Rgb(0.0f);
  return lights.environment.total_radiance * (0.25f * kInvPi);
}

// Returns the number of lights that get feelers. The environment is the last light.
size_t count_lights(const WhittedSettings& settings, const LightSetView& lights, const PerLightView& whole) {
  const bool skips_environment = lights.has_environment && !settings.environment_light;
  return whole.count() - (skips_environment ? 1 : 0);
}

} // namespace

WhittedShader make_whitted_shader(const IntegratorSettings& settings, const WorldView& world, const CameraView& camera,
                                  const Sampler& sampler, const PerLightView& lights) {
  return {.world = &world,
          .camera = &camera,
          .sample_width = sample_width(sampler),
          .settings = settings.whitted,
          .environment_visible = settings.environment_visible,
          .transparent_background = settings.transparent_background,
          .background = settings.background,
          .lights = lights,
          .light_count = count_lights(settings.whitted, world.lights, lights),
          .ambient = ambient_of(settings.whitted, world.lights)};
}

WhittedTerms WhittedShader::terms_of(const accel::Hit& hit, const SurfacePoint& surface,
                                     WhittedCounters& counters) const {
  return cache == nullptr ? whitted_terms(surface, ambient) : cached_terms(hit, surface, counters);
}

void WhittedShader::record_surface(const WhittedVertex& vertex, FilmSurface& record) const {
  const SurfacePoint& point = vertex.surface;
  record.hit = true;
  record.albedo = point.unlit ? point.emitted : vertex.bsdf().albedo();
  record.normal = point.shading_normal;
  record.depth = camera->depth(point.position, vertex.node.ray.time);
  record.position = point.position;
  record.guide_albedo = saturate(record.albedo);
  record.guide_normal = record.normal;
}

Rgb WhittedShader::escaped(const WhittedNode& node) const {
  if (node.seen && background) return *background;
  if (node.seen && !environment_visible) return Rgb(0.0f);
  return world->lights.environment_radiance(node.ray.direction);
}

Rgb WhittedShader::shapes_along(const WhittedNode& node, const accel::Hit& hit) const {
  ShapeRay stretch{.origin = node.ray.origin,
                   .normal = V3f(0.0f),
                   .direction = node.ray.direction,
                   .end_m = hit.is_hit() ? hit.t : kInfinity,
                   .time = node.ray.time};
  if (node.in_medium) stretch.extinction = world->medium(*node.media.innermost()).extinction;
  return world->lights.shape_radiance(stretch);
}

WhittedShader::ThinWall WhittedShader::pass_thin_wall(const accel::Hit& hit, accel::Ray& feeler, Rgb& through) const {
  SurfacePoint surface;
  world->surface_at(feeler, hit, surface);
  if (surface.unlit) return ThinWall::blocks;                               // no ray can leave it (WorldView::guard)
  if (!surface.layered || !surface.layers.thin_wall) return ThinWall::last; // the occlusion query has handled it
  WhittedNode node;
  node.ray = feeler;
  const WhittedTerms terms;
  const WhittedVertex vertex(*world, node, surface, terms, 0.0f);
  through *= Rgb(1.0f - surface.alpha) + vertex.bsdf().straight_transmittance() * surface.alpha;
  if (is_black(through)) return ThinWall::blocks;
  feeler.origin = offset_ray_origin(surface, feeler.direction);
  if (feeler.t_max < kInfinity) feeler.t_max = (feeler.t_max - hit.t) * (1.0f - 1e-6f);
  return feeler.t_max > 0.0f ? ThinWall::passed : ThinWall::last;
}

} // namespace kindling
