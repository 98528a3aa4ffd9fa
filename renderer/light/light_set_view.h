// Light selection, samples, densities and emitted radiance, on plain arrays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/light/coated_emission.h"
#include "renderer/light/environment.h"
#include "renderer/light/light_frame.h"
#include "renderer/light/light_profile.h"
#include "renderer/light/light_sample.h"
#include "renderer/light/light_set_input.h"
#include "renderer/light/light_tree.h"
#include "renderer/light/point_on_triangle.h"
#include "renderer/light/presampled_environment.h"
#include "renderer/light/sphere_tree.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace kindling {

// A point at which light is requested, and the random numbers of the choice.
struct LightQuery {
  V3f point;
  V3f normal; // unit, on the lit side: light from below its horizon is rarely sampled; zero: light from all directions
  V2f u;      // in [0, 1)^2: x selects the light, its remainder is the first coordinate on the light, y the second
  float digits = 0.0f; // in [0, 1): continues u.x below its 24 bits
  // Learned selection probabilities of the kinds of light; they replace the estimates. All
  // densities take them, too.
  const LightProbabilities* learned = nullptr;
  float time = 0.0f; // in [0, 1] over the shutter
  // Samples of the environment are taken from here; null: they are drawn.
  const PresampledEnvironmentView* presampled = nullptr;
};

// A ray segment along which sized lights are intersected.
struct ShapeRay {
  V3f origin; // the point of the light query
  V3f normal; // the normal of the light query
  V3f direction;
  float begin_m = 0.0f, end_m = kInfinity; // distances from the origin; kInfinity: the ray escapes
  float bsdf_pdf = 0.0f;                   // solid-angle density of the direction; 0: no light sampling competes
  const LightProbabilities* learned = nullptr;
  float time = 0.0f;
  Rgb extinction{0.0f}; // 1 / m from begin_m on, in front of lights at a finite distance
};

// The part of a LightSet that sampling reads. Immutable, thread-safe. A LightTree selects among
// triangles, point and spot lights. That tree, each directional light and the environment are
// selected in proportion to light_selection_weight() of the unoccluded irradiance that each would
// contribute. Lights without power are never selected.
//
// Triangles nearer than twice their longest edge are sampled uniformly by solid angle, others by
// area. The decision depends on triangle and point only, so that pdf_triangle() can repeat it.
struct LightSetView {
  // 40 bytes, plus those of the tree, plus 24 if any emission is textured.
  struct Triangle {
    V3f p0;
    uint32_t emission;
    V3f p1;
    V3f p2;
  };
  static_assert(sizeof(Triangle) == 40);
  // Point, spot and directional lights.
  struct Punctual {
    enum class Kind : uint32_t { point, spot, profiled, directional } kind;
    V3f position;
    V3f axis;                   // direction of emission
    Rgb intensity;              // irradiance for directional lights
    float inverse_range = 0.0f; // 0: unlimited
    float angle_scale = 0.0f;   // spot: falloff = clamp(cos * angle_scale + angle_offset, 0, 1)^2
    float angle_offset = 1.0f;
    float luminance = 0.0f;     // of intensity; 0: never selected
    uint32_t profiled = 0;      // index into profiled_
    float radius = 0.0f;        // of a sphere, or sine of half the angle of a disk in the sky; 0: none
    float one_minus_cos = 0.0f; // of half that angle
    float sin_reach = 0.0f;     // directional: sine of the maximum angle of any direction to it from -axis
    uint32_t key_count = 0;     // of a moving light; 0: static
    uint32_t first_key = 0;     // index into frames
    V3f x{0.0f}, y{0.0f};       // axes of the frame, whose z is -axis
  };
  // Selection weights of the tree, the environment and the directional lights at a point.
  struct SelectionWeights {
    float strongest = 0.0f; // irradiance
    float tree = 0.0f;
    float environment = 0.0f;
    float sum = 0.0f;
    float directional_scale = 1.0f; // of the weights of directional lights
  };

  // The selected kind of light and, for directional lights, which one.
  struct Choice {
    LightKind kind = LightKind::tree;
    uint32_t directional = 0; // index into punctuals
    float probability = 1.0f; // of the selection
    double rest = 0.0;        // remainder of the random number: again uniform in [0, 1)
  };

  [[nodiscard]] bool empty() const { return light_count == 0; }

  // Samples a light and a direction to it from the point of the query. Empty: no contribution
  // (counts as zero). Point, spot and directional lights follow KHR_lights_punctual, with its
  // window for `range_m`.
  [[nodiscard]] std::optional<LightSample> sample(const LightQuery& query) const;
  // The same: u_light selects the light, u.x continues its digits, u.y is the second coordinate.
  [[nodiscard]] std::optional<LightSample> sample(const V3f& point, const V3f& normal, float u_light, const V2f& u,
                                                  const LightProbabilities* learned = nullptr) const {
    return sample(LightQuery{point, normal, {u_light, u.y}, u.x, learned});
  }
  // The same samples for many points, interleaved to hide memory latency. Both spans must have the
  // same size.
  void sample(std::span<const LightQuery> queries, std::span<std::optional<LightSample>> samples) const;

  // Returns the probability with which a query without learned probabilities would have selected
  // the kind of this sample, and among directional lights the light itself. `point` and `normal`
  // are those of the query. 0 if never.
  [[nodiscard]] float unlearned_kind_probability(const V3f& point, const V3f& normal, const LightSample& sample) const;

  // Returns the density of sample() for a hit of emissive triangle `triangle` (in the order of
  // LightSetInput::triangles): solid angle, including light selection. `wi` is unit, from `point`
  // to the hit at `distance`; `point`, `normal` and `time` are those of the query. The side is not
  // checked: emitted() is black on a dark side.
  [[nodiscard]] float pdf_triangle(uint32_t triangle, const V3f& point, const V3f& normal, const V3f& wi,
                                   float distance, const LightProbabilities* learned = nullptr,
                                   float time = 0.0f) const;
  // Returns the density of sample() for leaving the scene along wi.
  [[nodiscard]] float pdf_environment(const V3f& point, const V3f& normal, const V3f& wi,
                                      const LightProbabilities* learned = nullptr) const {
    return has_environment ? environment.pdf(wi) * environment_probability(point, normal, learned) : 0.0f;
  }

  // Returns the radiance of sized lights along the ray to its origin, weighted by the power
  // heuristic between the direction's density and that of light sampling. They do not occlude each
  // other. Directional lights count if the ray escapes.
  [[nodiscard]] Rgb shape_radiance(const ShapeRay& ray) const;
  // Calls visit(number, radiance) for each light that shape_radiance() adds up; `number` is an
  // index into punctuals.
  template <typename Visit>
  void visit_shapes(const ShapeRay& ray, const Visit& visit) const {
    const auto visit_one = [&](uint32_t number, const Rgb& radiance) {
      if (!is_black(radiance)) visit(number, radiance);
    };
    spheres.visit(ray.origin, ray.direction, ray.end_m, [&](uint32_t number) {
      Rgb radiance(0.0f);
      add_sphere(number, ray, radiance);
      visit_one(number, radiance);
    });
    for (size_t i = 0; i < (ray.end_m == kInfinity ? disks.size() : 0); ++i) {
      Rgb radiance(0.0f);
      add_disk(disks[i], ray, radiance);
      visit_one(disks[i], radiance);
    }
  }

  // Returns the radiance of triangle `triangle` along -wi at barycentrics (u, v). Black on a dark
  // side.
  [[nodiscard]] Rgb emitted(uint32_t triangle, float u, float v, const V3f& wi, float time = 0.0f) const;
  [[nodiscard]] Rgb environment_radiance(const V3f& wi) const { // black without an environment
    return has_environment ? environment.radiance(wi) : Rgb(0.0f);
  }
  [[nodiscard]] Rgb environment_radiance(const Environment::Location& at) const {
    return has_environment ? environment.radiance_at(at) : Rgb(0.0f);
  }
  // The same as a mean over an area around the direction (EnvironmentView::mean_radiance()).
  [[nodiscard]] Rgb environment_radiance(const Environment::Location& at, float width_turns) const {
    return has_environment ? environment.mean_radiance(at, width_turns) : Rgb(0.0f);
  }
  // environment_radiance() and pdf_environment() from one lookup.
  [[nodiscard]] EnvironmentEval environment_eval(const V3f& point, const V3f& normal, const V3f& wi,
                                                 const LightProbabilities* learned = nullptr) const {
    return has_environment ? environment_eval(point, normal, environment.locate(wi), learned) : EnvironmentEval{};
  }
  [[nodiscard]] EnvironmentEval environment_eval(const V3f& point, const V3f& normal, const Environment::Location& at,
                                                 const LightProbabilities* learned = nullptr) const {
    return has_environment ? environment_eval(environment_probability(point, normal, learned), at) : EnvironmentEval{};
  }
  // The same, given environment_probability().
  [[nodiscard]] EnvironmentEval environment_eval(float probability, const Environment::Location& at) const {
    if (!has_environment) return {};
    EnvironmentEval eval = environment.eval(at);
    eval.pdf *= probability;
    return eval;
  }
  // Returns the location of wi in the environment for the two functions above, and prefetches its
  // memory.
  [[nodiscard]] Environment::Location locate_in_environment(const V3f& wi) const {
    if (!has_environment) return {};
    const Environment::Location at = environment.locate(wi);
    environment.prefetch(at);
    return at;
  }

  // The same for many directions. Both spans have the same size.
  void locate_in_environment(std::span<const V3f> directions, std::span<Environment::Location* const> locations) const {
    if (has_environment) environment.locate(directions, locations);
  }

  [[nodiscard]] SelectionWeights selection_weights(const V3f& point, const V3f& normal,
                                                   const LightProbabilities* learned) const;
  void set_learned_weights(const V3f& normal, const LightProbabilities& learned, SelectionWeights& weights) const;
  [[nodiscard]] static float directional_irradiance(const Punctual& light, const V3f& normal);
  [[nodiscard]] float environment_probability(const V3f& point, const V3f& normal,
                                              const LightProbabilities* learned) const;
  [[nodiscard]] float tree_probability(const V3f& point, const V3f& normal, const LightProbabilities* learned) const;
  // `weights` are selection_weights() at the query; they are read unless there is a single kind.
  // Sets the choice in its place: copies of what has just been written in parts would be slow.
  void choose_kind(const LightQuery& query, const SelectionWeights& weights, std::optional<Choice>& choice) const;
  // sample() of up to 32 queries.
  void sample_group(std::span<const LightQuery> group, std::span<std::optional<LightSample>> samples) const;
  // The same where all of them have a table, and there is no light but the environment's.
  void sample_tables(std::span<const LightQuery> queries, std::span<std::optional<LightSample>> samples) const;
  // A query whose choice is a triangle.
  struct ChosenTriangle {
    uint32_t query; // its index
    const LightTree::Choice* emitter;
  };
  // `emitter` is the tree's choice for choice.rest if the kind is tree.
  [[nodiscard]] std::optional<LightSample> sample_chosen(const LightQuery& query, const Choice& choice,
                                                         const std::optional<LightTree::Choice>& emitter) const;
  [[nodiscard]] std::optional<LightSample> sample_triangle(uint32_t index, const V3f& point, const V2f& u,
                                                           float time) const;
  // The same for up to Lanes::kCount triangles that do not move; sets the samples of their queries,
  // which must be empty.
  void sample_triangles(std::span<const ChosenTriangle> chosen, std::span<const LightQuery> queries,
                        std::span<const std::optional<Choice>> choices,
                        std::span<std::optional<LightSample>> samples) const;
  // Adds the choice of the kind of light to a sample of it. False: no contribution.
  [[nodiscard]] static bool complete(const Choice& choice, LightSample& sample);
  // Sets the sample to a point on the triangle; `normal` is unit, on the side that is seen. False:
  // no contribution.
  [[nodiscard]] bool set_point(uint32_t index, const PointOnTriangle<float>& point, bool front, const V3f& normal,
                               LightSample& sample) const;
  [[nodiscard]] bool moves(uint32_t triangle) const { return triangle >= first_moving; }
  [[nodiscard]] Triangle posed_triangle(uint32_t index, float time) const; // for moving triangles
  // Key 0 is the opening of the shutter.
  [[nodiscard]] Triangle triangle_at_key(uint32_t index, uint32_t key) const;
  // Punctual lights (punctual_samples.cpp). `number` is an index into punctuals; u is a position
  // on a sized light.
  [[nodiscard]] std::optional<LightSample> sample_punctual(uint32_t number, const V3f& point, const V2f& u,
                                                           float time) const;
  [[nodiscard]] std::optional<LightSample> sample_posed(const Punctual& light, const V3f& point, const V2f& u) const;
  [[nodiscard]] Punctual posed(const Punctual& light, float time) const;
  // Returns `scale` times the intensity's attenuation in direction -wi at this distance from the
  // center.
  [[nodiscard]] float attenuated(const Punctual& light, const V3f& wi, float distance, float scale) const;
  void add_sphere(uint32_t number, const ShapeRay& ray, Rgb& sum) const;
  void add_disk(uint32_t number, const ShapeRay& ray, Rgb& sum) const;
  [[nodiscard]] Rgb emission_at(uint32_t index, float u, float v) const;
  // Returns the transmittance of the coat on a side, at a cosine to the normal.
  [[nodiscard]] static float through_coat(const Emission& emission, bool front, float cos_theta) {
    return emission.clearcoat > 0.0f && (front || emission.coated_back)
               ? coat_transmittance(emission.clearcoat, cos_theta)
               : 1.0f;
  }

  std::span<const Emission> emissions;
  std::span<const Triangle> triangles;
  std::span<const V2f> uvs;           // three per triangle, or empty
  uint32_t first_moving = 0;          // first index of moving triangles
  std::span<const CornerKeys> moving; // keys of the moving triangles
  std::span<const std::array<V3f, 3>> later_corners;
  std::span<const Punctual> punctuals; // points, spots and profiled ones (in the tree), then directional lights
  std::span<const LightProfileView> profiles;
  std::span<const LightFrame> frames; // of moving punctual lights
  SphereTreeView spheres;             // punctual lights with a radius; ids are indices into punctuals
  std::span<const uint32_t> disks;    // directional lights with an angle; indices into punctuals
  bool has_shapes = false;            // a ray may hit a point, spot or directional light with a size
  bool has_environment = false;       // `environment` is valid, and not black
  bool single_kind = false;           // at most the tree or the environment exists: probabilities are 0 and 1
  size_t first_directional = 0;
  LightTreeView tree; // of triangles, then points and spots
  EnvironmentView environment;
  float environment_irradiance = 0.0f; // mean luminance of the irradiance on an unoccluded plane, over its orientations
  size_t light_count = 0;              // that can be selected; each emissive triangle counts
};

// Returns the selection weight of the tree, the environment or a directional light at a point,
// given its unoccluded irradiance and the maximum of all. The weight is proportional to the
// irradiance with a floor of 1/19, because occlusion is unknown: the weaker of two gets at least
// 0.05 of the samples. Zero irradiance has no weight.
[[nodiscard]] inline float light_selection_weight(float irradiance, float strongest) {
  if (!(irradiance > 0.0f)) return 0.0f;
  return std::clamp(irradiance / strongest, 1.0f / 19.0f, 1.0f);
}

} // namespace kindling
