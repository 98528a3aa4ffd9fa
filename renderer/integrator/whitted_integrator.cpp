// Traversal of the Whitted tracer's ray trees, by recursion or with a work list.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_integrator.h"

#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/path_trace.h"
#include "renderer/integrator/whitted_context.h"

#include <cassert>

namespace kindling {

// Receives the results of shading; the part that both forms share.
struct WhittedIntegrator::Sink {
  const WhittedIntegrator& integrator;
  WhittedContext& context;
  const accel::Hit* hit = nullptr; // at the node that is shaded

  void add(const WhittedNode& node, WhittedPart part, const Rgb& radiance) {
    add(node.slot, node.seen, part, radiance);
  }
  void add(uint32_t slot, bool seen, WhittedPart part, const Rgb& radiance) {
    context.samples[slot].radiance.add(radiance);
    if (context.components.empty() || !seen) return;
    if (part == WhittedPart::emission) context.components[slot].emission.add(radiance);
    if (part == WhittedPart::direct) context.components[slot].direct.add(radiance);
  }
  void add_transparency(const WhittedNode& node, float part) { context.samples[node.slot].transparency.add(part); }
  [[nodiscard]] WhittedCounters& counters() { return context.counters.whitted; }
  void surface(const WhittedNode& node, const WhittedVertex& vertex) {
    if (context.surfaces.empty() || context.surfaces[node.slot].hit) return;
    integrator.shader_.record_surface(vertex, context.surfaces[node.slot]);
    if (!context.first_hits.empty()) context.first_hits[node.slot] = *hit;
  }
};

struct WhittedIntegrator::RecursiveSink : Sink {
  void feel(const WhittedNode& node, const accel::Ray& feeler, const Rgb& contribution) {
    ++context.counters.shadow;
    if (integrator.world_.accelerator().occluded(feeler)) return;
    const Rgb through = integrator.world_.has_thin_walls ? integrator.through_thin_walls(feeler, context) : Rgb(1.0f);
    add(node, WhittedPart::direct, contribution * through);
  }
  void follow(WhittedNode&& node) { integrator.trace_recursively(node, context); }
};

struct WhittedIntegrator::IterativeSink : Sink {
  void feel(const WhittedNode& node, const accel::Ray& feeler, const Rgb& contribution) {
    context.feelers.push_back({contribution, node.slot, node.seen});
    context.feeler_rays.push_back(feeler);
    if (context.feelers.size() >= WhittedContext::kFeelerBatch) integrator.trace_feelers(context);
  }
  void follow(WhittedNode&& node) { context.waiting.push_back(node); }
};

WhittedIntegrator::WhittedIntegrator(const IntegratorSettings& settings, const World& world, const Camera& camera,
                                     const Sampler& sampler, const PixelFilter& filter, AovSet aovs,
                                     const AovInputs& inputs)
    : settings_(settings), world_(world), camera_(camera), sampler_(sampler), filter_(filter), aovs_(aovs),
      first_hits_(world, camera, filter_, aovs, inputs), lights_(world.light_set()),
      cache_(settings.whitted.cache ? std::make_unique<WhittedCache>(world.materials.size()) : nullptr),
      shader_(make_whitted_shader(settings, world, camera, sampler, lights_)) {
  shader_.cache = cache_.get();
}

std::unique_ptr<ThreadContext> WhittedIntegrator::make_context() const {
  return std::make_unique<WhittedContext>(settings_.batch_size, aovs_);
}

uint32_t WhittedIntegrator::render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& thread,
                                         Film& film) const {
  assert(dynamic_cast<WhittedContext*>(&thread));
  auto& context = static_cast<WhittedContext&>(thread);
  const uint32_t per_batch = samples_per_batch(block, settings_.batch_size);
  for (uint32_t done = 0; done < samples.count(); done += per_batch) {
    const uint32_t first = samples.first + done;
    const SampleRange batch{first, first + std::min(per_batch, samples.count() - done)};
    const size_t count = static_cast<size_t>(block.pixel_count()) * batch.count();
    start_batch(block, batch, count, context);
    if (settings_.whitted.form == WhittedForm::recursive) {
      for (size_t slot = 0; slot < count && !world_.abandoned(); ++slot) {
        WhittedNode node = shader_.root(context.camera_rays[slot], static_cast<uint32_t>(slot));
        trace_recursively(node, context);
      }
    } else {
      context.waiting.clear();
      for (size_t slot = count; slot-- > 0;)
        context.waiting.push_back(shader_.root(context.camera_rays[slot], static_cast<uint32_t>(slot)));
      trace_iteratively(context);
    }
    if (world_.abandoned()) return done;
    finish_batch(count, context, film);
  }
  return samples.count();
}

void WhittedIntegrator::start_batch(const PixelRect& block, const SampleRange& samples, size_t count,
                                    WhittedContext& context) const {
  assert(count <= context.samples.size());
  generate_camera_rays(camera_, sampler_, filter_, block, samples, context.camera_samples,
                       std::span(context.camera_rays).first(count));
  std::fill_n(context.samples.begin(), count, WhittedSample{});
  if (!context.components.empty()) std::fill_n(context.components.begin(), count, WhittedComponents{});
  if (!context.surfaces.empty()) std::fill_n(context.surfaces.begin(), count, FilmSurface{});
  if (!context.first_hits.empty()) std::fill_n(context.first_hits.begin(), count, accel::Hit{});
  context.counters.paths += count;
  context.counters.camera += count;
}

namespace {

void trace_node(WhittedContext& context, const WhittedNode& node, const accel::Hit& hit) {
  trace_event(context, [&](PathVertex& vertex) {
    vertex.event = !hit.is_hit() ? "escaped" : node.seen ? "surface" : "surface below";
    vertex.bounce = node.depth - 1;
    vertex.position = node.ray.origin + node.ray.direction * (hit.is_hit() ? hit.t : 0.0f);
    vertex.direction = node.ray.direction;
    vertex.distance = hit.t;
    vertex.instance = hit.instance;
    vertex.mesh = hit.mesh;
    vertex.triangle = hit.triangle;
    vertex.throughput = node.weight;
    vertex.radiance = context.samples[node.slot].radiance.value();
  });
}

} // namespace

Rgb WhittedIntegrator::through_thin_walls(const accel::Ray& feeler, WhittedContext& context) const {
  return shader_.through_thin_walls(feeler, [&](const accel::Ray& ray) {
    ++context.counters.shadow;
    return world_.accelerator().intersect(ray);
  });
}

void WhittedIntegrator::trace_recursively(WhittedNode& node, WhittedContext& context) const {
  if (!node.seen || node.transparent_surfaces > 0) ++context.counters.bounce;
  const accel::Hit hit = world_.accelerator().intersect(node.ray);
  RecursiveSink sink{{*this, context, &hit}};
  trace_node(context, node, hit);
  if (!shader_.arrive(node, hit, sink)) return;
  SurfacePoint surface;
  world_.surface_at(node.ray, hit, surface, WhittedShader::footprint_of(node, hit));
  shader_.shade(node, hit, surface, sink);
}

// The newest nodes are traced first, as many as a batch holds. So the list holds no more than the
// tree's depth times the nodes that one batch can add.
void WhittedIntegrator::trace_iteratively(WhittedContext& context) const {
  while (!context.waiting.empty() && !world_.abandoned()) {
    const size_t count = std::min(context.waiting.size(), static_cast<size_t>(settings_.batch_size));
    const size_t first = context.waiting.size() - count;
    for (size_t i = 0; i < count; ++i) {
      context.nodes[i] = context.waiting[first + i];
      context.rays[i] = context.nodes[i].ray;
    }
    context.waiting.resize(first);
    trace_batch(count, context);
    trace_feelers(context);
  }
}

void WhittedIntegrator::trace_batch(size_t count, WhittedContext& context) const {
  assert(count <= context.nodes.size());
  const std::span<accel::Ray> rays = std::span(context.rays).first(count);
  const std::span<accel::Hit> hits = std::span(context.hits).first(count);
  world_.accelerator().intersect(rays, hits);
  IterativeSink sink{{*this, context}};
  // Memory is prefetched for a whole group, so that the cache misses of its hits overlap.
  std::array<RayFootprint, ShadeGroup::kSize> footprints;
  for (size_t first = 0; first < count; first += ShadeGroup::kSize) {
    const size_t size = std::min(ShadeGroup::kSize, count - first);
    for (size_t i = 0; i < size; ++i)
      footprints[i] = WhittedShader::footprint_of(context.nodes[first + i], hits[first + i]);
    world_.prefetch(rays.subspan(first, size), hits.subspan(first, size), std::span(footprints).first(size));
    for (size_t i = first; i < first + size; ++i) {
      WhittedNode& node = context.nodes[i];
      if (!node.seen || node.transparent_surfaces > 0) ++context.counters.bounce;
      trace_node(context, node, hits[i]);
      if (!shader_.arrive(node, hits[i], sink)) continue;
      sink.hit = &hits[i];
      SurfacePoint surface;
      world_.surface_at(rays[i], hits[i], surface, footprints[i - first]);
      shader_.shade(node, hits[i], surface, sink);
    }
  }
}

void WhittedIntegrator::trace_feelers(WhittedContext& context) const {
  const size_t count = context.feelers.size();
  if (count == 0) return;
  context.occluded.resize(count);
  world_.accelerator().occluded(context.feeler_rays, context.occluded);
  context.counters.shadow += count;
  Sink sink{*this, context};
  for (size_t i = 0; i < count; ++i) {
    if (context.occluded[i]) continue;
    const WhittedFeeler& feeler = context.feelers[i];
    const Rgb through = world_.has_thin_walls ? through_thin_walls(context.feeler_rays[i], context) : Rgb(1.0f);
    sink.add(feeler.slot, feeler.seen, WhittedPart::direct, feeler.contribution * through);
  }
  context.feelers.clear();
  context.feeler_rays.clear();
}

// Slots run sample by sample, so each pixel receives its samples in order.
void WhittedIntegrator::finish_batch(size_t count, WhittedContext& context, Film& film) const {
  for (size_t slot = 0; slot < count; ++slot) {
    const WhittedSample& sample = context.samples[slot];
    const CameraSample& camera_sample = context.camera_samples[slot];
    const Rgb radiance = sample.radiance.value();
    if (!is_finite(radiance)) {
      context.counters.add_non_finite(camera_sample.pixel, camera_sample.sample_index);
      continue;
    }
    film.add(camera_sample.pixel,
             {radiance, 1.0f - sample.transparency.value(), camera_sample.filter_weight, camera_sample.sample_index});
    if (context.surfaces.empty()) continue;
    FilmSurface& surface = context.surfaces[slot];
    surface.emission = context.components[slot].emission.value();
    surface.direct = context.components[slot].direct.value();
    film.add_surface(camera_sample.pixel, surface, camera_sample.filter_weight);
    if (!context.first_hits.empty()) first_hits_.add(camera_sample, context.first_hits[slot], film);
  }
}

} // namespace kindling
