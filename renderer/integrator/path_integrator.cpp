// The path tracer's loops over a batch: each stage for all paths, in groups.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"

#include "renderer/guiding/guide.h"
#include "renderer/integrator/append_reserved.h"
#include "renderer/integrator/batch_sink.h"
#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/caught_paths.h"
#include "renderer/integrator/level_list.h"
#include "renderer/integrator/path_reuse.h"
#include "renderer/integrator/shade_batch.h"
#include "renderer/integrator/shadow_catchers.h"
#include "renderer/integrator/stages/light_draws.h"
#include "renderer/integrator/stages/prepare_path.h"
#include "renderer/integrator/stages/random_walk.h"

#include <array>
#include <cassert>
#include <utility>

namespace kindling {

PathStages make_path_stages(const IntegratorSettings& settings, const World& world, const Camera& camera,
                            const Sampler& sampler, const Guide* guide) {
  return {.settings = settings,
          .sample_width = sample_width(sampler),
          .specular_scale = specular_scale(settings.environment_filter, sampler),
          .world = &world,
          .camera = &camera,
          .patches = guide && !guide->patches.empty() ? &guide->patches : nullptr,
          .light_probabilities = guide && !guide->light_probabilities.empty() ? &guide->light_probabilities : nullptr,
          .to_environment = guide && !guide->environment.empty() ? &guide->environment : nullptr,
          .caustics = guide && !guide->caustics.empty() ? &guide->caustics : nullptr,
          .volumes = guide && !guide->volumes.empty() ? &guide->volumes : nullptr};
}

std::unique_ptr<const PresampledEnvironment> presample_environment(const IntegratorSettings& settings,
                                                                   const LightSetView& lights, uint32_t seed) {
  const bool has_image = lights.has_environment && lights.environment.width > 0;
  if (!settings.presamples_environment || settings.kind != IntegratorKind::path || !has_image) return nullptr;
  return std::make_unique<PresampledEnvironment>(lights.environment, seed);
}

PathIntegrator::PathIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                               const Sampler& sampler, const PixelFilter& filter, AovSet aovs, const Guide* guide,
                               const AovInputs& inputs)
    : stages_(make_path_stages(settings, world, camera, sampler, guide)), world_(world),
      accelerator_(&world.accelerator()), camera_(camera), sampler_(sampler), filter_(filter), aovs_(aovs),
      presampled_(presample_environment(settings, world.lights, sampler.seed())),
      first_hits_(world, camera, filter_, aovs, inputs) {
  stages_.presampled = presampled_.get();
  if (aovs.contains(Aov::shadow_catcher) && inputs.catchers) {
    catchers_ = inputs.catchers;
    unshaded_ = std::make_unique<PathIntegrator>(settings, world, camera, sampler, filter, AovSet{}, guide);
    unshaded_->accelerator_ = &catchers_->unshaded();
    unshaded_->light_groups_ = {};
    unshaded_->groups_ = {};
  }
  stages_.manifolds = (manifolds_ = make_manifolds(settings, world)).get();
  light_paths_ = make_light_paths(settings, world, camera, filter_, sampler.seed());
  stages_.light_paths = light_paths_.get();
  if (light_paths_ && settings.photons > 0.0f) photon_maps_ = std::make_unique<PhotonMaps>(light_paths_->photon_maps());
  if (Result<LightGroups> groups = make_light_groups(world, settings.light_groups, settings.background.has_value()))
    light_groups_ = std::move(groups).value(); // more than there may be: refused by check_light_groups()
  groups_ = light_groups_.view(world.surface_nodes());
}

namespace {

size_t count_pixels(std::span<const PixelRect> blocks) {
  size_t count = 0;
  for (const PixelRect& block : blocks) count += static_cast<size_t>(block.pixel_count());
  return count;
}

} // namespace

std::unique_ptr<ThreadContext> PathIntegrator::make_context() const { return make_path_context(); }

std::unique_ptr<PathContext> PathIntegrator::make_path_context() const {
  assert(stages_.settings.batch_size >= kBlockSize * kBlockSize);
  const size_t size = std::max<size_t>(stages_.settings.batch_size, LevelList::kMaxOfLevel);
  const size_t shadow_rays = stages_.settings.max_shadow_rays();
  auto context = std::make_unique<PathContext>(size, shadow_rays, aovs_);
  const bool splits = groups_.count > 0 || aovs_.needs_light_passes();
  if (splits || aovs_.needs_lobe_colors())
    context->split_light =
        std::make_unique<SplitLight>(size, size * shadow_rays, groups_, stages_.settings.path_reuse > 1);
  if (splits) context->light_paths.splits = &groups_;
  if (stages_.settings.path_reuse > 1)
    context->reuse = std::make_unique<PathReuse>(size, static_cast<uint32_t>(stages_.settings.path_reuse));
  if (unshaded_) context->caught = std::make_unique<CaughtPaths>(size, unshaded_->make_path_context());
  return context;
}

bool PathIntegrator::take_photons(const SampleRange& samples, PathContext& context) const {
  if (!photon_maps_ || context.recorder) return true; // a guide learns what photons leave
  const PhotonMaps::Trace trace = [&](uint64_t first, uint64_t count, std::vector<Photon>& photons) {
    light_paths_->trace_photons(stages_, first, count, context.light_paths, photons, context.counters);
  };
  return context.photon_maps.take(samples.first, samples.end, *photon_maps_, trace,
                                  [this] { return world_.abandoned(); });
}

// All paths of a batch advance together, so that the accelerator receives streams of rays.
uint32_t PathIntegrator::render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& thread,
                                      Film& film) const {
  assert(dynamic_cast<PathContext*>(&thread));
  auto& context = static_cast<PathContext&>(thread);
  const uint32_t per_batch = samples_per_batch(followed_block(block, context), stages_.settings.batch_size);
  for (uint32_t done = 0; done < samples.count(); done += per_batch) {
    const SampleRange batch{samples.first + done, samples.first + std::min(done + per_batch, samples.count())};
    if (!render_batch({&block, 1}, batch, context, film)) return done;
  }
  return samples.count();
}

bool PathIntegrator::render_batch(std::span<const PixelRect> blocks, const SampleRange& samples, PathContext& context,
                                  Film& film) const {
  context.level.reset();
  if (!take_photons(samples, context)) return false;
  std::span<const PixelRect> followed = blocks;
  const bool reuses = context.reuses();
  if (reuses) {
    context.reuse->blocks.clear();
    for (const PixelRect& block : blocks) context.reuse->blocks.push_back(followed_block(block, context));
    followed = context.reuse->blocks;
    const V2i in_block = blocks[0].min - followed[0].min;
    context.traced_slot = static_cast<uint32_t>(in_block.y * followed[0].width() + in_block.x); // a replay has one
  }
  start_batch(followed, samples, context);
  const size_t path_count = context.active.size();
  if (reuses) context.reuse->start(path_count);
  trace_camera_rays(followed, samples, context);
  follow(context);
  if (reuses) share_paths(followed, samples, path_count, context);
  if (unshaded_) follow_caught(blocks, samples, context);
  const bool from_lights = light_paths_ && film.has_splats(); // neither training nor a replay
  if (from_lights) light_paths_->trace(stages_, blocks, samples, context.light_paths, context.counters);
  if (world_.abandoned()) return false;
  finish_batch(blocks, path_count, context, film);
  if (reuses) context.counters.paths -= path_count - count_pixels(blocks) * samples.count(); // those outside
  if (from_lights) light_paths_->add_to(blocks, samples, context.light_paths, film);
  return true;
}

uint32_t PathIntegrator::render_levels(const PixelRect& block, const SampleRange& levels, const SampleRates& rates,
                                       ThreadContext& thread, Film& film) const {
  assert(dynamic_cast<PathContext*>(&thread));
  auto& context = static_cast<PathContext&>(thread);
  LevelList list(block, rates, levels.first);
  const uint32_t max_levels = light_paths_ ? samples_per_batch(block, stages_.settings.batch_size) : levels.count();
  while (list.level() < levels.end) {
    const uint32_t first = list.level();
    uint32_t end = std::min(levels.end, first + std::min(max_levels, levels.end - first));
    if (photon_maps_) { // those of one map
      const uint32_t per_map = photon_maps_->samples_per_map();
      end = std::min(end, (first / per_map + 1) * per_map);
    }
    context.level = first;
    if (!take_photons({first, first + 1}, context)) return first - levels.first;
    list.take(end, context.states.size(), context.listed);
    start_listed(block, context);
    trace_together(context);
    follow(context);
    const bool from_lights = light_paths_ && film.has_splats();
    const SampleRange rendered{first, list.level()};
    if (from_lights) light_paths_->trace(stages_, {&block, 1}, rendered, context.light_paths, context.counters);
    if (world_.abandoned()) return first - levels.first;
    finish_batch({&block, 1}, context.listed.size(), context, film);
    if (from_lights) light_paths_->add_to({&block, 1}, rendered, context.light_paths, film);
  }
  return levels.count();
}

void PathIntegrator::follow(PathContext& context) const {
  bool first_surfaces = true;
  while (!context.active.empty() && !world_.abandoned()) {
    shade(context);
    trace_shadows(context, first_surfaces);
    first_surfaces = false;
    context.active.swap(context.next_active);
    context.rays.swap(context.next_rays);
    trace_bounces(context);
  }
}

void PathIntegrator::trace_bounces(PathContext& context) const {
  if (context.rays.empty()) return;
  context.hits.resize(context.rays.size());
  accelerator_->intersect(context.rays, context.hits);
  context.counters.bounce += context.rays.size();
}

void PathIntegrator::shade(PathContext& context) const {
  context.shadow_rays.clear();
  context.shadow_records.clear();
  if (context.recorder) context.recorder->start_lights();
  context.next_active.clear();
  context.next_rays.clear();
  if (context.split_light) {
    shade_split(context);
    return;
  }
  BatchSink sink{context, world_, stages_};
  const size_t count = context.active.size();
  const size_t together = ShadeGroup::size_for(stages_.settings.direct_samples);
  for (size_t first = 0; first < count; first += together) {
    const size_t end = std::min(first + together, count);
    shade_group(first, end, context, sink);
    if (!context.first_hits.empty()) note_first_hits(first, end, context);
  }
}

// Notes the hits of the active paths that have just found their first surface.
void PathIntegrator::note_first_hits(size_t first, size_t end, PathContext& context) {
  for (size_t i = first; i < end; ++i) {
    const uint32_t slot = context.active[i];
    if (context.surfaces[slot].hit && !context.first_hits[slot].is_hit()) context.first_hits[slot] = context.hits[i];
  }
}

// Evaluates the surfaces that the paths of a group have hit. Memory is prefetched for the whole
// group, so that the cache misses of its hits overlap.
void PathIntegrator::prepare_group(size_t first, size_t count, PathContext& context) const {
  assert(count <= ShadeGroup::kSize && first + count <= context.hits.size());
  ShadeGroup& group = context.group;
  const std::span<accel::Hit> hits = std::span(group.reached).first(count);
  std::copy_n(context.hits.begin() + static_cast<ptrdiff_t>(first), count, hits.begin());
  const std::span<const accel::Ray> rays(context.rays.data() + first, count);
  const std::span<RayFootprint> footprints = std::span(group.footprints).first(count);
  std::array<EnvironmentView::Location*, ShadeGroup::kSize> locations;
  size_t escaped = 0;
  for (size_t i = 0; i < count; ++i) {
    ShadeGroup::Member& member = group.members[i];
    member.scattered.reset();
    if (!hits[i].is_hit()) {
      group.to_environment[escaped] = rays[i].direction;
      locations[escaped++] = &member.in_environment;
      continue;
    }
    const PathInFlight path = context.path_at(context.active[first + i]);
    member.scattered = stages_.scatter_distance(hits[i].t, path);
    footprints[i] = stages_.measure_footprint(rays[i], member.scattered.value_or(hits[i].t), path.state);
    if (member.scattered) hits[i] = {};
  }
  world_.lights.locate_in_environment(std::span(group.to_environment).first(escaped),
                                      std::span(locations).first(escaped));
  world_.prefetch(rays, hits, footprints);
  for (size_t i = 0; i < count; ++i) {
    if (hits[i].is_hit()) world_.surface_at(rays[i], hits[i], group.members[i].surface, footprints[i]);
  }
}

// Draws random numbers and looks up what a guide knows for the vertices of a group that reflect.
// Returns how many there are; their numbers go to `reflecting`.
size_t PathIntegrator::draw_for_group(size_t first, size_t count, PathContext& context) const {
  ShadeGroup& group = context.group;
  std::array<EnvironmentView::Location*, ShadeGroup::kSize> locations; // of what clear glass mirrors
  size_t reflecting = 0, mirroring = 0;
  for (size_t i = 0; i < count; ++i) {
    const PathInFlight path = context.path_at(context.active[first + i]);
    ShadeGroup::Member& member = group.members[i];
    const SurfacePoint& surface = member.surface;
    if (!group.reached[i].is_hit() || !PathStages::reflects(surface, path.state)) continue;
    member.sampled.mirrored = nullptr;
    if (surface.layered && stages_.favors_reflection(surface, path.state)) {
      member.sampled.mirrored = &member.in_environment;
      group.to_environment[mirroring] = PathStages::mirrored(context.rays[first + i].direction, surface);
      locations[mirroring++] = &member.in_environment;
    }
    group.addresses[reflecting] = PathStages::draws_address(path);
    if (stages_.light_probabilities)
      group.searches[reflecting] = LightSelectionTreeView::search(surface.position, surface.geometric_normal);
    group.reflecting[reflecting++] = static_cast<uint8_t>(i);
  }
  world_.lights.locate_in_environment(std::span(group.to_environment).first(mirroring),
                                      std::span(locations).first(mirroring));
  draw_bounces(std::span(group.addresses).first(reflecting), std::span(group.draws).first(reflecting));
  if (stages_.light_probabilities)
    find_regions(stages_.light_probabilities->nodes, std::span(group.searches).first(reflecting));
  for (size_t i = 0; i < reflecting; ++i) {
    SurfaceDraws& sampled = group.members[group.reflecting[i]].sampled;
    sampled.draws = group.draws[i];
    sampled.light_probabilities =
        stages_.light_probabilities ? &stages_.light_probabilities->probabilities[group.searches[i].at] : nullptr;
  }
  return reflecting;
}

// Draws the numbers of the reflection samples that the first surfaces of a group may have.
void PathIntegrator::draw_reflections(size_t first, size_t reflecting, PathContext& context) const {
  const auto count = static_cast<uint32_t>(stages_.settings.reflection_samples);
  if (count == 0) return;
  ShadeGroup& group = context.group;
  size_t drawn = 0;
  for (size_t i = 0; i < reflecting; ++i) {
    const PathInFlight path = context.path_at(context.active[first + group.reflecting[i]]);
    if (path.state.bounce > 0) continue;
    group.members[group.reflecting[i]].sampled.reflections = &group.reflection_draws[drawn];
    for (uint32_t number = 0; number < count; ++number)
      group.reflection_addresses[drawn++] = PathStages::reflection_address(path, number, count);
  }
  draw_lights(std::span(group.reflection_addresses).first(drawn), std::span(group.reflection_draws).first(drawn));
}

// Samples lights for every vertex of a group that reflects, except where it would be in vain.
void PathIntegrator::sample_lights(size_t first, size_t count, PathContext& context) const {
  ShadeGroup& group = context.group;
  const size_t reflecting_count = draw_for_group(first, count, context);
  draw_reflections(first, reflecting_count, context);
  std::array<uint16_t, ShadeGroup::kMaxLights> several; // numbers of queries with draws of their own
  size_t query_count = 0, several_count = 0;
  for (size_t i = 0; i < reflecting_count; ++i) {
    const size_t number_in_batch = first + group.reflecting[i];
    ShadeGroup::Member& member = group.members[group.reflecting[i]];
    const PathInFlight path = context.path_at(context.active[number_in_batch]);
    const LightQuery query =
        stages_.light_query(member.surface, context.rays[number_in_batch].time, member.sampled, path);
    member.first_light = static_cast<uint32_t>(query_count);
    member.light_count = 0;
    if (!stages_.samples_light(member.surface)) continue;
    member.light_count = stages_.light_sample_count(path.state);
    for (uint32_t number = 0; number < member.light_count; ++number) {
      group.queries[query_count + number] = query;
      if (member.light_count == 1) continue;
      group.light_addresses[several_count] = {light_sample_address(path.sample.address, number, member.light_count),
                                              group.addresses[i].dimension};
      several[several_count++] = static_cast<uint16_t>(query_count + number);
    }
    query_count += member.light_count;
  }
  draw_lights(std::span(group.light_addresses).first(several_count), std::span(group.light_draws).first(several_count));
  for (size_t i = 0; i < several_count; ++i) {
    LightQuery& query = group.queries[several[i]];
    query = PathStages::light_query(query, group.light_draws[i]);
  }
  world_.lights.sample(std::span(group.queries).first(query_count), group.lights);
}

void PathIntegrator::trace_shadows(PathContext& context, bool first_surfaces) const {
  const size_t count = context.shadow_rays.size();
  if (count == 0) return;
  context.occluded.resize(count);
  if (first_surfaces && stages_.settings.max_shadow_rays() > 1)
    context.shadow_queries.trace(*accelerator_, context.shadow_rays, context.occluded);
  else
    accelerator_->occluded(context.shadow_rays, context.occluded);
  context.counters.shadow += count;
  if (world_.has_thin_walls) tint_shadows(context);
  if (context.split_light) split_shadows(context);
  for (size_t i = 0; i < count; ++i) {
    if (context.occluded[i]) continue;
    if (context.recorder) context.recorder->accept_light(i);
    const ShadowRecord& record = context.shadow_records[i];
    if (record.light_class == kReusedLight)
      context.reuse->paths[record.slot].light = record.contribution;
    else
      PathStages::add_light(record, context.states[record.slot]);
  }
}

// Traces unoccluded shadow rays from thin wall to thin wall, all of them together. Hits come in
// order along a ray, so the product of transmittances does not depend on batching.
void PathIntegrator::tint_shadows(PathContext& context) const {
  context.thin_wall_rays.clear();
  context.thin_wall_records.clear();
  for (size_t i = 0; i < context.shadow_rays.size(); ++i) {
    if (context.occluded[i]) continue;
    append_reserved(context.thin_wall_rays, context.shadow_rays[i]);
    context.thin_wall_rays.back().flags = kHitThinWalls;
    append_reserved(context.thin_wall_records, static_cast<uint32_t>(i));
  }
  SurfacePoint& scratch = context.group.members[0].surface; // free: shading of the batch has ended
  for (uint32_t thin_wall = 0; thin_wall < kMaxTransparentSurfaces && !context.thin_wall_rays.empty(); ++thin_wall) {
    context.thin_wall_hits.resize(context.thin_wall_rays.size());
    accelerator_->intersect(context.thin_wall_rays, context.thin_wall_hits);
    context.counters.shadow += context.thin_wall_rays.size();
    size_t remaining = 0;
    for (size_t i = 0; i < context.thin_wall_rays.size(); ++i) {
      const accel::Hit& hit = context.thin_wall_hits[i];
      if (!hit.is_hit()) continue;
      accel::Ray ray = context.thin_wall_rays[i];
      const uint32_t number = context.thin_wall_records[i];
      const PathStages::ThinWall wall =
          stages_.pass_thin_wall(hit, ray, scratch, context.shadow_records[number].contribution);
      if (wall == PathStages::ThinWall::blocks) context.occluded[number] = 1;
      if (wall != PathStages::ThinWall::passed) continue;
      context.thin_wall_rays[remaining] = ray;
      context.thin_wall_records[remaining] = number;
      ++remaining;
    }
    context.thin_wall_rays.resize(remaining);
    context.thin_wall_records.resize(remaining);
  }
  for (const uint32_t number : context.thin_wall_records) context.occluded[number] = 1; // behind too many thin walls
}

} // namespace kindling
