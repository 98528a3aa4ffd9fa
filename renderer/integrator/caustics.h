// Treatment of caustics, light found through a narrow lobe after a wide one: full, blurred or off.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

// A path tracer finds caustics only where a bounce happens to lead into a narrow lobe that reflects
// a small light: rarely, and then with a large contribution.
enum class Caustics : uint8_t {
  full,        // unbiased
  regularized, // narrow lobes are widened, less with every sample: biased but consistent
  off,         // after a diffuse bounce, surfaces reflect only diffusely: biased
};
[[nodiscard]] std::string_view caustics_name(Caustics caustics);
[[nodiscard]] std::optional<Caustics> caustics_from_name(std::string_view name);

// The widest lobe that has scattered a path so far, as alpha = roughness^2 in [0, 1], stored in one
// byte.
class WidestLobe {
 public:
  void add(Lobe lobe, float roughness) {
    const float alpha = lobe == Lobe::diffuse ? 1.0f : std::min(1.0f, roughness * roughness);
    steps_ = std::max(steps_, static_cast<uint8_t>(alpha * 255.0f + 0.5f));
  }
  [[nodiscard]] float alpha() const { return static_cast<float>(steps_) * (1.0f / 255.0f); }

 private:
  uint8_t steps_ = 0;
};

// Returns the minimum alpha of lobes behind one of alpha `widest`, in sample `sample_index` of a
// pixel: 0.3 widest (sample_index + 1)^(-1/6). Wide lobes hide the blur of widening (Jendersie and
// Grosch 2019, "Microfacet Model Regularization for Robust Light Transport"; pbrt-v4's 0.3); a
// bandwidth that shrinks like n^(-1/6) lets the mean of all samples converge (Kaplanyan and
// Dachsbacher 2013, "Path Space Regularization for Holistic and Robust Light Transport"). It
// depends on the sample's number alone, so the order in which samples are taken does not matter.
[[nodiscard]] float regularized_alpha(float widest, uint32_t sample_index);

// Changes the parameters of a surface that a path has reached. `after_diffuse`: the path was
// scattered diffusely before. Caustics::off removes specular reflection (as Cycles' "Reflective
// Caustics" off does): metal is black, and the base of a dielectric receives the light that its
// surface would have reflected. Refracted light is absorbed. Thin walls, which do not bend light,
// still transmit it.
void regularize_caustics(Caustics caustics, bool after_diffuse, const WidestLobe& widest, uint32_t sample_index,
                         BsdfParameters& parameters);
// The same for a surface with layers. `thin_wall`: light passes it in a straight line
// (SurfaceLayers::thin_wall).
void regularize_caustics(Caustics caustics, bool after_diffuse, const WidestLobe& widest, uint32_t sample_index,
                         bool thin_wall, BsdfParameters& parameters, LayerParameters& layers);

} // namespace kindling
