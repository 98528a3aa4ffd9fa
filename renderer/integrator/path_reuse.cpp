// The path tracer's loops over the links between the paths of a batch.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_reuse.h"

#include "renderer/integrator/append_reserved.h"
#include "renderer/integrator/lanes/load_structs.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/path_trace.h"
#include "renderer/integrator/stages/split_reuse.h"

#include <algorithm>
#include <cassert>

namespace kindling {

static_assert(kReuseSide == kBlockSize);

PathReuse::PathReuse(size_t batch_size, uint32_t size)
    : group_size(size), paths(batch_size), groups(batch_size), places(batch_size) {
  blocks.reserve(batch_size);
  rays.reserve(batch_size * (size - 1));
  ray_links.reserve(rays.capacity());
  whole_groups.reserve(batch_size);
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

namespace {

// Finds each group once, and where its paths are in it.
void find_whole_groups(size_t path_count, PathReuse& reuse) {
  reuse.whole_groups.clear();
  for (uint32_t slot = 0; slot < path_count; ++slot) {
    const ReuseGroup& group = reuse.groups[slot];
    if (!std::all_of(group.begin(), group.end(), [slot](uint32_t other) { return other >= slot; })) continue;
    for (uint32_t lane = 0; lane < kMaxPathReuse; ++lane)
      if (group[lane] != kNoPath)
        reuse.places[group[lane]] = static_cast<uint32_t>(reuse.whole_groups.size()) * kMaxPathReuse + lane;
    append_reserved(reuse.whole_groups, group);
  }
  const size_t size = std::max(reuse.group_links.size(), reuse.whole_groups.size());
  reuse.group_links.resize(size);
  reuse.group_rays.resize(size);
}

// Links the paths of all groups, and lets them share light once `trace` has traced PathReuse::rays.
template <typename Trace>
void share_in_lanes(const PathStages& stages, size_t path_count, PathContext& context, const Trace& trace) {
  PathReuse& reuse = *context.reuse;
  const ReuseView view = reuse.view();
  find_whole_groups(path_count, reuse);
  for (uint32_t slot = 0; slot < path_count; ++slot) view.start_sharing(slot, context.states[slot]);
  for (size_t number = 0; number < reuse.whole_groups.size(); ++number)
    link_group(stages, view, reuse.whole_groups[number], reuse.group_links[number], reuse.group_rays[number]);
  // Pixel by pixel: rays of neighbors are traced well together.
  for (uint32_t slot = 0; slot < path_count; ++slot) {
    const uint32_t lane = reuse.places[slot] % kMaxPathReuse, number = reuse.places[slot] / kMaxPathReuse;
    const LinkRays& rays = reuse.group_rays[number];
    const CameraSample& sample = context.camera_samples[slot];
    for (uint32_t place = 1; place < view.count; ++place) {
      if ((rays.traced[place] >> lane & 1U) == 0) continue;
      append_reserved(reuse.rays,
                      ray_of(rays.halves[place][lane], hash_combine(ray_key(sample, kReuseDimension), place), 0.0f,
                             sample.address.index, kHitPartlyTransparent));
      append_reserved(reuse.ray_links, (number * kMaxPathReuse + place) * kMaxPathReuse + lane);
    }
  }
  trace();
  for (size_t i = 0; i < reuse.rays.size(); ++i) {
    if (!reuse.occluded[i]) continue;
    const uint32_t link = reuse.ray_links[i], place = link / kMaxPathReuse;
    reuse.group_links[place / kMaxPathReuse][place % kMaxPathReuse].density[link % kMaxPathReuse] = 0.0f;
  }
  for (size_t number = 0; number < reuse.whole_groups.size(); ++number)
    share_group(view, reuse.whole_groups[number], reuse.group_links[number], context.states.data());
}

// The same path by path, where light is split into groups and passes.
template <typename Trace>
void share_split(const PathStages& stages, size_t path_count, PathContext& context, const Trace& trace) {
  PathReuse& reuse = *context.reuse;
  reuse.links.resize(reuse.paths.size() * reuse.group_size);
  const ReuseView view = reuse.view();
  for (uint32_t slot = 0; slot < path_count; ++slot) {
    take_tail(context.split_light->view, view, slot, context.states[slot]);
    view.start_sharing(slot, context.states[slot]);
  }
  for (uint32_t slot = 0; slot < path_count; ++slot) {
    const uint32_t traced = view.link_paths(stages, slot, reuse.groups[slot]);
    for (uint32_t place = 1; traced >> place != 0; ++place) {
      if ((traced >> place & 1U) == 0) continue;
      append_reserved(reuse.rays, view.link_ray(slot, reuse.groups[slot], place, context.camera_samples[slot]));
      append_reserved(reuse.ray_links, slot * reuse.group_size + place);
    }
  }
  trace();
  for (size_t i = 0; i < reuse.rays.size(); ++i)
    if (reuse.occluded[i]) reuse.links[reuse.ray_links[i]] = {};
  for (uint32_t slot = 0; slot < path_count; ++slot) view.share_light(slot, reuse.groups[slot]);
  for (uint32_t slot = 0; slot < path_count; ++slot) view.receive(slot, reuse.groups[slot], context.states[slot]);
  for (uint32_t slot = 0; slot < path_count; ++slot)
    split_received(context.split_light->view, view, slot, reuse.groups[slot]);
}

} // namespace

void PathIntegrator::share_paths(std::span<const PixelRect> blocks, const SampleRange& samples, size_t path_count,
                                 PathContext& context) const {
  PathReuse& reuse = *context.reuse;
  find_groups(blocks, samples, reuse.groups);
  reuse.rays.clear();
  reuse.ray_links.clear();
  const auto trace = [&] {
    reuse.occluded.resize(reuse.rays.size());
    if (!reuse.rays.empty()) accelerator_->occluded(reuse.rays, reuse.occluded);
    context.counters.shadow += reuse.rays.size();
  };
  if (context.split_light)
    share_split(stages_, path_count, context, trace);
  else
    share_in_lanes(stages_, path_count, context, trace);
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
