// Computes the Whitted tracer's ambient color, traced shares and mirror reflectance.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/whitted_terms.h"

#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/ggx_albedo.h"

namespace kindling {
namespace {

// Perceptual roughness up to which a reflection is traced wholly, and from which on not at all.
constexpr float kMirror = 0.3f;
constexpr float kNoMirror = 0.6f;

float traced_share(float roughness) {
  const float x = saturate((kNoMirror - roughness) * (1.0f / (kNoMirror - kMirror)));
  return x * x * (3.0f - 2.0f * x);
}

// Returns the mean albedo of the microfacets over all directions.
Rgb mean_albedo(const GgxAlbedo& mean, const Rgb& f0, float f90) { return f0 * (mean.e - mean.b) + Rgb(f90 * mean.b); }

} // namespace

WhittedTerms whitted_terms(const SurfacePoint& surface, const Rgb& ambient) {
  const BsdfParameters& p = surface.bsdf;
  const Rgb base_color = saturate(p.base_color);
  const float metallic = saturate(p.metallic);
  const float specular = saturate(p.specular);
  const float roughness = saturate(p.roughness);
  const Rgb dielectric_f0 = saturate(p.specular_color * dielectric_reflectance(p.ior)) * specular;
  const GgxAlbedo mean = ggx_average_albedo(std::max(roughness, kMinRoughness));
  const Rgb dielectric_mean = mean_albedo(mean, dielectric_f0, specular);
  const float dielectric = 1.0f - metallic;

  WhittedTerms terms;
  terms.smooth = roughness <= kStraightRoughness;
  Rgb diffuse = base_color;
  float opaque = 1.0f; // of the dielectric
  if (surface.layered) {
    const LayerParameters& layers = surface.layers.bsdf;
    const float through = saturate(layers.diffuse_transmission);
    diffuse = base_color * (1.0f - through) + saturate(layers.diffuse_transmission_color) * through;
    opaque = 1.0f - saturate(layers.transmission);
    terms.smooth &= layers.anisotropy == 0.0f;
    terms.glass_share = dielectric * (1.0f - opaque) > 0.0f ? 1.0f : 0.0f;
  }
  const bool reflects = metallic > 0.0f || max_component(dielectric_f0) > 0.0f || specular > 0.0f;
  terms.mirror_share = reflects && metallic + dielectric * opaque > 0.0f ? traced_share(roughness) : 0.0f;
  const Rgb glossy_mean = dielectric_mean * (dielectric * opaque) + mean_albedo(mean, base_color, 1.0f) * metallic;
  Rgb ambient_color = diffuse * (dielectric * opaque * (1.0f - max_component(dielectric_mean))) +
                      glossy_mean * (1.0f - terms.mirror_share);

  const Rgb f0 = dielectric_f0 * dielectric + base_color * metallic;
  terms.mirror_f0 = f0 * terms.mirror_share;
  terms.mirror_slope = (Rgb(specular * dielectric + metallic) - f0) * terms.mirror_share;
  if (const float coat = surface.layered ? saturate(surface.layers.bsdf.clearcoat) : 0.0f; coat > 0.0f) {
    const float coat_roughness = saturate(surface.layers.bsdf.clearcoat_roughness);
    const float coat_mean =
        coat * mean_albedo(ggx_average_albedo(std::max(coat_roughness, kMinRoughness)), Rgb(0.04f), 1.0f).x;
    terms.coat_mirror_share = traced_share(coat_roughness);
    terms.coat_smooth = coat_roughness <= kStraightRoughness;
    ambient_color = ambient_color * (1.0f - coat_mean) + Rgb(coat_mean * (1.0f - terms.coat_mirror_share));
  }
  terms.ambient = ambient * ambient_color;
  terms.traced = terms.mirror_share > 0.0f || terms.coat_mirror_share > 0.0f || terms.glass_share > 0.0f;
  return terms;
}

} // namespace kindling
