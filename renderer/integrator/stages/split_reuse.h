// Light that paths share between pixels, split by light group and first event.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/reuse_paths.h"
#include "renderer/integrator/stages/split_view.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace kindling {

// Moves the tail of a path that is shared out of its sums, before ReuseView::start_sharing().
inline void take_tail(const SplitView& split, const ReuseView& view, size_t slot, const PathState& state) {
  if (!view.paths[slot].gives) return;
  for (size_t group = 0; group < split.group_count; ++group)
    split.tails[slot * split.group_count + group] =
        std::exchange(split.by_group[slot * split.group_count + group][kIndirect], Rgb(0.0f));
  if (split.group_count == 0) split.tails[slot] = state.light[kIndirect];
  for (size_t pass = 0; pass < static_cast<size_t>(LightPass::emit); ++pass)
    if (pass % 2 != 0) split.by_pass[slot][pass] = Rgb(0.0f);
}

// Adds what a path receives, after ReuseView::share_light() of all. The first event of light that
// another path has found is that of the direction to its second surface.
inline void split_received(const SplitView& split, const ReuseView& view, size_t slot, const ReuseGroup& group) {
  const ReusedPath& path = view.paths[slot];
  if (!path.receives) return;
  const size_t groups = std::max<size_t>(split.group_count, 1);
  const auto add = [&](uint32_t giver, const FirstEvent& first, const Rgb& of_light, const Rgb& of_tail) {
    split.add(slot, split.second_groups[giver], kIndirect, first, LightPass::emit, of_light * view.paths[giver].light);
    for (size_t g = 0; g < groups; ++g)
      split.add(slot, static_cast<uint8_t>(g), kIndirect, first, LightPass::emit,
                of_tail * split.tails[giver * groups + g]);
  };
  if (path.gives) add(static_cast<uint32_t>(slot), split.firsts[slot], path.own_of_light, path.own_of_tail);
  const Frame frame = Frame::around(path.first.shading_normal);
  const SurfaceBsdf bsdf(path.first.bsdf, nullptr, frame.to_local(path.wo));
  for (uint32_t place = 0; place < view.count; ++place) {
    const ReuseLink& link = view.link(static_cast<uint32_t>(slot), place);
    if (!(link.density > 0.0f)) continue;
    const V3f wi = direction_between(path.first, view.paths[group[place]].second);
    const FirstEvent first = place == 0 ? split.firsts[slot] : event_towards(bsdf, frame.to_local(wi), false);
    add(group[place], first, path.throughput * link.of_light, path.throughput * link.of_tail);
  }
}

} // namespace kindling
