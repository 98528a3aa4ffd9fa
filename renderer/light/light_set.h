// All lights of a World behind one pair of questions: sample one from here, and how likely was that.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/huge_pages.h"
#include "renderer/base/math.h"
#include "renderer/light/coated_emission.h"
#include "renderer/light/environment.h"
#include "renderer/light/light_frame.h"
#include "renderer/light/light_profile.h"
#include "renderer/light/light_sample.h"
#include "renderer/light/light_tree.h"
#include "renderer/light/sphere_tree.h"
#include "renderer/texture/texture.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// What a family of emissive triangles emits: radiance = factor * texture(uv), on the front face or on both.
struct Emission {
  Rgb factor{0.0f};                 // W / (sr m^2), emissive strength multiplied in
  const Texture* texture = nullptr; // sRGB-decoded emission; borrowed, null: factor alone
  bool two_sided = false;           // false: emits on the side where p0, p1, p2 are counter-clockwise
  float clearcoat = 0.0f;           // strength of a coat over it, coat_transmittance(); the same everywhere
  bool coated_back = true;          // the coat is on the other side as well
};

// World space. The triangle's uv are already transformed for the texture.
struct EmissiveTriangle {
  V3f p0, p1, p2;
  uint32_t emission = 0; // index into LightSetInput::emissions
};

// Where a triangle that moves is at the keys after the first: `count` entries of LightSetInput::later_corners. Keys are equally far apart over
// the shutter, and corners go straight from one to the next.
struct CornerKeys {
  uint32_t first = 0;
  uint32_t count = 0; // 0: it stands still
};

// The triangles of one mesh of the scene, which lie together: one light to those who count them (PerLightSampling).
struct EmissiveMesh {
  uint32_t first = 0; // index into LightSetInput::triangles
  uint32_t count = 0;
  std::string name;
};

// Point, spot and profiled lights with a radius are spheres that shine evenly: from every point of the surface in each direction with the
// light's intensity there over pi radius^2, so that a plane that sees all of a sphere has the irradiance that the point would bring. They
// block nothing, and shine inwards as well. Rays that leave a surface meet them (shape_radiance()). Without a radius they are points.
//
// `later`: frames at the keys after the first, for lights that move over the shutter.
struct PointLight {
  V3f position;
  Rgb intensity; // candela per channel
  std::optional<float> range_m;
  std::string name;
  float radius_m = 0.0f; // below a micrometre: a point
  std::vector<LightFrame> later;
};
// light.intensity is multiplied by what the profile says of the direction.
struct ProfiledLight {
  V3f position;
  V3f axes[3];   // unit, of the profile's frame; it is aimed along -axes[2]
  Rgb intensity; // factor per channel
  std::shared_ptr<const LightProfile> profile;
  std::string name;
  float radius_m = 0.0f;
  std::vector<LightFrame> later;
};
struct SpotLight {
  V3f position;
  V3f axis;      // unit, where it shines
  Rgb intensity; // candela per channel, on the axis
  float cos_inner = 1.0f;
  float cos_outer = 0.0f; // < cos_inner
  std::optional<float> range_m;
  std::string name;
  float radius_m = 0.0f;
  std::vector<LightFrame> later;
};
struct DirectionalLight {
  V3f direction;  // unit, where it shines
  Rgb irradiance; // lux per channel, on a surface facing it
  std::string name;
  float angular_diameter_rad = 0.0f; // of an even disc in the sky, up to pi; below a microradian: a point
  std::vector<LightFrame> later;
};

struct LightSetInput {
  std::vector<Emission> emissions;
  std::vector<EmissiveTriangle> triangles;
  std::vector<V2f> triangle_uvs; // empty, or three per triangle
  std::vector<EmissiveMesh> meshes;
  // Of the last triangles, which stand at the opening of the shutter; empty: all are still.
  std::vector<CornerKeys> moving;
  std::vector<std::array<V3f, 3>> later_corners;
  std::vector<PointLight> points;
  std::vector<SpotLight> spots;
  std::vector<ProfiledLight> profiled;
  std::vector<DirectionalLight> directionals;
  std::shared_ptr<const Environment> environment; // may be null
  V3f scene_center{0.0f};
  float scene_radius_m = 1.0f;
};

// From where light is wanted, and the random numbers that choose it.
struct LightQuery {
  V3f point;
  V3f normal; // unit, on the side that is lit: light from below its horizon is offered rarely; zero: light from all around is wanted
  V2f u; // in [0, 1)^2: x chooses, and what is left of it is the first coordinate on the light, y the second
  float digits = 0.0f; // in [0, 1): goes on where the 24 bits of u.x end
  // How the kinds of light share the samples here, in place of the estimate. All densities take it, too.
  const LightProbabilities* learned = nullptr;
  float time = 0.0f; // in [0, 1] over the shutter: where moving lights are
};

// A stretch of a ray along which lights with a size are looked for.
struct ShapeRay {
  V3f origin; // where light sampling asked from
  V3f normal; // likewise
  V3f direction;
  float begin_m = 0.0f, end_m = kInfinity; // in distances from the origin; kInfinity: the ray escapes
  float bsdf_pdf = 0.0f;                   // of the direction, by solid angle; 0: no light sampling competes
  const LightProbabilities* learned = nullptr;
  float time = 0.0f;
  Rgb extinction{0.0f}; // 1 / m, from begin_m on, of what is before lights at a finite distance
};

// Length: twice the area. Points to the side from which p0, p1, p2 are counter-clockwise.
template <typename Triangle>
[[nodiscard]] V3f double_area_normal(const Triangle& t) {
  return (t.p1 - t.p0).cross(t.p2 - t.p0);
}

// Immutable, thread-safe, without allocation after construction. Triangles, point and spot lights are chosen by a
// LightTree; that tree, each directional light and the environment have shares (light_share()) that follow the
// irradiance which each would bring to the point if nothing were in between. Lights without power are never chosen.
//
// Triangles nearer than twice their longest edge are sampled uniformly by solid angle, others by area. The
// choice is a function of triangle and point alone, so that pdf_triangle() can repeat it.
class LightSet {
 public:
  explicit LightSet(LightSetInput input);

  [[nodiscard]] bool empty() const { return light_count_ == 0; }

  // A light and a direction to it, seen from the point of the query. Empty: nothing useful (counts as zero). Point, spot and
  // directional lights follow KHR_lights_punctual, with its window for `range_m`.
  [[nodiscard]] std::optional<LightSample> sample(const LightQuery& query) const;
  // The same: u_light chooses, u.x goes on where its digits end, u.y is the second coordinate.
  [[nodiscard]] std::optional<LightSample> sample(const V3f& point, const V3f& normal, float u_light, const V2f& u,
                                                  const LightProbabilities* learned = nullptr) const {
    return sample(LightQuery{point, normal, {u_light, u.y}, u.x, learned});
  }
  // The same samples for many points, which wait for memory together. As many samples as queries.
  void sample(std::span<const LightQuery> queries, std::span<std::optional<LightSample>> samples) const;

  // The density with which sample() from `point` and `normal` would have produced this hit of emissive triangle number
  // `triangle` (the order of LightSetInput::triangles), solid angle, choice included. `wi` unit from point to the hit
  // at `distance`, `time` of the query. Says nothing about the side: where the triangle is dark, emitted() is black.
  [[nodiscard]] float pdf_triangle(uint32_t triangle, const V3f& point, const V3f& normal, const V3f& wi,
                                   float distance, const LightProbabilities* learned = nullptr,
                                   float time = 0.0f) const;
  // The same for leaving the scene along wi.
  [[nodiscard]] float pdf_environment(const V3f& point, const V3f& normal, const V3f& wi,
                                      const LightProbabilities* learned = nullptr) const {
    return environment_ ? environment_->pdf(wi) * environment_probability(point, normal, learned) : 0.0f;
  }

  // Whether a ray may meet a point, spot or directional light that has a size.
  [[nodiscard]] bool has_shapes() const { return has_shapes_; }
  // What such lights send along the ray to its origin, each weighted by the power heuristic of the direction's density against that of
  // sampling the light. None of them hides another. Directional lights count where the ray escapes.
  [[nodiscard]] Rgb shape_radiance(const ShapeRay& ray) const;

  // Radiance that triangle number `triangle` sends back along -wi from barycentrics (u, v). Black on a dark side.
  [[nodiscard]] Rgb emitted(uint32_t triangle, float u, float v, const V3f& wi, float time = 0.0f) const;
  [[nodiscard]] Rgb environment_radiance(const V3f& wi) const { // black without an environment
    return environment_ ? environment_->radiance(wi) : Rgb(0.0f);
  }
  [[nodiscard]] Rgb environment_radiance(const Environment::Location& at) const {
    return environment_ ? environment_->eval(at).radiance : Rgb(0.0f);
  }
  // environment_radiance() and pdf_environment() from one look-up.
  [[nodiscard]] EnvironmentEval environment_eval(const V3f& point, const V3f& normal, const V3f& wi,
                                                 const LightProbabilities* learned = nullptr) const {
    return environment_ ? environment_eval(point, normal, environment_->locate(wi), learned) : EnvironmentEval{};
  }
  [[nodiscard]] EnvironmentEval environment_eval(const V3f& point, const V3f& normal, const Environment::Location& at,
                                                 const LightProbabilities* learned = nullptr) const {
    if (!environment_) return {};
    EnvironmentEval eval = environment_->eval(at);
    eval.pdf *= environment_probability(point, normal, learned);
    return eval;
  }
  // Where wi is in the environment, for the two above; the memory that they will read is asked for.
  [[nodiscard]] Environment::Location locate_in_environment(const V3f& wi) const {
    if (!environment_) return {};
    const Environment::Location at = environment_->locate(wi);
    environment_->prefetch(at);
    return at;
  }
  [[nodiscard]] const Environment* environment() const { return environment_.get(); }

  // Lights that can be chosen, each emissive triangle one.
  [[nodiscard]] size_t light_count() const { return light_count_; }
  [[nodiscard]] size_t memory_bytes() const;

 private:
  friend class PerLightSampling;
  // 40 bytes, those of the tree, and 24 more if any emission is textured.
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
    V3f axis;                   // where it shines
    Rgb intensity;              // irradiance for directional lights
    float inverse_range = 0.0f; // 0: unlimited
    float angle_scale = 0.0f;   // spot: falloff = clamp(cos * angle_scale + angle_offset, 0, 1)^2
    float angle_offset = 1.0f;
    float luminance = 0.0f;     // of intensity; 0: never chosen
    uint32_t profiled = 0;      // index into profiled_
    float radius = 0.0f;        // of a sphere, or sine of half the angle of a disc in the sky; 0: none
    float one_minus_cos = 0.0f; // of half that angle
    float sin_reach = 0.0f;     // directional: no direction to it is farther than this from the one against the axis
    uint32_t key_count = 0;     // of a light that moves; 0: it does not
    uint32_t first_key = 0;     // index into frames_
    V3f x{0.0f}, y{0.0f};       // of the frame, whose z is -axis
  };
  // What the lights outside of the tree weigh at a point, by light_share_weight(), and the tree.
  struct Shares {
    float strongest = 0.0f; // irradiance
    float tree = 0.0f;
    float environment = 0.0f;
    float sum = 0.0f;
    float directional_scale = 1.0f; // of the weights of directional lights
  };

  // One of the kinds of light, and of directional lights which.
  struct Choice {
    LightKind kind = LightKind::tree;
    uint32_t directional = 0; // index into punctuals_
    float probability = 1.0f; // of the choice
    double rest = 0.0;        // what is left of the random number: uniform in [0, 1) again
  };

  void add_punctuals(const LightSetInput& input);
  void add_punctual(Punctual light, const std::string& name, const LightFrame& first,
                    const std::vector<LightFrame>& later);
  void prepare_shapes();
  [[nodiscard]] EmitterBounds punctual_bounds(const Punctual& light) const;
  [[nodiscard]] Shares shares(const V3f& point, const V3f& normal, const LightProbabilities* learned) const;
  void share_as_learned(const V3f& normal, const LightProbabilities& learned, Shares& shares) const;
  [[nodiscard]] static float directional_irradiance(const Punctual& light, const V3f& normal);
  [[nodiscard]] float environment_probability(const V3f& point, const V3f& normal,
                                              const LightProbabilities* learned) const;
  [[nodiscard]] float tree_probability(const V3f& point, const V3f& normal, const LightProbabilities* learned) const;
  [[nodiscard]] std::optional<Choice> choose_kind(const LightQuery& query) const;
  // `emitter`: where the tree's choice by choice.rest ended, if the kind is tree.
  [[nodiscard]] std::optional<LightSample> sample_chosen(const LightQuery& query, const Choice& choice,
                                                         const std::optional<LightTree::Choice>& emitter) const;
  [[nodiscard]] std::optional<LightSample> sample_triangle(uint32_t index, const V3f& point, const V2f& u,
                                                           float time) const;
  [[nodiscard]] bool moves(uint32_t triangle) const { return triangle >= first_moving_; }
  [[nodiscard]] Triangle posed_triangle(uint32_t index, float time) const; // one that moves
  // Key 0 first.
  [[nodiscard]] Triangle triangle_at_key(uint32_t index, uint32_t key) const;
  [[nodiscard]] EmitterBounds moving_bounds(uint32_t index) const;
  // Punctual lights, punctual_samples.cpp. `number`: index into punctuals_. u: on a light that has a size.
  [[nodiscard]] std::optional<LightSample> sample_punctual(uint32_t number, const V3f& point, const V2f& u,
                                                           float time) const;
  [[nodiscard]] std::optional<LightSample> sample_posed(const Punctual& light, const V3f& point, const V2f& u) const;
  [[nodiscard]] Punctual posed(const Punctual& light, float time) const;
  // `share` times what is left of the intensity in the direction -wi and at this distance from the center.
  [[nodiscard]] float emitted_share(const Punctual& light, const V3f& wi, float distance, float share) const;
  void add_sphere(uint32_t number, const ShapeRay& ray, Rgb& sum) const;
  void add_disc(uint32_t number, const ShapeRay& ray, Rgb& sum) const;
  // Averages the emission of a triangle over its area.
  [[nodiscard]] Rgb mean_emission(uint32_t index) const;
  [[nodiscard]] Rgb emission_at(uint32_t index, float u, float v) const;
  // What its coat lets out on a side, at a cosine to the normal.
  [[nodiscard]] static float through_coat(const Emission& emission, bool front, float cos_theta) {
    return emission.clearcoat > 0.0f && (front || emission.coated_back)
               ? coat_transmittance(emission.clearcoat, cos_theta)
               : 1.0f;
  }

  std::vector<Emission> emissions_;
  HugePageVector<Triangle> triangles_;
  std::vector<V2f> uvs_;           // three per triangle, or empty
  uint32_t first_moving_ = 0;      // triangles from here on move
  std::vector<CornerKeys> moving_; // theirs
  std::vector<std::array<V3f, 3>> later_corners_;
  std::vector<Punctual> punctuals_; // points, spots and profiled ones, which are in the tree, then directional lights
  std::vector<ProfiledLight> profiled_;
  std::vector<EmissiveMesh> meshes_;
  std::vector<std::string> punctual_names_;
  std::vector<LightFrame> frames_; // of punctual lights that move
  SphereTree spheres_;             // of punctual lights that have a radius; ids are indices into punctuals_
  std::vector<uint32_t> discs_;    // directional lights that have an angle; likewise
  bool has_shapes_ = false;
  size_t first_directional_ = 0;
  LightTree tree_;                                 // of triangles, then points and spots
  std::shared_ptr<const Environment> environment_; // null if absent
  float environment_irradiance_ = 0.0f;            // luminance, on a plane in the open, the mean over its directions
  bool single_kind_ = false;                       // nothing, only the tree or only the environment: shares are 0 and 1
  size_t light_count_ = 0;
};

// How the tree, the environment and each directional light share the samples at a point: in proportion to this weight,
// given the unoccluded irradiance that each would bring there, and the largest of them: in proportion to it, down to a floor
// of 1/19, for what is in between is not known. So of two the lesser has at least 0.05 of the samples. Zero has no weight.
[[nodiscard]] inline float light_share_weight(float irradiance, float strongest) {
  if (!(irradiance > 0.0f)) return 0.0f;
  return std::clamp(irradiance / strongest, 1.0f / 19.0f, 1.0f);
}

} // namespace kindling
