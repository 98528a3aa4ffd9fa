// Parts of Whitted shading that need no sink: ambient light, cached terms, environment, thin walls.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_shader.h"

namespace kindling {
namespace {

Rgb ambient_of(const WhittedSettings& settings, const LightSetView& lights) {
  if (settings.ambient) return *settings.ambient;
  if (settings.environment_light || !lights.has_environment) return Rgb(0.0f);
  return lights.environment.total_radiance * (0.25f * kInvPi);
}

// Returns the number of lights that get feelers. The environment is the last light.
size_t count_lights(const WhittedSettings& settings, const LightSetView& lights, const PerLightSampling& whole) {
  const bool skips_environment = lights.has_environment && !settings.environment_light;
  return whole.count() - (skips_environment ? 1 : 0);
}

} // namespace

WhittedShader::WhittedShader(const IntegratorSettings& settings, const World& world)
    : world_(world), settings_(settings.whitted), environment_visible_(settings.environment_visible),
      background_(settings.background), lights_(world.light_set()),
      light_count_(count_lights(settings_, world.lights, lights_)), ambient_(ambient_of(settings_, world.lights)),
      cache_(world.materials.size()) {}

WhittedTerms WhittedShader::terms_of(const accel::Hit& hit, const SurfacePoint& surface, RayCounters& counters) const {
  if (!settings_.cache) return whitted_terms(surface, ambient_);
  // Layers outside of a medium are missing when seen from within, and anisotropy depends on the
  // mesh's tangents.
  const bool varies = surface.layered &&
                      ((surface.layers.boundary && !surface.layers.entering) || surface.layers.bsdf.anisotropy > 0.0f);
  if (varies || !world_.is_uniform(hit)) {
    ++counters.whitted.cache_bypasses;
    return whitted_terms(surface, ambient_);
  }
  if (const WhittedTerms* const known = cache_.find(surface.material)) {
    ++counters.whitted.cache_hits;
    return *known;
  }
  ++counters.whitted.cache_misses;
  const WhittedTerms terms = whitted_terms(surface, ambient_);
  cache_.store(surface.material, terms);
  return terms;
}

Rgb WhittedShader::escaped(const WhittedNode& node) const {
  if (node.seen && background_) return *background_;
  if (node.seen && !environment_visible_) return Rgb(0.0f);
  return world_.lights.environment_radiance(node.ray.direction);
}

Rgb WhittedShader::through_thin_walls(accel::Ray feeler, RayCounters& counters) const {
  Rgb through(1.0f);
  feeler.flags = kHitThinWalls;
  SurfacePoint surface;
  for (uint32_t thin_wall = 0; thin_wall < kMaxTransparentSurfaces; ++thin_wall) {
    const accel::Hit hit = world_.accelerator().intersect(feeler);
    ++counters.shadow;
    if (!hit.is_hit()) return through;
    world_.surface_at(feeler, hit, surface);
    if (surface.unlit) return Rgb(0.0f);                               // no ray can leave it (WorldView::guard)
    if (!surface.layered || !surface.layers.thin_wall) return through; // the occlusion query has handled this surface
    WhittedNode node;
    node.ray = feeler;
    const WhittedTerms terms;
    const WhittedVertex vertex(world_, node, surface, terms, 0.0f);
    through *= Rgb(1.0f - surface.alpha) + vertex.bsdf().straight_transmittance() * surface.alpha;
    if (is_black(through)) return through;
    feeler.origin = offset_ray_origin(surface, feeler.direction);
    if (feeler.t_max < kInfinity) feeler.t_max = (feeler.t_max - hit.t) * (1.0f - 1e-6f);
    if (!(feeler.t_max > 0.0f)) return through;
  }
  return Rgb(0.0f); // behind too many thin walls
}

} // namespace kindling
