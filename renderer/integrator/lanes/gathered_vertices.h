// Vertices of paths and their light samples in lanes, gathered from the structs of a group.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/base/lanes.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"
#include "renderer/integrator/path_context.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

// Up to eight vertices of a group.
struct VertexQueue {
  std::array<uint32_t, Lanes::kCount> numbers; // of the active paths
  std::array<ShadeGroup::Member*, Lanes::kCount> members;
  uint32_t count = 0;

  void add(size_t number, ShadeGroup::Member& member) {
    numbers[count] = static_cast<uint32_t>(number);
    members[count++] = &member;
  }
};

// The vertices of a queue, coordinate by coordinate, and where they come from. Lanes that are left
// over repeat the last one.
struct GatheredVertices {
  template <typename T>
  using Each = std::array<T, Lanes::kCount>;
  using Vectors = Imath::Vec3<Lanes>;

  Each<uint32_t> numbers; // of the active paths
  Each<ShadeGroup::Member*> members;
  Each<const accel::Ray*> rays;
  Each<PathState*> states;
  uint32_t count;
  uint32_t special; // a bit for each that is in a medium, partly covered, or guarded

  Vectors position, normal; // the geometric one
  Lanes position_error;
  FrameOf<Lanes> frame;
  BsdfParametersOf<Lanes> parameters;
  Vectors wo_world, wo; // wo is local
  Vectors throughput;
  Lanes spread, guiding; // of PathState
  LaneMask has_roulette;
  Lanes choice; // BounceDraws::choice.y
  Imath::Vec2<Lanes> direction_draws;
  Lanes roulette;

  GatheredVertices(const VertexQueue& queue, const PathStages& stages, PathContext& context);
  // Turns the frames of surfaces with layers to the tangents of these.
  void turn_to_tangents();
  // Gathers the layers of such surfaces, as far as LayeredBsdfOf<Lanes> reads them.
  [[nodiscard]] LayerParametersOf<Lanes> layers() const;
};

// One light sample of each vertex, coordinate by coordinate.
struct GatheredLights {
  Imath::Vec3<Lanes> wi, radiance;
  Lanes pdf;
  LaneMask is_environment, is_delta;
  uint32_t there = 0; // a bit for each vertex that has it
  Lanes distance;
  Imath::Vec3<Lanes> normal;

  // Gathers sample `number` of each.
  GatheredLights(const GatheredVertices& vertices, const ShadeGroup& group, uint32_t number);
  // Light of the environment, in the directions of reflection samples; its radiance and density are
  // set by the caller.
  GatheredLights(const Imath::Vec3<Lanes>& directions, uint32_t lanes)
      : wi(directions), is_environment(LaneMask{} == 0), is_delta{}, there(lanes), distance(kInfinity) {}
};

// The boundaries of glass at which vertices are.
struct GlassBoundaries {
  GatheredVertices::Each<PathStages::LayersHere> layers;
  Lanes eta; // LayerParameters::eta
  // The spread of the specular cones that arrive, below 0 where there are none, and the radians by
  // which normals within their width differ.
  Lanes spread, bend;
};

// The next directions of paths at glass.
struct GlassBounce {
  LaneMask found, reflects;
  Imath::Vec3<Lanes> wi, weight; // unit, in world space
  Lanes pdf;                     // 0: exact directions
  uint32_t light_samples;
  LaneMask narrow;           // light paths find what is scattered into such a direction
  uint32_t environment_left; // a bit for each: PathStages::leaves_environment()
};

// Shadow rays to one light sample of each vertex, and what they bring.
struct ShadowLanes {
  LaneRows rays; // the first halves
  LaneVectors contributions;
  uint32_t lit; // a bit for each vertex that has such a ray
};

} // namespace kindling
