// Readable record of a path, filled only while one sample is replayed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/path_context.h"
#include "renderer/world/world.h"

#include <array>
#include <utility>

namespace kindling {

// trace_event() appends the vertex that `fill` describes. Without a replay it costs one predicted
// branch.
template <typename Fill>
[[gnu::noinline, gnu::cold]] void append_event(PathTrace& trace, const Fill& fill) {
  PathVertex vertex;
  fill(vertex);
  trace.push_back(std::move(vertex));
}
template <typename Fill>
[[gnu::always_inline]] inline void trace_event(ThreadContext& context, const Fill& fill) {
  if (context.trace) [[unlikely]]
    append_event(*context.trace, fill);
}

[[nodiscard]] inline std::array<int, 3> bounces_of(const PathState& state) {
  return {state.diffuse_bounces(), state.glossy_bounces, state.transmission_bounces};
}

inline void trace_surface(ThreadContext& context, const accel::Ray& ray, const accel::Hit& hit,
                          const SurfacePoint& surface, const World& world, const PathState& state) {
  trace_event(context, [&](PathVertex& vertex) {
    vertex.event = surface.unlit ? "unlit surface" : state.emission_only ? "surface after the last bounce" : "surface";
    vertex.bounce = state.bounce;
    vertex.position = surface.position;
    vertex.normal = surface.shading_normal;
    vertex.direction = ray.direction;
    vertex.distance = hit.t;
    vertex.instance = hit.instance;
    vertex.mesh = hit.mesh;
    vertex.triangle = hit.triangle;
    vertex.material = world.material_name(surface.material);
    vertex.throughput = state.throughput;
    vertex.radiance = state.light[0] + state.light[1] + state.light[2];
    vertex.bounces = bounces_of(state);
  });
}

} // namespace kindling
