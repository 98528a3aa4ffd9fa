// Tracing of light paths, all those of a batch together.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/light_paths.h"

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/light_paths/casters.h"
#include "renderer/integrator/stages/seen_surface.h"
#include "renderer/integrator/stages/splat_pixels.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kindling {

LightPaths::LightPaths(const IntegratorSettings& settings, const World& whole_world, const Camera& seen_by,
                       const PixelFilter& filter, uint32_t render_seed)
    : world_(whole_world), filter_(filter), caster_flags_(find_caster_materials(whole_world)),
      fraction_(settings.light_paths) {
  sampling_.emplace(whole_world.lights, find_targets(whole_world, caster_flags_), whole_world.bounds);
  emission = static_cast<const EmissionView&>(*sampling_);
  casters = caster_flags_;
  const float pixels = static_cast<float>(seen_by.size_px().x) * static_cast<float>(seen_by.size_px().y);
  paths_per_pass = fraction_ * pixels;
  constexpr float kMaxPhotons = 0x1p31f; // they are numbered by 32 bits
  if (settings.photons > 0.0f) {
    photons_per_pass = std::clamp(std::floor(settings.photons * pixels), 1.0f, kMaxPhotons);
    samples_per_map = settings.samples_per_photon_map > 0
                          ? settings.samples_per_photon_map
                          : PhotonMapSizes::of(static_cast<uint64_t>(photons_per_pass)).samples;
  }
  constexpr float kMaxRadius = 0.02f; // in relation to the largest caster
  for (const EmissionTarget& target : emission.targets)
    max_photon_radius_m = std::max(max_photon_radius_m, kMaxRadius * target.radius);
  world = &whole_world;
  camera = &seen_by;
  filter_width = filter.width();
  const bool cropped = settings.crop_min != settings.crop_end;
  outside = {.size_px = seen_by.size_px(),
             .crop_min = settings.crop_min,
             .crop_end = cropped ? settings.crop_end : settings.crop_min + seen_by.size_px()};
  seed = render_seed;
}

std::unique_ptr<LightPaths> make_light_paths(const IntegratorSettings& settings, const World& world,
                                             const Camera& camera, const PixelFilter& filter, uint32_t seed) {
  if (!(settings.light_paths > 0.0f || settings.photons > 0.0f)) return nullptr;
  auto light_paths = std::make_unique<LightPaths>(settings, world, camera, filter, seed);
  return light_paths->useful() ? std::move(light_paths) : nullptr;
}

void LightPaths::start_block(const PixelRect& block, uint32_t pass, LightPathContext& context) const {
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) start_path(number_of({x, y}, pass), context);
}

void LightPaths::start_path(uint64_t number, LightPathContext& context) const {
  LightPathState path;
  accel::Ray ray;
  if (!start(number, path, ray)) return;
  context.active.push_back(static_cast<uint32_t>(context.paths.size()));
  context.paths.push_back(path);
  if (context.measures) context.arriving.push_back(0.0f);
  context.rays.push_back(ray);
}

void LightPaths::clear_paths(LightPathContext& context) {
  context.paths.clear();
  context.arriving.clear();
  context.active.clear();
  context.rays.clear();
}

void LightPaths::clear(LightPathContext& context) {
  clear_paths(context);
  context.found.clear();
}

void LightPaths::trace(const PathStages& stages, std::span<const PixelRect> blocks, const SampleRange& samples,
                       LightPathContext& context, RayCounters& counters) const {
  clear(context);
  const SampleRange passes = light_path_passes(fraction_, samples);
  for (const PixelRect& block : blocks)
    for (uint32_t pass = passes.first; pass < passes.end; ++pass) start_block(block, pass, context);
  follow(stages, context, counters);
  for (const PixelRect& block : blocks) {
    const OutsidePixels::Range share = outside.share_of(block.min, kBlockSize);
    if (share.count() == 0) continue;
    RayCounters rays;
    for (uint32_t pass = passes.first; pass < passes.end; ++pass) trace_outside(stages, share, pass, context, rays);
    rays.outside = rays.total();
    counters.add(rays);
  }
}

// A block's share may have far more paths than the block has samples, so a thread traces some of
// them at a time.
void LightPaths::trace_outside(const PathStages& stages, const OutsidePixels::Range& share, uint32_t pass,
                               LightPathContext& context, RayCounters& counters) const {
  constexpr uint64_t kTogether = 4 * kBlockSize * kBlockSize;
  for (uint64_t first = share.first; first < share.end && !world_.abandoned(); first += kTogether) {
    clear_paths(context);
    const uint64_t end = std::min(first + kTogether, share.end);
    for (uint64_t number = first; number < end; ++number)
      start_path(number_at(outside.index_at(number), pass), context);
    follow(stages, context, counters);
  }
}

void LightPaths::trace_numbers(const PathStages& stages, uint64_t first, uint64_t count, LightPathContext& context,
                               RayCounters& counters) const {
  clear(context);
  for (uint64_t number = first; number < first + count; ++number) start_path(number, context);
  follow(stages, context, counters);
}

void LightPaths::trace_photons(const PathStages& stages, uint64_t first, uint64_t count, LightPathContext& context,
                               std::vector<Photon>& photons, RayCounters& counters) const {
  clear(context);
  context.photons = &photons;
  for (uint64_t number = first; number < first + count; ++number) start_path(kFirstPhotonPath + number, context);
  RayCounters rays;
  follow(stages, context, rays);
  counters.photon += rays.total();
  context.photons = nullptr;
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
      if (!context.hits[i].is_hit() || !scatter_path(stages, context.hits[i], ray, number, context)) continue;
      context.rays[remaining] = ray;
      context.active[remaining++] = number;
    }
    context.rays.resize(remaining);
    context.active.resize(remaining);
    keep_visible(context, counters);
  }
}

bool LightPaths::scatter_path(const PathStages& stages, const accel::Hit& hit, accel::Ray& ray, uint32_t number,
                              LightPathContext& context) const {
  LightPathState& path = context.paths[number];
  SurfacePoint surface;
  world_.surface_at(ray, hit, surface);
  if (context.photons != nullptr) {
    std::optional<Photon> photon;
    const bool continues = scatter_photon(stages, context.splits != nullptr ? *context.splits : LightGroupsView{}, hit,
                                          surface, ray, path, photon);
    if (photon) context.photons->push_back(*photon);
    return continues;
  }
  if (context.measures && path.bounces == 0)
    context.arriving[number] = arriving_density(path.emitted, surface.position);
  const accel::Ray arrived = ray;
  std::optional<LightJoint> joint;
  const bool continues = scatter(stages, hit, surface, ray, path, joint);
  if (joint) {
    const float traced =
        context.measures ? traced_ratio(stages, surface, hit, arrived, path, context.arriving[number], *joint) : 0.0f;
    context.splats.push_back({joint->film_px, joint->radiance, joint->ratio, traced, {}});
    if (context.splits)
      context.splats.back().parts = parts_of(stages, *context.splits, surface, hit, arrived, path, *joint);
    context.camera_rays.push_back(joint->sight);
  }
  return continues;
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

// Returns the ratio of the densities of light paths and of paths from the camera as they are
// traced, at a surface where `path` was joined to the camera.
float LightPaths::traced_ratio(const PathStages& stages, const SurfacePoint& surface, const accel::Hit& hit,
                               const accel::Ray& ray, const LightPathState& path, float arriving,
                               const LightJoint& joint) const {
  SurfacePoint scratch;
  const SeenSurface seen = SeenSurface::from_camera(stages, surface.position, joint.direction, hit, ray.time, scratch);
  GuidedBsdf guided(seen.surface.bsdf, seen.surface.layered ? &seen.surface.layers.bsdf : nullptr, seen.frame,
                    -joint.direction);
  stages.guide(guided, seen.surface.position);
  // The density of a cosine lobe over that of the directions that the guide chooses.
  const V3f to_light = -ray.direction;
  const float cosine_over_density = std::abs(seen.frame.to_local(to_light).z) * kInvPi / guided.eval(to_light).pdf;
  const float found = path.narrow_probability / (joint.ratio * cosine_over_density);
  const float sampled = path.first_pdf > 0.0f ? 1.0f / (joint.scale * arriving * path.first_pdf) : 0.0f;
  return 1.0f / (found + sampled);
}

void LightPaths::keep_visible(LightPathContext& context, RayCounters& counters) const {
  if (context.camera_rays.empty()) return;
  context.occluded.resize(context.camera_rays.size());
  world_.accelerator().occluded(context.camera_rays, context.occluded);
  counters.shadow += context.camera_rays.size();
  for (size_t i = 0; i < context.splats.size(); ++i)
    if (context.occluded[i] == 0) context.found.push_back(context.splats[i]);
}

void LightPaths::add_to(std::span<const PixelRect> blocks, const SampleRange& samples, const LightPathContext& context,
                        Film& film) const {
  const uint64_t passes = light_path_passes(fraction_, samples).count();
  for (const PixelRect& block : blocks) {
    const OutsidePixels::Range share = outside.share_of(block.min, kBlockSize);
    film.add_light_paths(block.min, passes * (static_cast<uint64_t>(block.pixel_count()) + share.count()));
  }
  const PixelRect& area = film.splat_area();
  for (const LightPathContext::Splat& splat : context.found)
    visit_splat_pixels(filter_, splat.film_px, area.min, area.max, [&](const V2i& pixel, float weight) {
      film.add_splat(pixel, splat.radiance * weight, splat.parts);
    });
}

} // namespace kindling
