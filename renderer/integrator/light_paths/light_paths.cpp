// Tracing of light paths, all those of a batch together.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/light_paths.h"

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/light_paths/camera_sight.h"
#include "renderer/integrator/light_paths/casters.h"
#include "renderer/integrator/light_paths/emitted_path.h"
#include "renderer/integrator/stages/prepare_path.h"
#include "renderer/integrator/stages/random_walk.h"

#include <algorithm>
#include <cmath>

namespace kindling {

namespace {

// Dimensions of a light path's draws: two for each bounce, and one for a wavelength.
enum Dimension : uint32_t { kFirstBounce = kAfterEmission, kFirstWavelength = 256 };

// Paths are ended at random from this bounce on.
constexpr uint8_t kFirstRoulette = 3;

struct Draws {
  uint32_t key;
  uint32_t index;
  [[nodiscard]] V2f operator()(uint32_t dimension) const { return Sampler::sample_2d(key, index, dimension); }
};

// A BSDF of a surface as it is seen from a side, with the frame that it refers to.
struct Seen {
  SurfacePoint surface;
  Frame frame;
  std::optional<SurfaceBsdf> bsdf;
  PathStages::LayersHere layers;

  // `in_medium`: the side of wo is inside of the medium `material`. `wavelength_nm`: 0 for all, of
  // which dispersive glass chooses one by `u_wavelength`.
  void look(const PathStages& stages, const V3f& wo, bool in_medium, uint32_t material, float wavelength_nm,
            float u_wavelength) {
    if (!surface.layered) {
      frame = Frame::around(surface.shading_normal);
      bsdf.emplace(surface.bsdf, nullptr, frame.to_local(wo));
      return;
    }
    frame = Frame::with_tangent(surface.shading_normal, surface.layers.tangent);
    PathState state;
    MediumStack media;
    if (in_medium) media.enter(material);
    state.in_medium = in_medium;
    state.wavelength_nm = wavelength_nm;
    layers = stages.resolve_layers(surface, frame, state, media, u_wavelength);
    bsdf.emplace(surface.bsdf, &surface.layers.bsdf, frame.to_local(wo));
  }
  // Returns f |cos| for light from wi; black where shading and geometric normal disagree on its
  // side.
  [[nodiscard]] Rgb eval(const V3f& wi) const {
    const float side = wi.dot(surface.geometric_normal);
    if (!surface.layered && side <= 0.0f) return Rgb(0.0f);
    if ((side > 0.0f) != (wi.dot(frame.normal) > 0.0f)) return Rgb(0.0f);
    return bsdf->eval(frame.to_local(wi)).value;
  }
  // Returns LightPathView::narrow_steps() for light from wi.
  [[nodiscard]] uint32_t narrow_steps(const V3f& wi) const {
    return LightPathView::narrow_steps(*bsdf, frame.to_local(wi), false);
  }
  // Returns the density of a cosine lobe over that of the directions that the guide chooses.
  [[nodiscard]] float cosine_over_density(const PathStages& stages, const V3f& from_camera, const V3f& wi) const {
    GuidedBsdf guided(surface.bsdf, surface.layered ? &surface.layers.bsdf : nullptr, frame, -from_camera);
    if (stages.patches) guided.guide_to(*stages.patches, surface.position);
    return std::abs(frame.to_local(wi).z) * kInvPi / guided.eval(wi).pdf;
  }
};

// The surface at a hit as it is seen from a direction.
void look_from(const WorldView& world, const V3f& position, const V3f& wo, const accel::Hit& hit, float time,
               SurfacePoint& surface) {
  accel::Ray ray{.origin = position + wo, .direction = -wo, .time = time};
  accel::Hit seen = hit;
  seen.t = 1.0f;
  world.surface_at(ray, seen, surface);
}

} // namespace

std::optional<uint32_t> light_path_pass(float fraction, uint32_t sample) {
  const double f = fraction;
  const double before = std::ceil(f * sample);
  if (std::ceil(f * (static_cast<double>(sample) + 1.0)) <= before) return std::nullopt;
  return static_cast<uint32_t>(before);
}

LightPaths::LightPaths(const IntegratorSettings& settings, const World& world, const Camera& camera,
                       const PixelFilter& filter, uint32_t seed)
    : world_(world), camera_(camera), filter_(filter), caster_flags_(find_caster_materials(world)), seed_(seed),
      fraction_(settings.light_paths) {
  sampling_.emplace(world.lights, find_targets(world, caster_flags_), world.bounds);
  emission = *sampling_;
  casters = caster_flags_;
  paths_per_pass = fraction_ * static_cast<float>(camera.size_px().x) * static_cast<float>(camera.size_px().y);
}

void LightPaths::start(const PixelRect& block, uint32_t pass, LightPathContext& context) const {
  const V2i size = camera_.size_px();
  const auto pixels = static_cast<uint64_t>(size.x) * static_cast<uint64_t>(size.y);
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x)
      start_path(pass * pixels + static_cast<uint64_t>(y) * static_cast<uint64_t>(size.x) + static_cast<uint64_t>(x),
                 context);
}

void LightPaths::start_path(uint64_t number, LightPathContext& context) const {
  const uint32_t key = hash_combine(hash_u32(seed_ ^ 0x11947a9dU), static_cast<uint32_t>(number >> 32));
  const std::optional<EmittedPath> started =
      start_emitted_path(emission, key, static_cast<uint32_t>(number), camera_.shutter_open());
  if (!started) return;
  LightPathContext::Path path;
  path.emitted = started->emitted;
  path.key = key;
  path.index = static_cast<uint32_t>(number);
  context.active.push_back(static_cast<uint32_t>(context.paths.size()));
  context.paths.push_back(path);
  context.rays.push_back(started->ray);
}

void LightPaths::clear(LightPathContext& context) {
  context.paths.clear();
  context.active.clear();
  context.rays.clear();
  context.found.clear();
  context.path_count = 0;
}

void LightPaths::trace(const PathStages& stages, const PixelRect& block, const SampleRange& samples,
                       LightPathContext& context, RayCounters& counters) const {
  clear(context);
  for (uint32_t sample = samples.first; sample < samples.end; ++sample) {
    const std::optional<uint32_t> pass = light_path_pass(fraction_, sample);
    if (!pass) continue;
    start(block, *pass, context);
    context.path_count += static_cast<uint64_t>(block.pixel_count());
  }
  follow(stages, context, counters);
}

void LightPaths::trace_numbers(const PathStages& stages, uint64_t first, uint64_t count, LightPathContext& context,
                               RayCounters& counters) const {
  clear(context);
  for (uint64_t number = first; number < first + count; ++number) start_path(number, context);
  context.path_count = count;
  follow(stages, context, counters);
}

void LightPaths::follow(const PathStages& stages, LightPathContext& context, RayCounters& counters) const {
  while (!context.active.empty() && !world_.abandoned()) {
    context.hits.resize(context.rays.size());
    world_.accelerator().intersect(context.rays, context.hits);
    counters.bounce += context.rays.size();
    context.splats.clear();
    context.camera_rays.clear();
    size_t remaining = 0;
    for (size_t i = 0; i < context.active.size(); ++i) {
      accel::Ray ray = context.rays[i];
      const uint32_t number = context.active[i];
      if (!context.hits[i].is_hit() || !scatter(stages, context.hits[i], ray, context.paths[number], context)) continue;
      context.rays[remaining] = ray;
      context.active[remaining++] = number;
    }
    context.rays.resize(remaining);
    context.active.resize(remaining);
    keep_visible(context, counters);
  }
}

bool LightPaths::scatter(const PathStages& stages, const accel::Hit& hit, accel::Ray& ray, LightPathContext::Path& path,
                         LightPathContext& context) const {
  SurfacePoint surface;
  world_.surface_at(ray, hit, surface);
  if (surface.unlit) return false;
  if (path.in_medium) path.throughput *= exp_negative(world_.medium(path.material).extinction * hit.t);
  if (surface.has_thin_wall()) return pass_straight(stages, surface, ray, path);
  if (surface.alpha < 1.0f) return false;
  const bool caster = is_caster(surface.material);
  if (path.bounces == 0) {
    if (!caster) return false;
    path.throughput *= emission.radiance(path.emitted, surface.position) / path.emitted.finite_density;
    path.first_throughput = max_component(path.throughput);
    if (context.measures) path.arriving = arriving_density(path.emitted, surface.position);
  }
  if (is_black(path.throughput)) return false;
  const bool boundary = surface.layered && surface.layers.boundary;
  if (boundary && !caster) return false;
  if (path.bounces > 0 && !boundary && !path.in_medium) join_camera(stages, surface, hit, ray, path, context);
  return bounce(stages, surface, hit, ray, path);
}

bool LightPaths::pass_straight(const PathStages& stages, SurfacePoint& surface, accel::Ray& ray,
                               LightPathContext::Path& path) const {
  path.throughput *= stages.thin_wall_transmittance(surface, -ray.direction);
  ray.origin = offset_ray_origin(surface, ray.direction);
  return !is_black(path.throughput) && ++path.thin_walls <= kMaxTransparentSurfaces;
}

// Gives a path that is refracted at dispersive glass its wavelength. False: such paths are left to
// the camera's.
bool LightPaths::take_color(uint32_t material, bool crosses, const PathStages::LayersHere& layers,
                            LightPathContext::Path& path) const {
  if (!(world_.medium(material).dispersion > 0.0f)) return true;
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

bool LightPaths::bounce(const PathStages& stages, SurfacePoint& surface, const accel::Hit& hit, accel::Ray& ray,
                        LightPathContext::Path& path) const {
  if (path.bounces >= kMaxBounces) return false;
  const bool boundary = surface.layered && surface.layers.boundary;
  // One medium at a time: paths into nested ones, and out of open meshes, are left to the camera's.
  if (boundary && (surface.layers.entering == path.in_medium || (path.in_medium && path.material != surface.material)))
    return false;
  const Draws draws{path.key, path.index};
  const V3f to_light = -ray.direction;
  Seen from_light{surface, {}, {}, {}};
  from_light.look(stages, to_light, path.in_medium, path.material, path.wavelength_nm,
                  draws(kFirstWavelength + path.bounces).x);
  const V2f choice = draws(kFirstBounce + 2U * path.bounces), direction = draws(kFirstBounce + 2U * path.bounces + 1);
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
    Seen from_camera;
    look_from(world_, surface.position, wi, hit, ray.time, from_camera.surface);
    from_camera.look(stages, wi, inside, boundary ? surface.material : path.material, from_light.layers.wavelength_nm,
                     0.0f);
    path.throughput *= from_camera.eval(to_light) *
                       (std::abs(along) / (std::abs(to_light.dot(surface.geometric_normal)) * sampled->pdf));
    if (first) path.throughput *= share_of(kShares, from_camera.narrow_steps(to_light));
  }
  if (first) path.narrow_probability = narrow_probability(*from_light.bsdf, kMaxNarrowAlpha);
  // Random walks are left to the camera's.
  if (boundary && inside && !is_black(world_.medium(surface.material).scattering)) return false;
  if (boundary && !take_color(surface.material, crosses, from_light.layers, path)) return false;
  if (is_black(path.throughput) || !is_finite(path.throughput)) return false;
  path.thin_walls = 0;
  path.lobes[path.bounces++] = {sampled->lobe, sampled->pdf};
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

// Returns the density of light paths at a point, per square meter perpendicular to the emitted ray,
// among those from the same point or direction of their light. A path from the camera finds these
// by a light sample if the caster is rough, which chooses lights about as light paths do.
float LightPaths::arriving_density(const EmittedRay& emitted, const V3f& at) const {
  const size_t triangles = emission.lights->triangles.size();
  const bool in_sky = emitted.emitter == emission.environment_emitter() ||
                      (emitted.emitter >= triangles && emission.lights->punctuals[emitted.emitter - triangles].kind ==
                                                           LightSetView::Punctual::Kind::directional);
  if (in_sky) return emission.disk_density(at, emitted.direction);
  return emission.direction_density(emitted.origin, emitted.direction) / (at - emitted.origin).length2();
}

void LightPaths::join_camera(const PathStages& stages, const SurfacePoint& surface, const accel::Hit& hit,
                             const accel::Ray& ray, const LightPathContext::Path& path,
                             LightPathContext& context) const {
  // The limits count from the camera: the surface itself, then the casters from here on.
  PathState limits;
  bool within = stages.count_bounce(Lobe::diffuse, 1.0f, limits);
  for (size_t i = path.bounces; i > 0 && within; --i) {
    const bool more = stages.count_bounce(path.lobes[i - 1].lobe, path.lobes[i - 1].pdf, limits);
    within = more || i == 1;
  }
  if (!within) return;

  const std::optional<Sight> sight =
      see(camera_, surface.position, Draws{path.key, path.index}(kFirstBounce + 2U * path.bounces), ray.time);
  if (!sight) return;
  const auto& [eye, direction, distance, film_px] = *sight;
  const float reach = 0.5f * filter_.width();
  const V2i size = camera_.size_px();
  if (!(film_px.x > -reach && film_px.y > -reach && film_px.x < static_cast<float>(size.x) + reach &&
        film_px.y < static_cast<float>(size.y) + reach))
    return;

  Seen seen;
  look_from(world_, surface.position, -direction, hit, ray.time, seen.surface);
  seen.look(stages, -direction, false, 0, 0.0f, 0.0f);
  const V3f to_light = -ray.direction;
  Rgb value = seen.eval(to_light);
  if (is_caster(surface.material)) value *= share_of(kShares - seen.narrow_steps(to_light), kShares);
  if (is_black(value)) return;
  const float density = camera_density(camera_, direction, distance, surface.geometric_normal, ray.time);
  const float ratio = ratio_scale(density) * path.emitted.density;
  const Rgb radiance =
      path.throughput * value * (density * light_weight(ratio) / std::abs(to_light.dot(surface.geometric_normal)));
  if (is_black(radiance) || !is_finite(radiance)) return;
  const V3f target = offset_ray_origin(seen.surface, -direction);
  const V3f to_target = target - eye;
  const float target_distance = to_target.length();
  float traced_ratio = 0.0f;
  if (context.measures) {
    const float found = path.narrow_probability / (ratio * seen.cosine_over_density(stages, direction, to_light));
    const float sampled =
        path.lobes[0].pdf > 0.0f ? 1.0f / (ratio_scale(density) * path.arriving * path.lobes[0].pdf) : 0.0f;
    traced_ratio = 1.0f / (found + sampled);
  }
  context.splats.push_back({film_px, radiance, ratio, traced_ratio});
  context.camera_rays.push_back({.origin = eye,
                                 .t_min = 0.0f,
                                 .direction = to_target / target_distance,
                                 .t_max = target_distance * (1.0f - 1e-6f),
                                 .key = ray.key,
                                 .time = ray.time,
                                 .index = path.index,
                                 .flags = kHitPartlyTransparent | kCameraRay});
}

void LightPaths::keep_visible(LightPathContext& context, RayCounters& counters) const {
  if (context.camera_rays.empty()) return;
  context.occluded.resize(context.camera_rays.size());
  world_.accelerator().occluded(context.camera_rays, context.occluded);
  counters.shadow += context.camera_rays.size();
  for (size_t i = 0; i < context.splats.size(); ++i)
    if (context.occluded[i] == 0) context.found.push_back(context.splats[i]);
}

void LightPaths::add_to(const PixelRect& block, const LightPathContext& context, Film& film) const {
  film.add_light_paths(block.min, context.path_count);
  const PixelRect& area = film.splat_area();
  const float radius = 0.5f * filter_.width();
  for (const LightPathContext::Splat& splat : context.found) {
    const V2f& at = splat.film_px;
    const auto first = [&](float x, int min) { return std::max(static_cast<int>(std::ceil(x - radius - 0.5f)), min); };
    const auto end = [&](float x, int max) {
      return std::min(static_cast<int>(std::floor(x + radius - 0.5f)) + 1, max);
    };
    for (int y = first(at.y, area.min.y); y < end(at.y, area.max.y); ++y)
      for (int x = first(at.x, area.min.x); x < end(at.x, area.max.x); ++x) {
        const float weight = filter_.value({at.x - 0.5f - static_cast<float>(x), at.y - 0.5f - static_cast<float>(y)});
        if (weight != 0.0f) film.add_splat({x, y}, splat.radiance * weight);
      }
  }
}

} // namespace kindling
