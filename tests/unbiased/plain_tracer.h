// A textbook path tracer as a reference: one path at a time, without next-event estimation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/frame.h"
#include "renderer/bsdf/surface_bsdf.h"
#include "renderer/camera/camera.h"
#include "renderer/world/world.h"
#include "tests/sampling/random.h"

#include <span>
#include <variant>
#include <vector>

namespace kindling::test {

// Regions that emit much light. Wrong ones only increase the noise.
struct AimRectangle {
  V3f corner, edge_u, edge_v; // edges at right angles
};
struct AimCone {
  V3f axis; // unit
  float one_minus_cos = 0.0f;
};
struct AimSphere {
  V3f center;
  float radius = 0.0f;
};
using Aim = std::variant<AimRectangle, AimCone, AimSphere>;

// It shares with the renderer the evaluation of surfaces, the BSDF and the radiance of lights. It
// has its own unstratified random numbers and sampling of directions, and no choice of lights,
// multiple importance sampling, roulette or batches. Half of the directions are sampled from the
// BSDF, the others uniformly from the aims; both use the density of the mixture. Point, spot and
// directional lights are found if they have a size. Nested, scattering and dispersive media are
// unsupported.
class PlainTracer {
 public:
  PlainTracer(const World& world, std::vector<Aim> aims, int max_bounces)
      : world_(world), aims_(std::move(aims)), max_bounces_(max_bounces) {}

  [[nodiscard]] Rgb radiance(accel::Ray ray, Random& random) const;
  // Returns three floats for each pixel: the mean of `samples` samples, distributed uniformly over
  // the pixel's square.
  [[nodiscard]] std::vector<float> image(const Camera& camera, uint32_t samples, uint64_t seed) const;

 private:
  struct Direction {
    V3f wi;               // unit
    Rgb weight{0.0f};     // BSDF times cosine over density; black: the path ends
    bool crosses = false; // to the other side of the surface
  };
  [[nodiscard]] Direction choose_direction(const SurfacePoint& surface, const Frame& frame, const SurfaceBsdf& bsdf,
                                           Random& random) const;
  [[nodiscard]] float aim_density(const V3f& point, const V3f& wi) const;

  const World& world_;
  std::vector<Aim> aims_;
  int max_bounces_; // as IntegratorSettings::max_bounces
};

} // namespace kindling::test
