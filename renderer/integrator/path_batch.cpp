// A path tracer's batch: the blocks that share it, camera rays in, film samples out.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/caught_paths.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/path_recorder.h"
#include "renderer/integrator/path_trace.h"
#include "renderer/integrator/shadow_catchers.h"
#include "renderer/integrator/stages/prepare_path.h"

#include <algorithm>
#include <cassert>

namespace kindling {

namespace {

// The paths of a batch are those of its blocks, one block after the other.
size_t count_paths(const PixelRect& block, const SampleRange& samples) {
  return static_cast<size_t>(block.pixel_count()) * samples.count();
}
size_t count_paths(std::span<const PixelRect> blocks, const SampleRange& samples) {
  size_t count = 0;
  for (const PixelRect& block : blocks) count += count_paths(block, samples);
  return count;
}
bool contains(std::span<const PixelRect> blocks, const V2i& pixel) {
  return std::any_of(blocks.begin(), blocks.end(), [&](const PixelRect& block) {
    return block.contains({pixel, pixel + V2i(1)});
  });
}

} // namespace

// Blocks that have too few samples for a batch each share one: the fewer paths there are, the
// less of what they wait for overlaps.
void PathIntegrator::render_blocks(std::span<BlockWork> work, ThreadContext& thread, Film& film) const {
  assert(dynamic_cast<PathContext*>(&thread));
  auto& context = static_cast<PathContext&>(thread);
  while (!work.empty()) {
    const SampleRange samples = work.front().samples;
    context.blocks.clear();
    size_t paths = 0;
    for (const BlockWork& block : work) {
      paths += count_paths(followed_block(block.block, context), samples);
      if (paths > stages_.settings.batch_size || block.samples != samples || block.rates || block.counts_rays) break;
      context.blocks.push_back(block.block);
    }
    const std::span<BlockWork> together = work.first(std::max(context.blocks.size(), size_t{1}));
    if (together.size() == 1) {
      Integrator::render_blocks(together, context, film);
    } else {
      const bool rendered = render_batch(context.blocks, samples, context, film);
      for (BlockWork& block : together) block.added = rendered ? samples.count() : 0;
    }
    work = work.subspan(together.size());
  }
}

void PathIntegrator::start_batch(std::span<const PixelRect> blocks, const SampleRange& samples,
                                 PathContext& context) const {
  const size_t count = count_paths(blocks, samples);
  assert(count <= context.states.size());
  context.rays.resize(count);
  std::span<CameraSample> camera_samples(context.camera_samples);
  std::span<accel::Ray> rays(context.rays);
  for (const PixelRect& block : blocks) {
    generate_camera_rays(camera_, sampler_, filter_, block, samples, camera_samples, rays);
    camera_samples = camera_samples.subspan(count_paths(block, samples));
    rays = rays.subspan(count_paths(block, samples));
  }
  start_paths(count, context);
}

void PathIntegrator::start_listed(const PixelRect& block, PathContext& context) const {
  context.rays.resize(context.listed.size());
  generate_camera_rays(camera_, sampler_, filter_, block, context.listed, context.camera_samples, context.rays);
  start_paths(context.listed.size(), context);
}

void PathIntegrator::start_paths(size_t count, PathContext& context) const {
  context.active.resize(count);
  for (size_t slot = 0; slot < count; ++slot) {
    context.active[slot] = static_cast<uint32_t>(slot);
    context.states[slot] = PathState{};
    if (context.recorder) context.recorder->start_path(slot);
  }
  for (size_t slot = 0; context.split_light && slot < count; ++slot) context.split_light->view.start(slot);
  if (!context.surfaces.empty()) std::fill_n(context.surfaces.begin(), count, FilmSurface{});
  if (!context.first_hits.empty()) std::fill_n(context.first_hits.begin(), count, accel::Hit{});
  context.counters.paths += count;
  trace_event(context, [&](PathVertex& vertex) {
    vertex.event = "camera";
    vertex.position = context.rays[context.traced_slot].origin;
    vertex.direction = context.rays[context.traced_slot].direction;
  });
}

void PathIntegrator::trace_camera_rays(std::span<const PixelRect> blocks, const SampleRange& samples,
                                       PathContext& context) const {
  if (context.traces_parts) return trace_together(context);
  context.hits.resize(context.rays.size());
  size_t first = 0;
  for (const PixelRect& block : blocks) {
    const size_t count = count_paths(block, samples);
    intersect_camera_rays(*accelerator_, camera_, sampler_, filter_, block, samples,
                          std::span(context.rays).subspan(first, count), std::span(context.hits).subspan(first, count));
    first += count;
  }
  context.counters.camera += context.rays.size();
}

// Which samples a batch has depends on how levels are divided, so its groups must not matter.
void PathIntegrator::trace_together(PathContext& context) const {
  constexpr size_t kGroup = kBlockSize * kBlockSize;
  const size_t count = context.rays.size();
  context.hits.resize(count);
  const std::span<const accel::Ray> rays(context.rays);
  const std::span<accel::Hit> hits(context.hits);
  if (!accelerator_->coherent_equals_single()) {
    accelerator_->intersect(rays, hits);
  } else {
    for (size_t first = 0; first < count; first += kGroup) {
      const size_t some = std::min(kGroup, count - first);
      accelerator_->intersect_coherent(rays.subspan(first, some), hits.subspan(first, some));
    }
  }
  context.counters.camera += count;
}

// Camera rays and random numbers are those of the batch, so that where nothing shades a catcher
// both lights have the same bits.
void PathIntegrator::follow_caught(std::span<const PixelRect> blocks, const SampleRange& samples,
                                   PathContext& context) const {
  CaughtPaths& caught = *context.caught;
  caught.find(*catchers_, std::span(context.first_hits).first(count_paths(blocks, samples)));
  if (caught.slots.empty()) return;
  PathContext& unshaded = *caught.context;
  unshaded_->start_batch(blocks, samples, unshaded);
  unshaded_->trace_camera_rays(blocks, samples, unshaded);
  size_t count = 0;
  for (const uint32_t slot : caught.slots) { // in ascending order
    unshaded.active[count] = slot;
    unshaded.rays[count] = unshaded.rays[slot];
    unshaded.hits[count++] = unshaded.hits[slot];
  }
  unshaded.active.resize(count);
  unshaded.rays.resize(count);
  unshaded.hits.resize(count);
  unshaded_->follow(unshaded);
  for (const uint32_t slot : caught.slots) caught.light[slot].unshadowed = stages_.radiance_of(unshaded.states[slot]);
  unshaded.counters.paths = 0;      // the same ones
  unshaded.counters.camera = count; // those of other paths depend on how an image is divided
  context.counters.add(unshaded.counters);
  unshaded.counters = {};
}

// Slots of a block run sample by sample, so each pixel receives its samples in order.
void PathIntegrator::finish_batch(std::span<const PixelRect> blocks, size_t path_count, PathContext& context,
                                  Film& film) const {
  const bool cut = context.reuses(); // some pixels may be outside of the blocks
  for (size_t slot = 0; slot < path_count; ++slot) {
    PathState& state = context.states[slot];
    const CameraSample& camera_sample = context.camera_samples[slot];
    if (cut && !contains(blocks, camera_sample.pixel)) continue;
    const Rgb radiance = stages_.radiance_of(state);
    if (context.recorder) context.recorder->finish_path(slot, radiance);
    const CaughtLight* const caught = context.caught ? context.caught->light_of(slot, radiance) : nullptr;
    if (!is_finite(radiance) || (caught && !is_finite(caught->unshadowed))) {
      context.counters.add_non_finite(camera_sample.pixel, camera_sample.sample_index);
      continue;
    }
    FilmSample sample{radiance, state.alpha, camera_sample.filter_weight, camera_sample.sample_index};
    if (caught) {
      sample.radiance = Rgb(0.0f);
      sample.alpha = 0.0f;
      film.add_caught(camera_sample.pixel, *caught, camera_sample.filter_weight);
    }
    film.add(camera_sample.pixel, sample);
    if (context.indirect) {
      FilmSample indirect = sample;
      if (!caught) indirect.radiance = state.light[kIndirect];
      context.indirect->add(camera_sample.pixel, indirect);
    }
    if (context.split_light && !caught)
      context.split_light->view.add_to(film.view(), film.index_of(camera_sample.pixel), slot, sample, stages_.settings);
    if (context.surfaces.empty()) continue;
    FilmSurface& surface = context.surfaces[slot];
    surface.emission = caught ? Rgb(0.0f) : state.light[kEmission];
    surface.direct = caught ? Rgb(0.0f) : state.light[kDirect];
    film.add_surface(camera_sample.pixel, surface, camera_sample.filter_weight);
    if (!context.first_hits.empty()) first_hits_.add(camera_sample, context.first_hits[slot], film);
  }
}

} // namespace kindling
