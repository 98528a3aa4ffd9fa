// Light that a path finds through a smooth surface after it was scattered widely: kept, widened, or left out.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layer_parameters.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

// A path tracer finds such light only where a bounce happens to lead it into a narrow lobe that sees a small light:
// rarely, and then much of it.
enum class Caustics : uint8_t {
  full,        // as the scene asks: unbiased
  regularized, // narrow lobes are widened; the more samples, the less: biased, consistent
  off,         // surfaces seen after a diffuse bounce reflect diffusely alone: biased
};
[[nodiscard]] std::string_view caustics_name(Caustics caustics);
[[nodiscard]] std::optional<Caustics> caustics_from_name(std::string_view name);

// The widest lobe that has scattered a path so far, as alpha = roughness^2 in [0, 1], in a byte of the path's record.
class WidestLobe {
 public:
  void add(Lobe lobe, float roughness) {
    const float alpha = lobe == Lobe::diffuse ? 1.0f : std::min(roughness * roughness, 1.0f);
    steps_ = std::max(steps_, static_cast<uint8_t>(alpha * 255.0f + 0.5f));
  }
  [[nodiscard]] float alpha() const { return static_cast<float>(steps_) * (1.0f / 255.0f); }

 private:
  uint8_t steps_ = 0;
};

// The least alpha of lobes behind one of alpha `widest`, in sample `sample_index` of a pixel:
// 0.3 widest (sample_index + 1)^(-1/6). Wide lobes hide what widening blurs (Jendersie and Grosch 2019, "Microfacet Model
// Regularization for Robust Light Transport"; pbrt-v4's 0.3); a bandwidth that shrinks like n^(-1/6) lets the mean of all
// samples converge (Kaplanyan and Dachsbacher 2013, "Path Space Regularization for Holistic and Robust Light Transport").
// It depends on the sample's number alone, so it does not matter where or in which order samples are taken.
[[nodiscard]] float regularized_alpha(float widest, uint32_t sample_index);

// Changes the parameters of a surface that a path has reached; `after_diffuse`: it was scattered diffusely before.
// Off: what is specular reflects nothing (as with Cycles' "Reflective Caustics" off), so metal is black, and the base of a
// dielectric gets the light that its surface would have reflected; what a surface would refract it absorbs. ThinWalls, which
// bend no light, keep what goes straight on.
void regularize_caustics(Caustics caustics, bool after_diffuse, const WidestLobe& widest, uint32_t sample_index,
                         BsdfParameters& parameters);
// The same for the layers of a surface that has some; `thin wall`: light passes it in a straight line (SurfaceLayers::thin wall).
void regularize_caustics(Caustics caustics, bool after_diffuse, const WidestLobe& widest, uint32_t sample_index,
                         bool thin_wall, BsdfParameters& parameters, LayerParameters& layers);

} // namespace kindling
