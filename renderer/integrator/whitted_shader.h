// Shading of a Whitted tree's node: its light and its child nodes, for any order of traversal.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film_surface.h"
#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/stages/path_state.h"
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/integrator/whitted_counters.h"
#include "renderer/integrator/whitted_settings.h"
#include "renderer/integrator/whitted_vertex.h"
#include "renderer/light/per_light_sampling.h"

#include <cassert>

namespace kindling {

// Parts of the light for AOVs: emitted by visible surfaces, reflected by them once, everything
// else.
enum class WhittedPart : uint8_t { emission, direct, indirect };

// A Sink receives the results:
//   void add(const WhittedNode&, WhittedPart, const Rgb&)         adds radiance to the node's
//                                                                 sample
//   void add_transparency(const WhittedNode&, float)              adds to 1 - alpha of it
//   void feel(const WhittedNode&, const accel::Ray&, const Rgb&)  the same if the ray is unoccluded
//   void follow(WhittedNode&&)                                    takes a child node
//   void surface(const WhittedNode&, const WhittedVertex&)        takes the first surface, for AOVs
//   WhittedCounters& counters()
//
// All that the nodes of a tree read, on any device.
struct WhittedShader {
  // Returns the first node of a sample.
  [[nodiscard]] WhittedNode root(const accel::Ray& camera_ray, uint32_t slot) const;
  [[nodiscard]] static RayFootprint footprint_of(const WhittedNode& node, const accel::Hit& hit) {
    return {.width_m = node.cone.width_at(hit.t), .filters_emission = true};
  }
  // Handles the end of a node's ray: applies the medium's absorption, or adds the background. True
  // if there is a surface to shade.
  template <typename Sink>
  [[nodiscard]] bool arrive(WhittedNode& node, const accel::Hit& hit, Sink& sink) const;
  template <typename Sink>
  void shade(const WhittedNode& node, const accel::Hit& hit, SurfacePoint& surface, Sink& sink) const;
  // Returns the transmittance of the thin walls along a feeler that no opaque surface occludes.
  // `intersect` returns the nearest hit of a ray.
  template <typename Intersect>
  [[nodiscard]] Rgb through_thin_walls(accel::Ray feeler, const Intersect& intersect) const;

  // Fills the record of a sample's first surface.
  void record_surface(const WhittedVertex& vertex, FilmSurface& record) const;

  // Places of child nodes, each with its own random numbers.
  enum Place : uint32_t { kMirror = 1, kCoat, kGlassMirror, kRefraction, kStraight, kLight = 64 };
  // The fate of a feeler at the nearest thin wall on its way.
  enum class ThinWall : uint8_t { blocks, passed, last };

  // Returns the radiance that a node without a hit sees.
  [[nodiscard]] Rgb escaped(const WhittedNode& node) const;
  // Returns the radiance of punctual lights with a size along the node's ray. The camera does not
  // see them.
  [[nodiscard]] Rgb shapes_along(const WhittedNode& node, const accel::Hit& hit) const;
  [[nodiscard]] ThinWall pass_thin_wall(const accel::Hit& hit, accel::Ray& feeler, Rgb& through) const;
  [[nodiscard]] WhittedTerms terms_of(const accel::Hit& hit, const SurfacePoint& surface,
                                      WhittedCounters& counters) const;
  [[nodiscard]] WhittedTerms cached_terms(const accel::Hit& hit, const SurfacePoint& surface,
                                          WhittedCounters& counters) const;
  template <typename Sink>
  void light(const WhittedVertex& vertex, Sink& sink) const;
  template <typename Sink>
  void pass_straight(const WhittedVertex& vertex, float distance, const Rgb& thin_wall, Sink& sink) const;
  template <typename Sink>
  void follow_mirrors(const WhittedVertex& vertex, float distance, Sink& sink) const;
  template <typename Sink>
  void follow_glass(const WhittedVertex& vertex, float distance, Sink& sink) const;
  // Follows one ray, or one for each stratum. `sample(u)` returns its direction and final weight as
  // an std::optional<BsdfSample>.
  template <typename Sink, typename Sample>
  void follow_lobe(const WhittedVertex& vertex, float distance, Place place, Sink& sink, const Sample& sample) const;
  // Follows one ray in direction wi (local). `weight` is the factor of its light towards wo.
  template <typename Sink>
  void follow_ray(const WhittedVertex& vertex, float distance, uint32_t key, const V3f& wi, float pdf,
                  const Rgb& weight, bool reflection, bool split, Sink& sink) const;

  [[nodiscard]] bool may_follow(const WhittedNode& node) const { return node.depth < settings.trace_depth; }
  [[nodiscard]] bool may_reflect(const WhittedNode& node) const { return node.reflections < settings.max_reflections; }

  const WorldView* world = nullptr;
  const CameraView* camera = nullptr;
  float sample_width = 1.0f; // width of a sample's cone relative to its pixel's
  WhittedSettings settings;
  bool environment_visible = true;
  bool transparent_background = false;
  std::optional<Rgb> background;
  PerLightView lights;
  size_t light_count = 0; // number of lights that get feelers, the first of `lights`
  Rgb ambient{0.0f};
  WhittedCache* cache = nullptr; // null: terms are computed at each surface
};

// Returns the shader of the trees of a camera, without a cache. It refers to all arguments but the
// settings and the sampler.
[[nodiscard]] WhittedShader make_whitted_shader(const IntegratorSettings& settings, const WorldView& world,
                                                const CameraView& camera, const Sampler& sampler,
                                                const PerLightView& lights);

// Returns `u` moved into one cell of an n x n grid over the unit square.
[[nodiscard]] inline V2f in_stratum(const V2f& u, int cell, int n) {
  assert(cell >= 0 && cell < n * n);
  const float side = 1.0f / static_cast<float>(n);
  return {std::min((static_cast<float>(cell % n) + u.x) * side, kOneMinusEpsilon),
          std::min((static_cast<float>(cell / n) + u.y) * side, kOneMinusEpsilon)};
}

inline WhittedNode WhittedShader::root(const accel::Ray& camera_ray, uint32_t slot) const {
  WhittedNode node;
  node.ray = camera_ray;
  node.slot = slot;
  node.cone = sample_cone(*camera, camera_ray.direction, sample_width);
  return node;
}

template <typename Sink>
bool WhittedShader::arrive(WhittedNode& node, const accel::Hit& hit, Sink& sink) const {
  if (world->lights.has_shapes && !node.seen) {
    const Rgb radiance = shapes_along(node, hit);
    if (!is_black(radiance)) sink.add(node, WhittedPart::indirect, node.weight * radiance);
  }
  if (!hit.is_hit()) {
    if (node.seen && transparent_background) {
      const Rgb& w = node.weight;
      sink.add_transparency(node, (w.x + w.y + w.z) * (1.0f / 3.0f));
    } else {
      const Rgb radiance = escaped(node);
      if (!is_black(radiance)) sink.add(node, WhittedPart::emission, node.weight * radiance);
    }
    return false;
  }
  if (node.in_medium) node.weight *= medium_transmittance(*world, node.media, hit.t);
  return !is_black(node.weight);
}

template <typename Intersect>
Rgb WhittedShader::through_thin_walls(accel::Ray feeler, const Intersect& intersect) const {
  Rgb through(1.0f);
  feeler.flags = kHitThinWalls;
  for (uint32_t thin_wall = 0; thin_wall < kMaxTransparentSurfaces; ++thin_wall) {
    const accel::Hit hit = intersect(feeler);
    if (!hit.is_hit()) return through;
    const ThinWall wall = pass_thin_wall(hit, feeler, through);
    if (wall == ThinWall::blocks) return Rgb(0.0f);
    if (wall == ThinWall::last) return through;
  }
  return Rgb(0.0f); // behind too many thin walls
}

template <typename Sink>
void WhittedShader::shade(const WhittedNode& node, const accel::Hit& hit, SurfacePoint& surface, Sink& sink) const {
  if (surface.layered && surface.layers.boundary && !surface.layers.entering && node.in_medium &&
      node.media.covered(surface.material)) { // ignored: a medium entered later is on both sides
    if (node.transparent_surfaces >= kMaxTransparentSurfaces) return;
    WhittedNode beyond = node;
    ++beyond.transparent_surfaces;
    beyond.ray.key = hash_combine(node.ray.key, kStraight);
    beyond.ray.origin = offset_ray_origin(surface, node.ray.direction);
    beyond.media.leave(surface.material);
    beyond.in_medium = !beyond.media.empty();
    sink.follow(std::move(beyond));
    return;
  }
  const WhittedTerms terms = surface.unlit ? WhittedTerms{} : terms_of(hit, surface, sink.counters());
  if (!is_black(surface.emitted)) sink.add(node, WhittedPart::emission, node.weight * surface.emitted * surface.alpha);
  const WhittedVertex vertex(*world, node, surface, terms, settings.highlight_roughness);
  if (node.seen && node.depth == 1) sink.surface(node, vertex);
  if (surface.unlit) {
    if (surface.alpha < 1.0f) pass_straight(vertex, hit.t, Rgb(0.0f), sink);
    return;
  }
  if (!is_black(terms.ambient)) sink.add(node, WhittedPart::direct, node.weight * terms.ambient * surface.alpha);
  light(vertex, sink);
  const Rgb thin_wall = surface.has_thin_wall() ? vertex.bsdf().straight_transmittance() : Rgb(0.0f);
  if (surface.alpha < 1.0f || !is_black(thin_wall)) pass_straight(vertex, hit.t, thin_wall, sink);
  if (!terms.traced || !may_follow(node)) return;
  follow_mirrors(vertex, hit.t, sink);
  if (terms.glass_share > 0.0f) follow_glass(vertex, hit.t, sink);
}

// Sends a shadow feeler to every light, or n x n to lights with an extent.
template <typename Sink>
void WhittedShader::light(const WhittedVertex& vertex, Sink& sink) const {
  const SurfacePoint& surface = vertex.surface;
  const WhittedNode& node = vertex.node;
  const V3f normal = surface.light_normal();
  for (size_t l = 0; l < light_count; ++l) {
    const bool delta = lights.is_delta(l);
    const int n = delta ? 1 : settings.light_strata;
    const uint32_t key = hash_combine(node.ray.key, kLight + static_cast<uint32_t>(l));
    const float share = surface.alpha / static_cast<float>(n * n);
    for (int cell = 0; cell < n * n; ++cell) {
      const V2f u =
          delta ? V2f(0.5f) : in_stratum(Sampler::sample_2d(key, node.ray.index, static_cast<uint32_t>(cell)), cell, n);
      const std::optional<LightSample> sample = lights.sample(l, surface.position, normal, u, node.ray.time);
      if (!sample) continue;
      const float side = sample->wi.dot(surface.geometric_normal);
      const V3f wi = vertex.frame.to_local(sample->wi);
      if (surface.layered ? (side > 0.0f) != (wi.z > 0.0f) : side <= 0.0f) continue;
      if (side < 0.0f && delta && vertex.highlight_is_blurred() && surface.layers.bsdf.diffuse_transmission == 0.0f)
        continue;
      const BsdfEval eval = (delta ? vertex.highlight_bsdf() : vertex.bsdf()).eval(wi);
      Rgb value = eval.value;
      if (!delta) value *= vertex.share_of_lights(wi, eval.pdf);
      if (is_black(value)) continue;
      Rgb contribution = node.weight * value * sample->radiance * (share / sample->pdf);
      if (surface.layered || node.in_medium) contribution *= vertex.transmittance_to_light(side, sample->distance);
      accel::Ray feeler = make_shadow_ray(surface, *sample, hash_combine(key, static_cast<uint32_t>(cell)),
                                          node.ray.index, node.ray.time);
      feeler.flags = kPassThinWalls;
      sink.feel(node, feeler, contribution);
    }
  }
}

// Partial coverage passes 1 - alpha of the light and does not count as a ray of the tree; a thin
// wall counts.
template <typename Sink>
void WhittedShader::pass_straight(const WhittedVertex& vertex, float distance, const Rgb& thin_wall, Sink& sink) const {
  const WhittedNode& node = vertex.node;
  const bool through_thin_wall = !is_black(thin_wall) && may_follow(node);
  Rgb passed(1.0f - vertex.surface.alpha);
  if (through_thin_wall) passed += thin_wall * vertex.surface.alpha;
  if (is_black(passed) || node.transparent_surfaces >= kMaxTransparentSurfaces) return;
  WhittedNode beyond = node;
  ++beyond.transparent_surfaces;
  if (through_thin_wall) {
    ++beyond.depth;
    ++sink.counters().transmission;
  }
  beyond.weight *= passed;
  beyond.cone.width_m = node.cone.width_at(distance);
  beyond.ray.key = hash_combine(node.ray.key, kStraight);
  beyond.ray.origin = offset_ray_origin(vertex.surface, node.ray.direction);
  sink.follow(std::move(beyond));
}

template <typename Sink>
void WhittedShader::follow_ray(const WhittedVertex& vertex, float distance, uint32_t key, const V3f& wi, float pdf,
                               const Rgb& weight, bool reflection, bool split, Sink& sink) const {
  const WhittedNode& node = vertex.node;
  assert(may_follow(node) && pdf >= 0.0f);
  const SurfacePoint& surface = vertex.surface;
  const V3f direction = vertex.frame.to_world(wi);
  // The shading normal may put a reflection below the surface, or a refraction above it.
  if ((direction.dot(surface.geometric_normal) < 0.0f) != (wi.z < 0.0f)) return;
  WhittedNode below = node;
  below.weight = node.weight * weight * surface.alpha;
  below.cone = scattered_cone({node.cone.width_at(distance), node.cone.spread}, pdf);
  below.ray.key = key;
  below.ray.origin = offset_ray_origin(surface, direction);
  below.ray.direction = direction;
  below.ray.flags &= ~kCameraRay;
  ++below.depth;
  below.reflections = static_cast<uint8_t>(node.reflections + (reflection ? 1 : 0));
  below.transparent_surfaces = 0;
  below.seen = false;
  below.split |= split;
  if (wi.z < 0.0f) vertex.cross(below);
  if (is_black(below.weight)) return;
  ++(wi.z < 0.0f ? sink.counters().transmission : sink.counters().reflection);
  sink.follow(std::move(below));
}

template <typename Sink, typename Sample>
void WhittedShader::follow_lobe(const WhittedVertex& vertex, float distance, Place place, Sink& sink,
                                const Sample& sample) const {
  const WhittedNode& node = vertex.node;
  const uint32_t key = hash_combine(node.ray.key, place);
  const int n = node.split ? 1 : settings.glossy_strata;
  for (int cell = 0; cell < n * n; ++cell) {
    const auto dimension = static_cast<uint32_t>(cell);
    const V2f u = in_stratum(Sampler::sample_2d(key, node.ray.index, dimension), cell, n);
    std::optional<BsdfSample> s = sample(u);
    if (!s) continue;
    const bool reflection = s->lobe != Lobe::transmission;
    follow_ray(vertex, distance, n == 1 ? key : hash_combine(key, dimension), s->wi, s->pdf,
               s->weight * (1.0f / static_cast<float>(n * n)), reflection, n > 1, sink);
  }
}

// Follows the reflections of the glossy base and of a coat over it.
template <typename Sink>
void WhittedShader::follow_mirrors(const WhittedVertex& vertex, float distance, Sink& sink) const {
  if (!may_reflect(vertex.node)) return;
  const WhittedTerms& terms = vertex.terms;
  const V3f& wo = vertex.wo;
  const LayeredBsdf* const layered = vertex.surface.layered ? vertex.bsdf().layers() : nullptr;
  const V3f mirrored(-wo.x, -wo.y, wo.z);
  Rgb mirror(0.0f); // weight of all layers that reflect in exactly this direction: one ray serves them all
  if (terms.mirror_share > 0.0f) {
    if (terms.smooth && layered) {
      mirror = layered->glossy_albedo() * terms.mirror_share;
    } else if (terms.smooth) {
      mirror = terms.mirror_f0 + terms.mirror_slope * pow5(std::max(1.0f - wo.z, 0.0f));
    } else {
      follow_lobe(vertex, distance, kMirror, sink, [&](const V2f& u) {
        const float begin = layered ? layered->choice_begin(LayeredBsdf::kGlossy) : 0.0f;
        const float probability =
            layered ? layered->choice_probability(LayeredBsdf::kGlossy) : vertex.bsdf().cosine_begin();
        if (!(probability > 0.0f)) return std::optional<BsdfSample>();
        std::optional<BsdfSample> s = vertex.bsdf().sample(begin + 0.5f * probability, u);
        if (s) s->weight *= probability * terms.mirror_share;
        return s;
      });
    }
  }
  if (terms.coat_mirror_share > 0.0f && layered) {
    const V3f& n = vertex.surface.layers.bsdf.clearcoat_normal;
    const Rgb weight(1.0f - layered->coat_transmittance());
    if (terms.coat_smooth && n.z > 0.99999f) {
      mirror += weight;
    } else if (terms.coat_smooth) {
      const V3f wi = n * (2.0f * wo.dot(n)) - wo;
      if (wi.z > 0.0f)
        follow_ray(vertex, distance, hash_combine(vertex.node.ray.key, kCoat), wi, 0.0f, weight, true, false, sink);
    } else {
      follow_lobe(vertex, distance, kCoat, sink, [&](const V2f& u) {
        const float probability = layered->choice_probability(LayeredBsdf::kCoat);
        std::optional<BsdfSample> s = vertex.bsdf().sample(0.5f * probability, u);
        if (s) s->weight *= probability * terms.coat_mirror_share;
        return s;
      });
    }
  }
  if (!is_black(mirror))
    follow_ray(vertex, distance, hash_combine(vertex.node.ray.key, kMirror), mirrored, 0.0f, mirror, true, false, sink);
}

// Follows reflection and refraction of glass; pass_straight() transmits smooth thin walls. Total
// reflection is the only continuation, so only the tree's depth limits it.
template <typename Sink>
void WhittedShader::follow_glass(const WhittedVertex& vertex, float distance, Sink& sink) const {
  const LayeredBsdf& layered = *vertex.bsdf().layers();
  if (!layered.glass() || !(layered.glass_weight() > 0.0f)) return;
  const DielectricLobe& glass = *layered.glass();
  const V3f& wo = vertex.wo;
  const uint32_t key = vertex.node.ray.key;
  if (glass.is_delta() || vertex.surface.has_thin_wall()) {
    const float eta = vertex.surface.layers.bsdf.eta;
    const float cos_t = refracted_cosine(wo.z, eta);
    const bool total = glass.is_delta() && cos_t < 0.0f;
    if (total || may_reflect(vertex.node))
      follow_ray(vertex, distance, hash_combine(key, kGlassMirror), V3f(-wo.x, -wo.y, wo.z), 0.0f,
                 glass.reflected_albedo() * layered.glass_weight(), !total, false, sink);
    if (glass.is_delta() && !total)
      follow_ray(vertex, distance, hash_combine(key, kRefraction), V3f(-wo.x / eta, -wo.y / eta, -cos_t).normalized(),
                 0.0f, glass.transmitted_albedo() * layered.glass_weight(), false, false, sink);
    return;
  }
  const float begin = layered.choice_begin(LayeredBsdf::kGlass);
  const float probability = layered.choice_probability(LayeredBsdf::kGlass);
  if (!(probability > 0.0f)) return;
  const auto sample_side = [&](const V2f& u, bool reflect) {
    const float reflected = glass.reflection_probability(u);
    const float share = reflect ? reflected : 1.0f - reflected;
    if (!(share > 0.0f)) return std::optional<BsdfSample>();
    if (reflect && share < 1.0f && !may_reflect(vertex.node)) return std::optional<BsdfSample>();
    const float at = reflect ? 0.5f * reflected : 0.5f * (1.0f + reflected);
    std::optional<BsdfSample> s = layered.sample(begin + probability * at, u);
    if (s) s->weight *= probability * share;
    return s;
  };
  follow_lobe(vertex, distance, kGlassMirror, sink, [&](const V2f& u) { return sample_side(u, true); });
  follow_lobe(vertex, distance, kRefraction, sink, [&](const V2f& u) { return sample_side(u, false); });
}

} // namespace kindling
