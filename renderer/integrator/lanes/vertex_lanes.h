// Shading of vertices eight at a time in lanes: opaque surfaces without films, and glass.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/bsdf/layered_bsdf.h"
#include "renderer/bsdf/rough_glass.h"
#include "renderer/integrator/lanes/gathered_vertices.h"
#include "renderer/integrator/lanes/guide_lanes.h"
#include "renderer/integrator/lanes/load_structs.h"
#include "renderer/integrator/stages/shade_path.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace kindling {

// Collects vertices while a group is shaded. Their BSDFs are set up and their next directions drawn
// in lanes; so are their light samples, where nothing but weights concerns them. All results have
// the bits of PathStages::scatter_at().
template <typename Sink>
class VertexLanes {
 public:
  // All are borrowed. `context` has the group.
  VertexLanes(const PathStages& stages, PathContext& context, Sink& sink)
      : stages_(stages), context_(context), sink_(sink), is_alone_(Sink::kSplits || sink.records()),
        lights_alone_(is_alone_ || stages.manifolds), prepares_(context.reuses() || stages.guides_directions()) {}

  // Takes the active path `number` of the batch, a `member` of the group that is scattered at its
  // surface.
  void take(size_t number, ShadeGroup::Member& member) {
    if (member.surface.layered && is_glass_in_lanes(number, member.surface) && take_glass(number, member)) return;
    const bool lambertian = is_lambertian(member.surface.bsdf);
    const bool layered = member.surface.layered;
    if (is_alone_ || (lights_alone_ && lambertian) || (layered && !are_layers_in_lanes(number, member.surface))) {
      shade_alone(static_cast<uint32_t>(number), member);
      return;
    }
    const uint32_t kind = (lambertian ? 2 : 0) + (context_.states[context_.active[number]].bounce == 0 ? 1 : 0);
    VertexQueue& queue = layered ? layered_[kind] : plain_[kind];
    queue.add(number, member);
    if (queue.count == Lanes::kCount) layered ? shade_layers(queue) : shade_plain(queue);
  }
  // Shades those that are left.
  void finish() {
    for (VertexQueue& queue : plain_) finish(queue, kMinEvalsTogether, &VertexLanes::shade_plain);
    for (VertexQueue& queue : layered_) finish(queue, kMinLayersTogether, &VertexLanes::shade_layers);
    finish(clear_glass_, kMinGlassTogether, &VertexLanes::shade_glass);
    for (VertexQueue& queue : rough_glass_) finish(queue, kMinGlassTogether, &VertexLanes::shade_rough_glass);
  }

 private:
  static constexpr uint32_t kMinGlassTogether = 2; // one by itself is shaded alone
  static constexpr uint32_t kMinLayersTogether = 2;
  static constexpr RayCone kNoSpecularCone{.spread = -1.0f};

  using Vectors = Imath::Vec3<Lanes>;
  using PlainBsdf = GltfBsdfOf<Lanes>;
  using LayersBsdf = LayeredBsdfOf<Lanes>;
  // Properties of the BSDFs that guides and path reuse depend on.
  struct Lobes {
    Lanes smooth, glossy, alpha;
  };

  void shade_alone(uint32_t number, ShadeGroup::Member& member) {
    const PathInFlight path = context_.path_at(context_.active[number]);
    stages_.scatter_at(context_.rays[number], context_.hits[number], member.surface, member.sampled,
                       context_.group.lights_of(member), path, sink_);
  }

  // Shades those of a queue, in lanes if there are enough of them.
  void finish(VertexQueue& queue, size_t min_count, void (VertexLanes::*shade_in_lanes)(VertexQueue&)) {
    if (queue.count >= min_count)
      (this->*shade_in_lanes)(queue);
    else
      shade_each_alone(queue);
  }

  void shade_each_alone(VertexQueue& queue) {
    for (uint32_t i = 0; i < queue.count; ++i) shade_alone(queue.numbers[i], *queue.members[i]);
    queue.count = 0;
  }

  // True if a first surface is to be recorded where the path of a slot is.
  [[nodiscard]] bool records_surface(uint32_t slot) const {
    return !context_.surfaces.empty() && (context_.states[slot].bounce == 0 || !context_.surfaces[slot].guide_found);
  }

  // True if what light paths find depends on the directions that the surface scatters light into.
  [[nodiscard]] bool is_caster(const SurfacePoint& surface) const {
    return stages_.light_paths && stages_.light_paths->is_caster(surface.material);
  }
  // Gathers the photons around a vertex, and notes what light paths find from there on.
  template <typename Bsdf>
  void join_light_paths(const GatheredVertices& v, uint32_t lane, const Bsdf& bsdf);
  // Returns narrow_share() of each BSDF for its local direction, given its density there.
  template <typename Bsdf>
  [[nodiscard]] static LaneNumbers narrow_shares(const Bsdf& bsdf, const Vectors& wi, const Lanes& pdf) {
    const Lanes share = bsdf.narrow_density(wi, pdf, LightPathView::kMaxNarrowAlpha) / pdf;
    LaneNumbers shares;
    shares.store(select(pdf > 0.0f, minimum(share, Lanes(1.0f)), Lanes(0.0f)));
    return shares;
  }
  // Weights the light of lit casters against that of light paths, given these shares.
  void share_light(const GatheredVertices& v, const GatheredLights& lights, uint32_t number, bool reflected,
                   const LaneNumbers& shares, ShadowLanes& shadows) const;

  // Opaque surfaces with layers (layered_lanes.h): returns whether they may be taken; their lobes.
  [[nodiscard]] bool are_layers_in_lanes(size_t number, const SurfacePoint& surface) const;
  void shade_layers(VertexQueue& queue);

  // Glass (glass_lanes.h). is_glass_in_lanes() returns whether a vertex with layers is glass that
  // may be taken; take_glass() takes it, unless it is rough and is to be shaded alone.
  [[nodiscard]] bool is_glass_in_lanes(size_t number, const SurfacePoint& surface) const;
  [[nodiscard]] bool take_glass(size_t number, ShadeGroup::Member& member);
  void shade_glass(VertexQueue& queue); // clear
  [[nodiscard]] GlassBoundaries boundaries_at(const GatheredVertices& v) const;
  [[nodiscard]] Lanes glass_spread(const GatheredVertices& v, const GlassBoundaries& here, const Vectors& wi,
                                   const LaneMask& reflected) const;
  void extend_glass(const GatheredVertices& v, const GlassBoundaries& here, const GlassBounce& bounce, uint32_t lanes);
  // Rough glass (rough_glass_lanes.h).
  using RoughGlass = RoughGlassOf<Lanes>;
  void shade_rough_glass(VertexQueue& queue);
  [[nodiscard]] static LaneMask is_narrow(const RoughGlass& glass, const Lanes& pdf);
  [[nodiscard]] uint32_t leaves_environment(const GatheredVertices& v, const GlassBoundaries& here) const;
  void light_glass(const GatheredVertices& v, const GlassBoundaries& here, const RoughGlass& glass,
                   uint32_t light_samples, uint32_t left, uint32_t lanes);
  void weigh_glass(const GatheredVertices& v, const GlassBoundaries& here, const RoughGlass& glass,
                   uint32_t light_samples, uint32_t number, uint32_t left, uint32_t lanes, ShadowLanes& shadows);

  void shade_plain(VertexQueue& queue);
  // Shades the vertices of lanes, of which `alone` has those that add their light samples one by
  // one.
  template <typename Bsdf>
  void shade(const GatheredVertices& v, const Bsdf& bsdf, uint32_t alone);
  // Return one vertex as those are that are shaded alone; `frame` is borrowed.
  [[nodiscard]] static Frame frame_of(const GatheredVertices& v, uint32_t lane) {
    return {lane_of(v.frame.tangent, lane), lane_of(v.frame.bitangent, lane), lane_of(v.frame.normal, lane)};
  }
  [[nodiscard]] PathStages::Vertex vertex_of(const GatheredVertices& v, uint32_t lane, const PlainBsdf& bsdf,
                                             const Frame& frame) const {
    return vertex_of(v, lane, GuidedBsdf(bsdf.lane(lane), frame), nullptr, frame);
  }
  [[nodiscard]] PathStages::Vertex vertex_of(const GatheredVertices& v, uint32_t lane, const LayersBsdf& /*bsdf*/,
                                             const Frame& frame) const {
    const SurfacePoint& surface = v.members[lane]->surface;
    const GuidedBsdf alone(surface.bsdf, &surface.layers.bsdf, frame, -v.rays[lane]->direction);
    return vertex_of(v, lane, alone, &layers_here_[lane], frame);
  }
  [[nodiscard]] PathStages::Vertex vertex_of(const GatheredVertices& v, uint32_t lane, const GuidedBsdf& bsdf,
                                             const PathStages::LayersHere* layers, const Frame& frame) const {
    const ShadeGroup::Member& member = *v.members[lane];
    return {member.surface, context_.hits[v.numbers[lane]], frame, bsdf, v.rays[lane]->time, member.sampled, layers};
  }
  // Adds the light samples of one vertex. True: its next direction is to be drawn.
  template <typename Bsdf>
  bool light_alone(const GatheredVertices& v, uint32_t lane, const Bsdf& bsdf);
  // Notes how a vertex is reused and guided.
  void prepare(const GatheredVertices& v, uint32_t lane, const Lobes& lobes);

  // Steps of shade(); `lanes` has a bit for each vertex that they concern. add_lights() adds light
  // samples and reflection samples, as PathStages::add_lights() for weights alone (light_lanes.h).
  // counts_of() returns how many a queue's vertices have: all are first surfaces, or none is.
  template <typename Bsdf>
  [[nodiscard]] PathStages::DirectCounts counts_of(const PathState& state, const Bsdf& bsdf) const;
  template <typename Bsdf>
  void add_lights(const GatheredVertices& v, const Bsdf& bsdf, const PathStages::DirectCounts& counts, uint32_t lanes);
  template <typename Bsdf>
  [[nodiscard]] GatheredLights reflected_lights(const GatheredVertices& v, const Bsdf& bsdf, uint32_t number,
                                                uint32_t lanes) const;
  void light_up(const LaneNumbers& probabilities, GatheredLights& reflected) const;
  template <typename Bsdf>
  void weigh(const GatheredVertices& v, const Bsdf& bsdf, const PathStages::DirectCounts& counts,
             const GatheredLights& lights, uint32_t number, bool reflected, uint32_t lanes, ShadowLanes& shadows) const;
  void add_shadow(const GatheredVertices& v, uint32_t lane, uint32_t number, const ShadowLanes& shadows);

  // scatter() samples the next directions, as PathStages::sample_bounce() (bounce_lanes.h).
  struct Scattered {
    LaneMask found, glossy; // else diffuse
    Vectors wi, weight;
    Lanes pdf, bsdf_pdf, reflection_pdf; // bsdf_pdf: without the guide
  };
  template <typename Bsdf>
  void scatter(const GatheredVertices& v, const Bsdf& bsdf, const PathStages::DirectCounts& counts, uint32_t lanes);
  template <typename Bsdf>
  [[nodiscard]] Scattered draw(const GatheredVertices& v, const Bsdf& bsdf, uint32_t lanes) const;
  // Replaces the directions of some lanes by those of the guide.
  template <typename Bsdf>
  void follow(const GatheredVertices& v, const Bsdf& bsdf, const Vectors& wi, uint32_t lanes, Scattered& result) const;
  // Notes the directions in the records of shared paths and of first surfaces.
  void note_directions(const GatheredVertices& v, const Scattered& drawn, uint32_t lanes);
  // Continues a path. `ray` has the first half of the next ray; `scattered`: throughput, density
  // (0: a delta direction), density for light samples, ratio of reflection samples, spread,
  // guiding. `specular_cone`: of PathState.
  void extend(const GatheredVertices& v, uint32_t lane, const float* ray, const float* scattered, Lobe lobe,
              const RayCone& specular_cone);

  const PathStages& stages_;
  PathContext& context_;
  Sink& sink_;
  bool is_alone_;     // nothing is shaded in lanes
  bool lights_alone_; // the light samples of no vertex are found in lanes
  bool prepares_;     // paths are shared, or directions guided
  // Opaque surfaces: with microfacets or a Lambertian base, each: later surfaces, first ones.
  std::array<VertexQueue, 4> plain_, layered_;
  VertexQueue clear_glass_;
  std::array<VertexQueue, 2> rough_glass_; // later surfaces, first ones
  // For the queue that is being shaded, lane by lane.
  GatheredVertices::Each<ReusedPath*> reused_{}; // null: not shared
  LaneMask shared_first_, shared_second_;        // their first and second surfaces
  uint32_t casters_ = 0;                         // a bit for each that is one
  GuideLanes guides_;
  GatheredVertices::Each<PathStages::LayersHere> layers_here_; // of layered surfaces
};

template <typename Sink>
void VertexLanes<Sink>::shade_plain(VertexQueue& queue) {
  const GatheredVertices v(queue, stages_, context_);
  queue.count = 0;
  const uint32_t all = (1U << v.count) - 1U;
  uint32_t alone = lights_alone_ ? all : v.special & all;
  for (uint32_t lane = 0; lane < v.count; ++lane)
    alone |= records_surface(context_.active[v.numbers[lane]]) ? 1U << lane : 0U;
  shade(v, PlainBsdf(v.parameters, v.wo), alone);
}

template <typename Sink>
template <typename Bsdf>
void VertexLanes<Sink>::shade(const GatheredVertices& v, const Bsdf& bsdf, uint32_t alone) {
  const PathStages::DirectCounts counts = counts_of(*v.states[0], bsdf); // before a path leaves its first surface
  const uint32_t all = (1U << v.count) - 1U;
  uint32_t drawn = all; // those whose next direction is drawn in lanes
  guides_.clear();
  shared_first_ = shared_second_ = LaneMask{};
  casters_ = 0;
  for (uint32_t lane = 0; lane < v.count && stages_.light_paths; ++lane)
    casters_ |= is_caster(v.members[lane]->surface) ? 1U << lane : 0U;
  if (alone != 0 || prepares_) {
    const Lobes lobes{bsdf.smooth_share(kMinSharedAlpha), bsdf.cosine_begin(), bsdf.alpha()};
    for (uint32_t lane = 0; lane < v.count; ++lane) {
      const bool first = v.states[lane]->bounce == 0;
      if (((alone >> lane) & 1U) == 0) {
        if (prepares_) prepare(v, lane, lobes);
      } else if (!light_alone(v, lane, bsdf)) {
        drawn &= ~(1U << lane);
      }
      if (reused_[lane]) (first ? shared_first_ : shared_second_)[lane] = -1;
    }
  }
  if (alone != all) add_lights(v, bsdf, counts, all & ~alone);
  for (uint32_t rest = stages_.light_paths ? all & ~alone : 0; rest != 0; rest &= rest - 1)
    join_light_paths(v, static_cast<uint32_t>(std::countr_zero(rest)), bsdf);
  if (drawn != 0) scatter(v, bsdf, counts, drawn);
}

template <typename Sink>
void VertexLanes<Sink>::prepare(const GatheredVertices& v, uint32_t lane, const Lobes& lobes) {
  const SurfacePoint& surface = v.members[lane]->surface;
  const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
  reused_[lane] = PathStages::reused_path(sink_, path, surface, [&] { return is_mirror(lobes.smooth[lane]); });
  if (reused_[lane]) reused_[lane]->note(surface, -v.rays[lane]->direction, path.state);
  if (!stages_.guides_directions()) return;
  guides_.guide(lane, stages_, surface.position, surface.shading_normal, {lobes.glossy[lane], lobes.alpha[lane]});
}

template <typename Sink>
template <typename Bsdf>
void VertexLanes<Sink>::join_light_paths(const GatheredVertices& v, uint32_t lane, const Bsdf& bsdf) {
  const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
  const accel::Hit& hit = context_.hits[v.numbers[lane]];
  const SurfacePoint& surface = v.members[lane]->surface;
  const float radius2 = stages_.find_light_path_scale(*v.rays[lane], hit, surface, path);
  if (radius2 > 0.0f) sink_.gather_photons(vertex_of(v, lane, bsdf, frame_of(v, lane)), path, radius2);
}

template <typename Sink>
template <typename Bsdf>
bool VertexLanes<Sink>::light_alone(const GatheredVertices& v, uint32_t lane, const Bsdf& bsdf) {
  const PathInFlight path = context_.path_at(context_.active[v.numbers[lane]]);
  const ShadeGroup::Member& member = *v.members[lane];
  const Frame frame = frame_of(v, lane);
  PathStages::Vertex vertex = vertex_of(v, lane, bsdf, frame);
  ReusedPath*& reused = reused_[lane];
  if (!stages_.shade_vertex(*v.rays[lane], vertex, context_.group.lights_of(member), path, sink_, reused)) return false;
  if (!vertex.bsdf.is_guided()) return true;
  stages_.sample_bounce(vertex, path, sink_, reused);
  return false;
}

} // namespace kindling

#include "renderer/integrator/lanes/bounce_lanes.h"
#include "renderer/integrator/lanes/glass_lanes.h"
#include "renderer/integrator/lanes/layered_lanes.h"
#include "renderer/integrator/lanes/light_lanes.h"
#include "renderer/integrator/lanes/rough_glass_lanes.h"
