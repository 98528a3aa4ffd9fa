// A path tracer as in a first lesson: one path at a time, no light is chosen, nothing is weighted by more than its density.
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

// Where much light is known to come from; wrong ones cost noise alone.
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

// Shares with the renderer what turns a ray into a surface, the BSDF and the radiance of lights; has its own random numbers
// (none stratified), chooses directions by itself, and knows nothing of the choice of lights, multiple importance sampling, roulette or
// batches. Half of the directions follow the BSDF, the others aim, uniformly; with one density for both, that of the mixture.
// Point, spot and directional lights are found if they have a size; media do not stand in one another, scatter or disperse.
class PlainTracer {
 public:
  PlainTracer(const World& world, std::vector<Aim> aims, int max_bounces)
      : world_(world), aims_(std::move(aims)), max_bounces_(max_bounces) {}

  [[nodiscard]] Rgb radiance(accel::Ray ray, Random& random) const;
  // Three floats for each pixel: means of `samples` of them, evenly spread over the pixel's square.
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
