// The path tracer's loops over the links between the paths of a batch.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_reuse.h"

#include "renderer/integrator/append_reserved.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/path_trace.h"
#include "renderer/integrator/stages/split_reuse.h"

#include <algorithm>
#include <cassert>

namespace kindling {

static_assert(kReuseSide == kBlockSize);

PathReuse::PathReuse(size_t batch_size, uint32_t size)
    : group_size(size), paths(batch_size), groups(batch_size), links(batch_size * size) {
  blocks.reserve(batch_size);
  rays.reserve(batch_size * (size - 1));
  ray_links.reserve(rays.capacity());
  occluded.reserve(rays.capacity());
}

void PathReuse::start(size_t count) {
  for (ReusedPath& path : std::span(paths).first(count)) path.start();
}

void find_groups(std::span<const PixelRect> blocks, const SampleRange& samples, std::span<ReuseGroup> groups) {
  uint32_t first = 0;
  for (const PixelRect& block : blocks) {
    const auto width = static_cast<uint32_t>(block.width()), height = static_cast<uint32_t>(block.height());
    for (uint32_t sample = samples.first; sample < samples.end; ++sample, first += width * height) {
      std::array<uint32_t, kMaxPathReuse> differences; // of pixels, by place
      for (uint32_t place = 0; place < kMaxPathReuse; ++place)
        differences[place] = reuse_partner(0, reuse_pattern(block.min, sample), place);
      ReuseGroup* group = &groups[first];
      for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x, ++group) {
          for (uint32_t place = 0; place < kMaxPathReuse; ++place) { // all, in the lanes of vectors
            const uint32_t partner = (y * kReuseSide + x) ^ differences[place];
            const uint32_t partner_x = partner % kReuseSide, partner_y = partner / kReuseSide;
            const bool inside = (partner_x < width) & (partner_y < height);
            (*group)[place] = inside ? first + partner_y * width + partner_x : kNoPath;
          }
        }
      }
    }
  }
}

void PathIntegrator::share_paths(std::span<const PixelRect> blocks, const SampleRange& samples, size_t path_count,
                                 PathContext& context) const {
  PathReuse& reuse = *context.reuse;
  const ReuseView view = reuse.view();
  find_groups(blocks, samples, reuse.groups);
  reuse.rays.clear();
  reuse.ray_links.clear();
  if (context.split_light)
    for (uint32_t slot = 0; slot < path_count; ++slot)
      take_tail(context.split_light->view, view, slot, context.states[slot]);
  for (uint32_t slot = 0; slot < path_count; ++slot) view.start_sharing(slot, context.states[slot]);
  for (uint32_t slot = 0; slot < path_count; ++slot) {
    const uint32_t traced = view.link_paths(stages_, slot, reuse.groups[slot]);
    for (uint32_t place = 1; traced >> place != 0; ++place) {
      if ((traced >> place & 1U) == 0) continue;
      append_reserved(reuse.rays, view.link_ray(slot, reuse.groups[slot], place, context.camera_samples[slot]));
      append_reserved(reuse.ray_links, slot * reuse.group_size + place);
    }
  }
  reuse.occluded.resize(reuse.rays.size());
  if (!reuse.rays.empty()) accelerator_->occluded(reuse.rays, reuse.occluded);
  context.counters.shadow += reuse.rays.size();
  for (size_t i = 0; i < reuse.rays.size(); ++i)
    if (reuse.occluded[i]) reuse.links[reuse.ray_links[i]] = {};
  for (uint32_t slot = 0; slot < path_count; ++slot) view.share_light(slot, reuse.groups[slot]);
  for (uint32_t slot = 0; slot < path_count; ++slot) view.receive(slot, reuse.groups[slot], context.states[slot]);
  if (context.split_light)
    for (uint32_t slot = 0; slot < path_count; ++slot)
      split_received(context.split_light->view, view, slot, reuse.groups[slot]);
  trace_event(context, [&](PathVertex& vertex) {
    const PathState& state = context.states[context.traced_slot];
    vertex.event = kJoinedEvent;
    vertex.bounce = state.bounce;
    vertex.throughput = state.throughput;
    vertex.radiance = state.light[0] + state.light[1] + state.light[2];
    vertex.bounces = bounces_of(state);
  });
}

} // namespace kindling
