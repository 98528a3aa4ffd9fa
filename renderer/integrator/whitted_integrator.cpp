// Traversal of the Whitted tracer's ray trees, by recursion or with a work list.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_integrator.h"

#include "renderer/integrator/path_trace.h"

#include <cassert>

namespace kindling {

// Receives the results of shading; the part that both forms share.
struct WhittedIntegrator::Sink {
  const WhittedIntegrator& integrator;
  WhittedContext& context;

  void add(const WhittedNode& node, WhittedPart part, const Rgb& radiance) {
    add(node.slot, node.seen, part, radiance);
  }
  void add(uint32_t slot, bool seen, WhittedPart part, const Rgb& radiance) {
    context.samples[slot].radiance.add(radiance);
    if (context.components.empty() || !seen) return;
    if (part == WhittedPart::emission) context.components[slot].emission.add(radiance);
    if (part == WhittedPart::direct) context.components[slot].direct.add(radiance);
  }
  void surface(const WhittedNode& node, const WhittedVertex& vertex) {
    if (context.surfaces.empty()) return;
    const SurfacePoint& point = vertex.surface;
    FilmSurface& record = context.surfaces[node.slot];
    if (record.hit) return;
    record.hit = true;
    record.albedo = point.unlit ? point.emitted : vertex.bsdf().albedo();
    record.normal = point.shading_normal;
    record.depth = integrator.camera_.depth(point.position, node.ray.time);
    record.position = point.position;
  }
};

struct WhittedIntegrator::RecursiveSink : Sink {
  void feel(const WhittedNode& node, const accel::Ray& feeler, const Rgb& contribution) {
    ++context.counters.shadow;
    if (integrator.world_.accelerator().occluded(feeler)) return;
    const Rgb through =
        integrator.world_.has_thin_walls ? integrator.shader_.through_thin_walls(feeler, context.counters) : Rgb(1.0f);
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
                                     const Sampler& sampler, const PixelFilter& filter, AovSet aovs)
    : settings_(settings), world_(world), camera_(camera), sampler_(sampler), filter_(filter),
      sample_width_(kindling::sample_width(sampler)), aovs_(aovs), shader_(settings, world) {}

std::unique_ptr<ThreadContext> WhittedIntegrator::make_context() const {
  return std::make_unique<WhittedContext>(settings_.batch_size, aovs_.needs_surface() || aovs_.needs_components());
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
        WhittedNode node = root(slot, context);
        trace_recursively(node, context);
      }
    } else {
      context.waiting.clear();
      for (size_t slot = count; slot-- > 0;) context.waiting.push_back(root(slot, context));
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
  context.counters.paths += count;
  context.counters.camera += count;
}

WhittedNode WhittedIntegrator::root(size_t slot, const WhittedContext& context) const {
  WhittedNode node;
  node.ray = context.camera_rays[slot];
  node.slot = static_cast<uint32_t>(slot);
  node.cone = sample_cone(camera_, node.ray.direction, sample_width_);
  return node;
}

bool WhittedIntegrator::arrive(WhittedNode& node, const accel::Hit& hit, WhittedContext& context) const {
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
  if (world_.lights.has_shapes && !node.seen) add_shapes(node, hit, context);
  if (!hit.is_hit()) {
    if (node.seen && settings_.transparent_background) {
      const Rgb& w = node.weight;
      context.samples[node.slot].transparency.add((w.x + w.y + w.z) * (1.0f / 3.0f));
    } else {
      const Rgb radiance = shader_.escaped(node);
      if (!is_black(radiance)) Sink{*this, context}.add(node, WhittedPart::emission, node.weight * radiance);
    }
    return false;
  }
  if (node.in_medium) node.weight *= medium_transmittance(world_, node.media, hit.t);
  return !is_black(node.weight);
}

void WhittedIntegrator::add_shapes(const WhittedNode& node, const accel::Hit& hit, WhittedContext& context) const {
  ShapeRay stretch{.origin = node.ray.origin,
                   .normal = V3f(0.0f),
                   .direction = node.ray.direction,
                   .end_m = hit.is_hit() ? hit.t : kInfinity,
                   .time = node.ray.time};
  if (node.in_medium) stretch.extinction = world_.medium(*node.media.innermost()).extinction;
  const Rgb radiance = world_.lights.shape_radiance(stretch);
  if (!is_black(radiance)) Sink{*this, context}.add(node, WhittedPart::indirect, node.weight * radiance);
}

RayFootprint WhittedIntegrator::footprint_of(const WhittedNode& node, const accel::Hit& hit) const {
  return {.width_m = node.cone.width_at(hit.t), .filters_emission = true};
}

void WhittedIntegrator::trace_recursively(WhittedNode& node, WhittedContext& context) const {
  if (!node.seen || node.transparent_surfaces > 0) ++context.counters.bounce;
  const accel::Hit hit = world_.accelerator().intersect(node.ray);
  if (!arrive(node, hit, context)) return;
  SurfacePoint surface;
  world_.surface_at(node.ray, hit, surface, footprint_of(node, hit));
  RecursiveSink sink{{*this, context}};
  shader_.shade(node, hit, surface, context.counters, sink);
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
    for (size_t i = 0; i < size; ++i) footprints[i] = footprint_of(context.nodes[first + i], hits[first + i]);
    world_.prefetch(rays.subspan(first, size), hits.subspan(first, size), std::span(footprints).first(size));
    for (size_t i = first; i < first + size; ++i) {
      WhittedNode& node = context.nodes[i];
      if (!node.seen || node.transparent_surfaces > 0) ++context.counters.bounce;
      if (!arrive(node, hits[i], context)) continue;
      SurfacePoint surface;
      world_.surface_at(rays[i], hits[i], surface, footprints[i - first]);
      shader_.shade(node, hits[i], surface, context.counters, sink);
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
    const Rgb through =
        world_.has_thin_walls ? shader_.through_thin_walls(context.feeler_rays[i], context.counters) : Rgb(1.0f);
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
  }
}

} // namespace kindling
