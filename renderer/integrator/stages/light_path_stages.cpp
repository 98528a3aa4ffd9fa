// Steps of a light path: its start, its bounces and its joints with the camera.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/light_path_stages.h"

#include "renderer/base/on_gpu.h"
#include "renderer/integrator/stages/camera_sight.h"
#include "renderer/integrator/stages/emitted_path.h"
#include "renderer/integrator/stages/prepare_path.h"
#include "renderer/integrator/stages/random_walk.h"
#include "renderer/integrator/stages/rest_surface.h"
#include "renderer/integrator/stages/seen_surface.h"

#include <algorithm>
#include <cmath>

namespace kindling {

namespace {

// Dimensions of a light path's draws: two for each bounce, and one for a wavelength.
enum LightDimension : uint32_t { kFirstLightBounce = kAfterEmission, kFirstWavelength = 256 };

// Paths are ended at random from this bounce on.
constexpr uint8_t kFirstRoulette = 3;

V2f draw_of(const LightPathState& path, uint32_t dimension) {
  return Sampler::sample_2d(path.key, path.index, dimension);
}

} // namespace

bool LightPathStages::start(uint64_t number, LightPathState& path, accel::Ray& ray) const {
  const uint32_t key = hash_combine(hash_u32(seed ^ 0x11947a9dU), static_cast<uint32_t>(number >> 32));
  const std::optional<EmittedPath> started =
      start_emitted_path(emission, key, static_cast<uint32_t>(number), camera->shutter_open());
  if (!started) return false;
  path = LightPathState{};
  path.emitted = started->emitted;
  path.key = key;
  path.index = static_cast<uint32_t>(number);
  ray = started->ray;
  return true;
}

bool LightPathStages::scatter(const PathStages& paths, const accel::Hit& hit, SurfacePoint& surface, accel::Ray& ray,
                              LightPathState& path, std::optional<LightJoint>& joint) const {
  joint.reset();
  const Arrival arrival = arrive(hit, surface, path);
  if (arrival == Arrival::ends) return false;
  if (arrival == Arrival::passes_straight) return pass_straight(paths, surface, ray, path);
  if (arrival == Arrival::joins && !path.in_medium) join_camera(paths, surface, hit, ray, path, joint);
  return bounce(paths, surface, hit, ray, path);
}

// Gathering decides what a surface reflects of its photons.
bool LightPathStages::scatter_photon(const PathStages& paths, const LightGroupsView& groups, const accel::Hit& hit,
                                     SurfacePoint& surface, accel::Ray& ray, LightPathState& path,
                                     std::optional<Photon>& photon) const {
  photon.reset();
  const Arrival arrival = arrive(hit, surface, path);
  if (arrival == Arrival::ends) return false;
  if (arrival == Arrival::passes_straight) return pass_straight(paths, surface, ray, path);
  if (arrival == Arrival::joins) {
    const float cosine = std::abs(ray.direction.dot(surface.geometric_normal));
    const float eta = path.in_medium ? world->medium(path.material).ior : 1.0f;
    const RestSurface rest = rest_surface(*world, surface, hit, ray.time);
    const Rgb power = path.throughput *
                      (rest.area_ratio / (eta * eta * cosine * photons_per_pass * static_cast<float>(samples_per_map)));
    if (is_finite(power))
      photon = Photon{.position = rest.position,
                      .to_light = -ray.direction,
                      .normal = rest.normal,
                      .power = power,
                      .density = path.emitted.density,
                      .distance_m = hit.t,
                      .time = ray.time,
                      .medium = path.in_medium ? path.material : Photon::kNoMedium,
                      .diffuse = path.diffuse_bounces,
                      .glossy = path.glossy_bounces,
                      .transmission = path.transmission_bounces,
                      .group = group_of(groups, path)};
  }
  return bounce(paths, surface, hit, ray, path);
}

LightPathStages::Arrival LightPathStages::arrive(const accel::Hit& hit, const SurfacePoint& surface,
                                                 LightPathState& path) const {
  if (surface.unlit) return Arrival::ends;
  if (path.in_medium) path.throughput *= exp_negative(world->medium(path.material).extinction * hit.t);
  if (surface.has_thin_wall()) return Arrival::passes_straight;
  if (surface.alpha < 1.0f) return Arrival::ends;
  const bool caster = is_caster(surface.material);
  if (path.bounces == 0) {
    if (!caster) return Arrival::ends;
    path.throughput *= emission.radiance(path.emitted, surface.position) / path.emitted.finite_density;
    path.first_throughput = max_component(path.throughput);
  }
  if (is_black(path.throughput)) return Arrival::ends;
  const bool boundary = surface.layered && surface.layers.boundary;
  if (boundary && !caster) return Arrival::ends;
  return path.bounces > 0 && !boundary ? Arrival::joins : Arrival::scatters;
}

bool LightPathStages::pass_straight(const PathStages& paths, SurfacePoint& surface, accel::Ray& ray,
                                    LightPathState& path) {
  path.throughput *= paths.thin_wall_transmittance(surface, -ray.direction);
  ray.origin = offset_ray_origin(surface, ray.direction);
  return !is_black(path.throughput) && ++path.thin_walls <= kMaxTransparentSurfaces;
}

bool LightPathStages::take_color(uint32_t material, bool crosses, const PathStages::LayersHere& layers,
                                 LightPathState& path) const {
  if (!(world->medium(material).dispersion > 0.0f)) return true;
  const bool dispersed = path.wavelength_nm != 0.0f;
  if (mixes_colors(crosses, path.in_medium, dispersed, path.reflected_undispersed)) return false;
  if (!crosses) {
    path.reflected_undispersed |= !dispersed;
  } else if (!dispersed) {
    path.throughput *= layers.wavelength_weight;
    path.wavelength_nm = layers.wavelength_nm;
  }
  return true;
}

// Surfaces of bounce() and join_camera() share the stack of a GPU's thread, as neither is inlined.
KINDLING_CALLED_ON_GPU bool LightPathStages::bounce(const PathStages& paths, SurfacePoint& surface,
                                                    const accel::Hit& hit, accel::Ray& ray,
                                                    LightPathState& path) const {
  if (path.bounces >= kMaxBounces) return false;
  const bool boundary = surface.layered && surface.layers.boundary;
  // One medium at a time: paths into nested ones, and out of open meshes, are left to the camera's.
  if (boundary && (surface.layers.entering == path.in_medium || (path.in_medium && path.material != surface.material)))
    return false;
  const V3f to_light = -ray.direction;
  SeenSurface from_light{surface};
  from_light.look(paths, to_light, path.in_medium, path.material, path.wavelength_nm,
                  draw_of(path, kFirstWavelength + path.bounces).x);
  const uint32_t dimension = kFirstLightBounce + 2U * path.bounces;
  const V2f choice = draw_of(path, dimension), direction = draw_of(path, dimension + 1);
  const bool first = path.bounces == 0; // it is a caster
  const std::optional<BsdfSample> sampled = first
                                                ? sample_narrow(*from_light.bsdf, choice.x, direction, kMaxNarrowAlpha)
                                                : from_light.bsdf->sample(choice.x, direction);
  if (!sampled) return false;
  const V3f wi = from_light.frame.to_world(sampled->wi);
  const bool crosses = sampled->wi.z < 0.0f;
  const float along = wi.dot(surface.geometric_normal);
  if ((along < 0.0f) != crosses) return false;
  const bool inside = boundary ? path.in_medium != crosses : path.in_medium;
  if (sampled->pdf == 0.0f) {
    path.throughput *= sampled->weight;
  } else {
    SurfacePoint other_side;
    SeenSurface from_camera{other_side};
    from_camera.find(*world, surface.position, wi, hit, ray.time);
    from_camera.look(paths, wi, inside, boundary ? surface.material : path.material, from_light.layers.wavelength_nm,
                     0.0f);
    path.throughput *= from_camera.eval(to_light) *
                       (std::abs(along) / (std::abs(to_light.dot(surface.geometric_normal)) * sampled->pdf));
    if (first) path.throughput *= share_of(kShares, from_camera.narrow_steps(to_light));
  }
  if (first) path.narrow_probability = narrow_probability(*from_light.bsdf, kMaxNarrowAlpha);
  // Random walks are left to the camera's.
  if (boundary && inside && !is_black(world->medium(surface.material).scattering)) return false;
  if (boundary && !take_color(surface.material, crosses, from_light.layers, path)) return false;
  if (is_black(path.throughput) || !is_finite(path.throughput)) return false;
  path.thin_walls = 0;
  if (first)
    path.first_pdf = sampled->pdf;
  else
    ++(sampled->lobe == Lobe::diffuse  ? path.diffuse_bounces
       : sampled->lobe == Lobe::glossy ? path.glossy_bounces
                                       : path.transmission_bounces);
  ++path.bounces;
  if (boundary && crosses) {
    path.in_medium = inside;
    path.material = surface.material;
  }
  if (path.bounces >= kFirstRoulette) {
    const float survival = std::min(1.0f, max_component(path.throughput) / path.first_throughput);
    if (choice.y >= survival) return false;
    path.throughput /= survival;
  }
  ray.origin = offset_ray_origin(surface, wi);
  ray.direction = wi;
  ray.t_min = 0.0f;
  ray.t_max = kInfinity;
  ray.key = hash_combine(ray.key, path.bounces);
  return true;
}

KINDLING_CALLED_ON_GPU void LightPathStages::join_camera(const PathStages& paths, const SurfacePoint& surface,
                                                         const accel::Hit& hit, const accel::Ray& ray,
                                                         const LightPathState& path,
                                                         std::optional<LightJoint>& joint) const {
  // The surface itself is a diffuse bounce. The first caster is the last one from the camera, which
  // needs no further one.
  if (!paths.within_limits(1 + path.diffuse_bounces, path.glossy_bounces, path.transmission_bounces)) return;
  const std::optional<Sight> sight =
      see(*camera, surface.position, draw_of(path, kFirstLightBounce + 2U * path.bounces), ray.time);
  if (!sight) return;
  const auto& [eye, direction, distance, film_px, sight_weight] = *sight;
  const float reach = 0.5f * filter_width;
  const V2f from(outside.crop_min), to(outside.crop_end);
  if (!(film_px.x > from.x - reach && film_px.y > from.y - reach && film_px.x < to.x + reach &&
        film_px.y < to.y + reach))
    return;

  SurfacePoint seen_by_camera;
  SeenSurface seen{seen_by_camera};
  seen.find(*world, surface.position, -direction, hit, ray.time);
  seen.look(paths, -direction, false, 0, 0.0f, 0.0f);
  const V3f to_light = -ray.direction;
  Rgb value = seen.eval(to_light);
  if (is_caster(surface.material)) value *= share_of(kShares - seen.narrow_steps(to_light), kShares);
  if (is_black(value)) return;
  const float density = camera_density(*camera, direction, distance, surface.geometric_normal, ray.time);
  const float scale = ratio_scale(density);
  const float ratio = scale * path.emitted.density;
  Rgb radiance = path.throughput * value *
                 (density * sight_weight * light_weight(ratio) / std::abs(to_light.dot(surface.geometric_normal)));
  // A splat counts in its pixel at most as much as a sample of the largest radiance.
  const float largest = paths.settings.clamp_indirect * paths_per_pass, peak = max_component(radiance);
  if (peak > largest) radiance *= largest / peak;
  if (is_black(radiance) || !is_finite(radiance)) return;
  const V3f to_target = offset_ray_origin(seen_by_camera, -direction) - eye;
  const float target_distance = to_target.length();
  joint = LightJoint{.film_px = film_px,
                     .radiance = radiance,
                     .direction = direction,
                     .scale = scale,
                     .ratio = ratio,
                     .sight = {.origin = eye,
                               .t_min = 0.0f,
                               .direction = to_target / target_distance,
                               .t_max = target_distance * (1.0f - 1e-6f),
                               .key = ray.key,
                               .time = ray.time,
                               .index = path.index,
                               .flags = kHitPartlyTransparent | kCameraRay}};
}

} // namespace kindling
