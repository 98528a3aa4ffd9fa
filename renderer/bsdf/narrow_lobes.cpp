// Densities and sampling of narrow lobes, by the choices of the BSDFs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/narrow_lobes.h"

#include <algorithm>

namespace kindling {

namespace {

using Choice = LayeredBsdf::Choice;
constexpr Choice kMicrofacets[] = {LayeredBsdf::kCoat, LayeredBsdf::kGlass, LayeredBsdf::kGlossy};

} // namespace

float narrow_share(const SurfaceBsdf& bsdf, const V3f& wi, float pdf, float max_alpha) {
  if (pdf == 0.0f) return bsdf.layers()->is_narrow(LayeredBsdf::kGlass, max_alpha) ? 1.0f : 0.0f;
  return std::min(bsdf.narrow_density(wi, pdf, max_alpha) / pdf, 1.0f);
}

float narrow_probability(const SurfaceBsdf& bsdf, float max_alpha) {
  const LayeredBsdf* const layers = bsdf.layers();
  if (!layers) return bsdf.alpha() <= max_alpha ? bsdf.cosine_begin() : 0.0f;
  float sum = 0.0f;
  for (const Choice choice : kMicrofacets)
    if (layers->is_narrow(choice, max_alpha)) sum += layers->choice_probability(choice);
  return sum;
}

std::optional<BsdfSample> sample_narrow(const SurfaceBsdf& bsdf, float u_lobe, const V2f& u, float max_alpha) {
  const float probability = narrow_probability(bsdf, max_alpha);
  if (!(probability > 0.0f)) return std::nullopt;
  float chosen = u_lobe * probability; // of the BSDF's own choice of lobes
  if (const LayeredBsdf* const layers = bsdf.layers()) {
    float rest = chosen;
    for (const Choice choice : kMicrofacets) {
      if (!layers->is_narrow(choice, max_alpha)) continue;
      const float width = layers->choice_probability(choice);
      chosen = layers->choice_begin(choice) + std::min(rest, width * kOneMinusEpsilon);
      if (rest < width) break;
      rest -= width;
    }
  }
  std::optional<BsdfSample> sampled = bsdf.sample(std::min(chosen, kOneMinusEpsilon), u);
  if (!sampled) return std::nullopt;
  if (sampled->pdf == 0.0f) {
    sampled->weight *= probability;
    return sampled;
  }
  const float density = bsdf.narrow_density(sampled->wi, sampled->pdf, max_alpha) / probability;
  if (!(density > 0.0f)) return std::nullopt;
  sampled->weight *= sampled->pdf / density;
  sampled->pdf = density;
  return sampled;
}

} // namespace kindling
