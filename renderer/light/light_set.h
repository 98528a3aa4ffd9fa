// All lights of a World behind one pair of questions: sample one from here, and how likely was that.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/light/environment.h"
#include "renderer/light/light_sample.h"
#include "renderer/texture/texture.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

// What a family of emissive triangles emits: radiance = factor * texture(uv), on the front face or on both.
struct Emission {
  Rgb factor{0.0f};                 // W / (sr m^2), emissive strength multiplied in
  const Texture* texture = nullptr; // sRGB-decoded emission; borrowed, null: factor alone
  bool two_sided = false;           // false: emits on the side where p0, p1, p2 are counter-clockwise
};

// World space. The triangle's uv are already transformed for the texture.
struct EmissiveTriangle {
  V3f p0, p1, p2;
  uint32_t emission = 0; // index into LightSetInput::emissions
};

struct PointLight {
  V3f position;
  Rgb intensity; // candela per channel
  std::optional<float> range_m;
};
struct SpotLight {
  V3f position;
  V3f axis;      // unit, where it shines
  Rgb intensity; // candela per channel, on the axis
  float cos_inner = 1.0f;
  float cos_outer = 0.0f; // < cos_inner
  std::optional<float> range_m;
};
struct DirectionalLight {
  V3f direction;  // unit, where it shines
  Rgb irradiance; // lux per channel, on a surface facing it
};

struct LightSetInput {
  std::vector<Emission> emissions;
  std::vector<EmissiveTriangle> triangles;
  std::vector<V2f> triangle_uvs; // empty, or three per triangle
  std::vector<PointLight> points;
  std::vector<SpotLight> spots;
  std::vector<DirectionalLight> directionals;
  std::shared_ptr<const Environment> environment; // may be null
  V3f scene_center{0.0f};
  float scene_radius_m = 1.0f; // for the power of infinite lights
};

// Immutable, thread-safe, without allocation after construction. Lights are chosen in proportion to their estimated
// power; the environment has a share of its own (environment_share()). Lights without power are never chosen.
//
// Triangles nearer than twice their longest edge are sampled uniformly by solid angle, others by area. The
// choice is a function of triangle and point alone, so that pdf_triangle() can repeat it.
class LightSet {
 public:
  explicit LightSet(LightSetInput input);

  [[nodiscard]] bool empty() const { return light_count_ == 0; }

  // A light and a direction to it, seen from `point`. `normal` (unit) is a hint for choosing well; light from both
  // sides is always offered. u_light in [0, 1), u in [0, 1)^2. Empty: nothing useful (counts as zero). Point, spot and
  // directional lights follow KHR_lights_punctual, with its window for `range_m`.
  [[nodiscard]] std::optional<LightSample> sample(const V3f& point, const V3f& normal, float u_light,
                                                  const V2f& u) const;

  // The density with which sample() from `point` would have produced this hit of emissive triangle number `triangle`
  // (the order of LightSetInput::triangles), solid angle, choice included. `wi` unit from point to the hit at
  // `distance`. Says nothing about the side: where the triangle is dark, emitted() is black.
  [[nodiscard]] float pdf_triangle(uint32_t triangle, const V3f& point, const V3f& wi, float distance) const;
  // The same for leaving the scene along wi.
  [[nodiscard]] float pdf_environment(const V3f& wi) const {
    return environment_ ? environment_->pdf(wi) * environment_probability_ : 0.0f;
  }

  // Radiance that triangle number `triangle` sends back along -wi from barycentrics (u, v). Black on a dark side.
  [[nodiscard]] Rgb emitted(uint32_t triangle, float u, float v, const V3f& wi) const;
  [[nodiscard]] Rgb environment_radiance(const V3f& wi) const { // black without an environment
    return environment_ ? environment_->radiance(wi) : Rgb(0.0f);
  }
  // environment_radiance() and pdf_environment() from one look-up.
  [[nodiscard]] EnvironmentEval environment_eval(const V3f& wi) const {
    if (!environment_) return {};
    EnvironmentEval eval = environment_->eval(wi);
    eval.pdf *= environment_probability_;
    return eval;
  }
  [[nodiscard]] const Environment* environment() const { return environment_.get(); }

  // Lights that can be chosen, each emissive triangle one.
  [[nodiscard]] size_t light_count() const { return light_count_; }
  [[nodiscard]] size_t memory_bytes() const;

 private:
  // 48 bytes per triangle, and 5 of the distribution; 24 more if any emission is textured.
  struct Triangle {
    V3f p0;
    uint32_t emission;
    V3f p1;
    float probability; // of being chosen
    V3f p2;
    float padding;
  };
  static_assert(sizeof(Triangle) == 48);
  // Point, spot and directional lights.
  struct Punctual {
    enum class Kind : uint32_t { point, spot, directional } kind;
    V3f position;
    V3f axis;                   // where it shines
    Rgb intensity;              // irradiance for directional lights
    float inverse_range = 0.0f; // 0: unlimited
    float angle_scale = 0.0f;   // spot: falloff = clamp(cos * angle_scale + angle_offset, 0, 1)^2
    float angle_offset = 1.0f;
    float probability = 0.0f;
  };
  struct Chosen {
    uint32_t light; // triangles first, then punctual lights, then the environment
    V2f u;          // what is left of u
  };

  void build_distribution(std::span<const float> weights);
  [[nodiscard]] Chosen choose(float u_light, const V2f& u) const;
  [[nodiscard]] float probability(uint32_t light) const;
  void set_probability(uint32_t light, float value);
  [[nodiscard]] std::optional<LightSample> sample_triangle(uint32_t index, const V3f& point, const V2f& u) const;
  [[nodiscard]] static std::optional<LightSample> sample_punctual(const Punctual& light, const V3f& point);
  // Averages the emission of a triangle over its area.
  [[nodiscard]] Rgb mean_emission(uint32_t index) const;
  [[nodiscard]] Rgb emission_at(uint32_t index, float u, float v) const;

  std::vector<Emission> emissions_;
  std::vector<Triangle> triangles_;
  std::vector<V2f> uvs_; // three per triangle, or empty
  std::vector<Punctual> punctuals_;
  std::shared_ptr<const Environment> environment_; // null if absent
  float environment_probability_ = 0.0f;
  size_t light_count_ = 0;

  // One cell for each run of 2^run_shift_ lights: 1 light, unless there are more than a million.
  std::vector<float> cdf_;
  std::vector<uint32_t> guide_;
  uint32_t guide_size_ = 1;
  uint32_t run_shift_ = 0;
};

// Share of the samples that goes to the environment, given its power and that of all other lights in the same unit: 0
// or 1 where one of them has none; one half if they are within a factor of 100; then it slides, over another factor of
// 10, to 0.05 for the lesser and 0.95 for the greater. (Power alone is a poor guide here: most of an environment may
// not come in.)
[[nodiscard]] float environment_share(double environment_power, double other_power);

} // namespace kindling
