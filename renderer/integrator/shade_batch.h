// The path tracer's loop over the hits of a group of paths, for one kind of sink.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/lanes/vertex_lanes.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/stages/shade_path.h"

namespace kindling {

// Shades the active paths [first, end), which are at most ShadeGroup::kSize.
template <typename Sink>
inline void PathIntegrator::shade_group(size_t first, size_t end, PathContext& context, Sink& sink) const {
  prepare_group(first, end - first, context);
  sample_lights(first, end - first, context);
  VertexLanes lanes(stages_, context, sink);
  for (size_t i = first; i < end; ++i) {
    ShadeGroup::Member& member = context.group.members[i - first];
    const PathInFlight path = context.path_at(context.active[i]);
    const accel::Ray& ray = context.rays[i];
    const accel::Hit& hit = context.hits[i];
    if (world_.lights.has_shapes) {
      stages_.add_shapes(ray, hit, path, sink);
      if constexpr (Sink::kSplits) sink.split_shapes(stages_, ray, hit, path);
    }
    if (member.scattered)
      stages_.scatter_in_medium(ray, *member.scattered, path, sink);
    else if (!hit.is_hit())
      stages_.shade_escaped(ray, member.in_environment, path, sink);
    else if (stages_.reach_surface(ray, hit, member.surface, path, sink))
      lanes.take(i, member);
  }
  lanes.finish();
}

} // namespace kindling
