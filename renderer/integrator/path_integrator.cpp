// The path tracer's stages between the first and last of a batch, which are in path_batch.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"

#include "renderer/guiding/guide.h"
#include "renderer/integrator/path_recorder.h"
#include "renderer/integrator/path_trace.h"
#include "renderer/integrator/sample_cone.h"
#include "renderer/sampling/mis.h"

#include <cassert>

namespace kindling {
namespace {

// Returns the key that stochastic transparency hashes for a ray. It differs for every bounce.
uint32_t ray_key(const CameraSample& sample, uint32_t dimension) { return hash_combine(sample.address.key, dimension); }

// These are templates because Vertex is private to PathIntegrator.
template <typename Vertex>
void record_light(const Vertex& vertex, const LightSample& light, const Rgb& contribution, PathRecorder& recorder) {
  recorder.offer_light({.position = vertex.surface.position,
                        .facing = static_cast<uint8_t>(facing_of(vertex.surface.geometric_normal)),
                        .kind = light.kind,
                        .moment = square(luminance(contribution)) * light.kind_probability,
                        .probability = light.kind_probability});
}

template <typename Vertex>
void record_reflection(const Vertex& vertex, const GuidedBsdf::Sample& scattered, PathRecorder& recorder) {
  GuideRecord record;
  record.position = vertex.surface.position;
  record.normal = vertex.surface.shading_normal;
  record.base = scattered.bsdf_pdf / scattered.pdf;
  record.replaced = vertex.bsdf.replaceable(scattered.bsdf_pdf, scattered.cosine) / scattered.pdf;
  record.allowed = vertex.bsdf.allowed() / scattered.pdf;
  recorder.reflect(vertex.slot, record);
}

} // namespace

PathIntegrator::PathIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                               const Sampler& sampler, const PixelFilter& filter, AovSet aovs, const Guide* guide)
    : settings_(settings), world_(world), camera_(camera), sampler_(sampler), filter_(filter),
      sample_width_(kindling::sample_width(sampler)), aovs_(aovs), guide_(guide) {}

std::unique_ptr<ThreadContext> PathIntegrator::make_context() const { return make_path_context(); }

std::unique_ptr<PathContext> PathIntegrator::make_path_context() const {
  assert(settings_.batch_size >= kBlockSize * kBlockSize);
  return std::make_unique<PathContext>(settings_.batch_size, aovs_.needs_surface() || aovs_.needs_components());
}

// All paths of a batch advance together, so that the accelerator receives streams of rays.
uint32_t PathIntegrator::render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& thread,
                                      Film& film) const {
  assert(dynamic_cast<PathContext*>(&thread));
  auto& context = static_cast<PathContext&>(thread);
  const uint32_t per_batch = samples_per_batch(block, settings_.batch_size);
  for (uint32_t done = 0; done < samples.count(); done += per_batch) {
    const uint32_t first = samples.first + done;
    const SampleRange batch{first, first + std::min(per_batch, samples.count() - done)};
    start_batch(block, batch, context);
    const size_t path_count = context.active.size();
    trace_camera_rays(block, batch, context);
    while (!context.active.empty() && !world_.abandoned()) {
      shade(context);
      trace_shadows(context);
      context.active.swap(context.next_active);
      context.rays.swap(context.next_rays);
      trace_bounces(context);
    }
    if (world_.abandoned()) return done;
    finish_batch(path_count, context, film);
  }
  return samples.count();
}

void PathIntegrator::trace_bounces(PathContext& context) const {
  if (context.rays.empty()) return;
  context.hits.resize(context.rays.size());
  world_.accelerator().intersect(context.rays, context.hits);
  context.counters.bounce += context.rays.size();
}

void PathIntegrator::shade(PathContext& context) const {
  context.shadow_rays.clear();
  context.shadow_records.clear();
  if (context.recorder) context.recorder->start_lights();
  context.next_active.clear();
  context.next_rays.clear();
  const size_t count = context.active.size();
  for (size_t first = 0; first < count; first += ShadeGroup::kSize) {
    const size_t end = std::min(first + ShadeGroup::kSize, count);
    prepare_group(first, end - first, context);
    sample_lights(first, end - first, context);
    for (size_t i = first; i < end; ++i) {
      ShadeGroup::Member& member = context.group.members[i - first];
      if (world_.lights.has_shapes) add_shapes(i, context);
      if (context.hits[i].is_hit())
        shade_hit(i, member, context);
      else
        shade_escaped(context.rays[i], member.escaped, context.active[i], context);
    }
  }
}

// Evaluates the surfaces that the paths of a group have hit. Memory is prefetched for the whole
// group, so that the cache misses of its hits overlap.
void PathIntegrator::prepare_group(size_t first, size_t count, PathContext& context) const {
  assert(count <= ShadeGroup::kSize && first + count <= context.hits.size());
  const std::span<const accel::Hit> hits(context.hits.data() + first, count);
  const std::span<const accel::Ray> rays(context.rays.data() + first, count);
  const std::span<RayFootprint> footprints = std::span(context.group.footprints).first(count);
  for (size_t i = 0; i < count; ++i) {
    if (!hits[i].is_hit()) {
      context.group.members[i].escaped = world_.lights.locate_in_environment(rays[i].direction);
      continue;
    }
    PathState& state = context.states[context.active[first + i]];
    const bool from_camera = state.cone.spread < 0.0f;
    if (from_camera) state.cone = sample_cone(camera_, rays[i].direction, sample_width_);
    state.cone.width_m = state.cone.width_at(hits[i].t);
    footprints[i] = {state.cone.width_m, state.bsdf_pdf == 0.0f};
    if (from_camera)
      footprints[i].width_m = first_footprint(camera_, rays[i], hits[i].t, state.cone.width_m, sample_width_);
  }
  world_.prefetch(rays, hits, footprints);
  for (size_t i = 0; i < count; ++i) {
    if (hits[i].is_hit()) world_.surface_at(rays[i], hits[i], context.group.members[i].surface, footprints[i]);
  }
}

// Samples one light for every vertex of a group that reflects.
void PathIntegrator::sample_lights(size_t first, size_t count, PathContext& context) const {
  ShadeGroup& group = context.group;
  size_t query_count = 0;
  for (size_t i = 0; i < count; ++i) {
    ShadeGroup::Member& member = group.members[i];
    const uint32_t slot = context.active[first + i];
    const PathState& state = context.states[slot];
    if (!context.hits[first + i].is_hit() || member.surface.unlit || state.emission_only) continue;
    const V3f normal = member.surface.light_normal();
    member.draws = draw_bounce(context.camera_samples[slot].address, state.dimension(kDirectionDimension));
    member.light_probabilities =
        guide_ && !guide_->light_probabilities.empty()
            ? &guide_->light_probabilities.find(member.surface.position, member.surface.geometric_normal)
            : nullptr;
    member.light = static_cast<uint32_t>(query_count);
    group.queries[query_count++] = {member.surface.position,    normal,
                                    member.draws.light,         member.draws.spare,
                                    member.light_probabilities, context.rays[first + i].time};
  }
  world_.lights.sample(std::span(group.queries).first(query_count), group.lights);
}

// Inlined at both calls, so that surfaces without layers get code of their own.
[[gnu::always_inline]] inline void PathIntegrator::scatter(const accel::Ray& ray, Vertex&& vertex,
                                                           PathContext& context) const {
  const SurfacePoint& surface = vertex.surface;
  const uint32_t slot = vertex.slot;
  const PathState& state = context.states[slot];
  const bool reflects = !state.emission_only;
  if (guide_ && !guide_->patches.empty()) vertex.bsdf.guide_to(guide_->patches, surface.position);
  if (context.recorder) vertex.bsdf.find_allowed();
  if (reflects) light_vertex(vertex, context);
  // A partly transparent surface emits and reflects in proportion to its coverage; then the path
  // either scatters from it or passes through.
  if ((surface.alpha < 1.0f || surface.has_thin_wall()) && passes_through(vertex, context)) {
    continue_through(ray, surface, slot, context);
    return;
  }
  if (state.bounce == 0 && !context.surfaces.empty()) record_surface(ray, surface, &vertex.bsdf.bsdf(), slot, context);
  if (reflects && sample_bounce(vertex, context)) context.next_active.push_back(slot);
}

void PathIntegrator::shade_hit(size_t i, ShadeGroup::Member& member, PathContext& context) const {
  const uint32_t slot = context.active[i];
  const accel::Ray& ray = context.rays[i];
  const accel::Hit& hit = context.hits[i];
  PathState& state = context.states[slot];
  SurfacePoint& surface = member.surface;
  if (state.in_medium && !travel_medium(i, context)) return;
  if (context.recorder) context.recorder->arrive(slot, state, &surface);
  trace_surface(context, ray, hit, surface, world_, state);
  if (!is_black(surface.emitted)) add_emission(ray, surface, state);
  if (surface.unlit || (state.emission_only && !surface.has_thin_wall())) {
    if (surface.alpha < 1.0f && passes_through(1.0f - surface.alpha, slot, context))
      continue_through(ray, surface, slot, context);
    else if (state.bounce == 0 && !context.surfaces.empty())
      record_surface(ray, surface, nullptr, slot, context);
    return;
  }
  if (surface.layered && surface.layers.boundary && !surface.layers.entering && state.in_medium &&
      context.media[slot].covered(surface.material)) {
    pass_boundary(surface, state, context.media[slot]);
    continue_through(ray, surface, slot, context);
    return;
  }
  if (settings_.caustics != Caustics::full) regularize(surface, state, context.camera_samples[slot].sample_index);
  if (surface.layered) {
    const Frame frame = Frame::with_tangent(surface.shading_normal, surface.layers.tangent);
    const LayersHere layers = resolve_layers(surface, frame, state, context.media[slot], member.draws.choice.x);
    scatter(ray,
            Vertex{surface, frame, GuidedBsdf(surface.bsdf, layers.parameters, frame, -ray.direction), slot, ray.time,
                   member, &layers},
            context);
  } else {
    const Frame frame = Frame::around(surface.shading_normal);
    scatter(ray,
            Vertex{surface, frame, GuidedBsdf(surface.bsdf, nullptr, frame, -ray.direction), slot, ray.time, member,
                   nullptr},
            context);
  }
}

void PathIntegrator::shade_escaped(const accel::Ray& ray, const Environment::Location& at, uint32_t slot,
                                   PathContext& context) const {
  PathState& state = context.states[slot];
  if (context.recorder) context.recorder->arrive(slot, state, nullptr);
  if (state.bounce == 0) {
    if (settings_.transparent_background) {
      state.alpha = 1.0f - (state.throughput.x + state.throughput.y + state.throughput.z) / 3.0f; // through thin walls
      return;
    }
    if (settings_.background) {
      state.light[kEmission] += state.throughput * *settings_.background;
      return;
    }
    if (!settings_.environment_visible) return;
  }
  Rgb radiance;
  if (state.bsdf_pdf > 0.0f) {
    const EnvironmentEval environment =
        world_.lights.environment_eval(state.previous_position, state.previous_normal, at, state.light_probabilities);
    radiance = environment.radiance * power_heuristic(state.bsdf_pdf, environment.pdf);
  } else {
    radiance = world_.lights.environment_radiance(at);
  }
  state.light[state.light_class(state.bounce)] += state.throughput * radiance;
  trace_event(context, [&](PathVertex& vertex) {
    vertex.event = "escaped";
    vertex.bounce = state.bounce;
    vertex.direction = ray.direction;
    vertex.throughput = state.throughput;
    vertex.radiance = state.light[0] + state.light[1] + state.light[2];
  });
}

void PathIntegrator::regularize(SurfacePoint& surface, const PathState& state, uint32_t sample_index) const {
  const bool after_diffuse = state.diffuse_bounces > 0;
  if (surface.layered)
    regularize_caustics(settings_.caustics, after_diffuse, state.widest_lobe, sample_index, surface.layers.thin_wall,
                        surface.bsdf, surface.layers.bsdf);
  else
    regularize_caustics(settings_.caustics, after_diffuse, state.widest_lobe, sample_index, surface.bsdf);
}

void PathIntegrator::add_emission(const accel::Ray& ray, const SurfacePoint& surface, PathState& state) const {
  float weight = 1.0f;
  if (state.bsdf_pdf > 0.0f && surface.emissive_triangle != accel::kNoId) {
    const float distance = (surface.position - state.previous_position).length();
    weight =
        power_heuristic(state.bsdf_pdf, world_.lights.pdf_triangle(surface.emissive_triangle, state.previous_position,
                                                                   state.previous_normal, ray.direction, distance,
                                                                   state.light_probabilities, ray.time));
  }
  state.light[state.light_class(state.bounce)] += state.throughput * surface.emitted * (surface.alpha * weight);
}

// Next-event estimation. The contribution is added to the path once the shadow rays of the whole
// batch are traced.
void PathIntegrator::light_vertex(const Vertex& vertex, PathContext& context) const {
  const SurfacePoint& surface = vertex.surface;
  const PathState& state = context.states[vertex.slot];
  const CameraSample& sample = context.camera_samples[vertex.slot];
  const uint32_t dimension = state.dimension(kLightDimension);
  const std::optional<LightSample>& light = context.group.lights[vertex.member.light];
  if (!light) return;
  assert(light->pdf > 0.0f);
  const float side = light->wi.dot(surface.geometric_normal);
  if (vertex.layers) {
    // Shading and geometric normal may disagree on whether the direction is reflected or
    // transmitted: it carries no light.
    if ((side > 0.0f) != (light->wi.dot(vertex.frame.normal) > 0.0f)) return;
  } else if (side <= 0.0f) {
    return;
  }
  const BsdfEval eval = vertex.bsdf.eval(light->wi);
  if (is_black(eval.value)) return;
  const float weight = light->delta ? 1.0f : power_heuristic(light->pdf, eval.pdf);
  Rgb contribution = state.throughput * eval.value * light->radiance * (surface.alpha * weight / light->pdf);
  if (vertex.layers) contribution *= transmittance_to_light(vertex, side, light->distance, context);
  context.shadow_rays.push_back(
      make_shadow_ray(surface, *light, ray_key(sample, dimension), sample.address.index, vertex.time));
  context.shadow_rays.back().flags = kPassThinWalls;
  if (context.recorder) record_light(vertex, *light, contribution, *context.recorder);
  context.shadow_records.push_back({contribution, vertex.slot, state.light_class(state.bounce + 1U)});
}

// Samples the next direction and makes its ray. False if the path ends here.
bool PathIntegrator::sample_bounce(const Vertex& vertex, PathContext& context) const {
  const SurfacePoint& surface = vertex.surface;
  PathState& state = context.states[vertex.slot];
  const CameraSample& sample = context.camera_samples[vertex.slot];
  const uint32_t dimension = state.dimension(kDirectionDimension);
  const std::optional<GuidedBsdf::Sample> scattered =
      vertex.bsdf.sample(vertex.member.draws.choice.y, vertex.member.draws.direction);
  if (!scattered) return false;
  const V3f wi = scattered->wi;
  assert(scattered->pdf >= 0.0f && std::abs(wi.length2() - 1.0f) < 1e-3f);
  const bool crosses = scattered->cosine < 0.0f;
  if ((wi.dot(surface.geometric_normal) < 0.0f) != crosses) return false;
  state.throughput *= scattered->weight;
  if (is_black(state.throughput)) return false;
  if (scattered->bsdf_pdf > 0.0f) state.guiding *= scattered->pdf / scattered->bsdf_pdf;
  if (context.recorder && scattered->pdf > 0.0f) record_reflection(vertex, *scattered, *context.recorder);

  // Russian roulette by the square root of the throughput spares paths that may still meet a bright
  // light.
  if (state.bounce >= settings_.roulette_start_bounce) {
    const float survival = std::min(1.0f, std::sqrt(max_component(state.throughput) * state.guiding));
    if (vertex.member.draws.roulette >= survival) return false;
    state.throughput /= survival;
  }

  state.emission_only = !count_bounce(scattered->lobe, state);
  if (settings_.caustics == Caustics::regularized) state.widest_lobe.add(scattered->lobe, surface.bsdf.roughness);
  state.cone = scattered_cone(state.cone, scattered->pdf);
  state.bsdf_pdf = scattered->pdf;
  state.previous_position = surface.position;
  state.previous_normal = surface.light_normal();
  state.light_probabilities = vertex.member.light_probabilities;
  state.transparent_surfaces = 0;
  if (crosses) cross_boundary(vertex, state, context.media[vertex.slot]);
  context.next_rays.push_back({.origin = offset_ray_origin(surface, wi),
                               .t_min = 0.0f,
                               .direction = wi,
                               .t_max = kInfinity,
                               .key = ray_key(sample, dimension),
                               .time = vertex.time,
                               .index = sample.address.index,
                               .flags = kHitPartlyTransparent});
  return true;
}

// Counts a bounce. True if the surface that it leads to may reflect in turn, within all limits.
bool PathIntegrator::count_bounce(Lobe lobe, PathState& state) const {
  ++state.bounce;
  bool within = true;
  switch (lobe) {
  case Lobe::diffuse: within &= ++state.diffuse_bounces <= settings_.max_diffuse_bounces; break;
  case Lobe::glossy: within &= ++state.glossy_bounces <= settings_.max_glossy_bounces; break;
  case Lobe::transmission: within &= ++state.transmission_bounces <= settings_.max_transmission_bounces; break;
  }
  within &= state.bounce - state.transmission_bounces <= settings_.max_bounces;
  return within;
}

void PathIntegrator::trace_shadows(PathContext& context) const {
  const size_t count = context.shadow_rays.size();
  if (count == 0) return;
  context.occluded.resize(count);
  world_.accelerator().occluded(context.shadow_rays, context.occluded);
  context.counters.shadow += count;
  if (world_.has_thin_walls) tint_shadows(context);
  for (size_t i = 0; i < count; ++i) {
    if (context.occluded[i]) continue;
    if (context.recorder) context.recorder->accept_light(i);
    const ShadowRecord& record = context.shadow_records[i];
    context.states[record.slot].light[record.light_class] += record.contribution;
  }
}
} // namespace kindling
