// Light that paths share between pixels, split by light group and first event.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/path_reuse.h"

#include <cassert>
#include <utility>

namespace kindling {

void PathIntegrator::take_tails(size_t path_count, PathContext& context) const {
  SplitLight& split = *context.split_light;
  for (size_t slot = 0; slot < path_count; ++slot) {
    if (!context.reuse->paths[slot].gives) continue;
    for (size_t group = 0; group < split.group_count; ++group)
      split.tails[slot * split.group_count + group] =
          std::exchange(split.groups[slot * split.group_count + group][kIndirect], Rgb(0.0f));
    if (split.group_count == 0) split.tails[slot] = context.states[slot].light[kIndirect];
    for (size_t pass = 0; pass < static_cast<size_t>(LightPass::emit); ++pass)
      if (pass % 2 != 0) split.passes[slot][pass] = Rgb(0.0f);
  }
}

// The first event of light that another path has found is that of the direction to its second
// surface.
void PathIntegrator::split_shared(size_t path_count, PathContext& context) const {
  SplitLight& split = *context.split_light;
  const ReuseView view = context.reuse->view();
  const size_t groups = std::max<size_t>(split.group_count, 1);
  const auto add = [&](size_t slot, uint32_t giver, const FirstEvent& first, const Rgb& of_light, const Rgb& of_tail) {
    split.add(slot, split.second_groups[giver], kIndirect, first, LightPass::emit, of_light * view.paths[giver].light);
    for (size_t group = 0; group < groups; ++group)
      split.add(slot, static_cast<uint8_t>(group), kIndirect, first, LightPass::emit,
                of_tail * split.tails[giver * groups + group]);
  };
  for (uint32_t slot = 0; slot < path_count; ++slot) {
    const ReusedPath& path = view.paths[slot];
    if (!path.receives) continue;
    if (path.gives) add(slot, slot, split.firsts[slot], path.own_of_light, path.own_of_tail);
    const Frame frame = Frame::around(path.first.shading_normal);
    const SurfaceBsdf bsdf(path.first.bsdf, nullptr, frame.to_local(path.wo));
    for (uint32_t place = 0; place < view.count; ++place) {
      const ReuseLink& link = view.link(slot, place);
      if (!(link.density > 0.0f)) continue;
      const uint32_t giver = context.reuse->groups[slot][place];
      const V3f wi = direction_between(path.first, view.paths[giver].second);
      const FirstEvent first = place == 0 ? split.firsts[slot] : event_towards(bsdf, frame.to_local(wi), false);
      add(slot, giver, first, path.throughput * link.of_light, path.throughput * link.of_tail);
    }
  }
}

} // namespace kindling
