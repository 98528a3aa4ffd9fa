// White furnaces of films on dielectrics: what the extension's mix loses, and nothing else.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/film_layer.h"
#include "renderer/bsdf/ggx_lobe.h"

#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::LayeredMaterial;
using test::mean_weight;
using test::MeanWeight;
using test::Random;
using test::view;

LayeredMaterial film_on_white(float roughness, float ior, float nm, float coat_roughness, float anisotropy) {
  LayeredMaterial m;
  m.base.metallic = 0.0f;
  m.base.roughness = roughness;
  m.layers.iridescence = 1.0f;
  m.layers.iridescence_ior = ior;
  m.layers.iridescence_thickness_nm = nm;
  m.layers.anisotropy = anisotropy;
  m.layers.clearcoat = coat_roughness < 0.0f ? 0.0f : 1.0f;
  m.layers.clearcoat_roughness = std::max(coat_roughness, 0.0f);
  return m;
}

// Returns S, the albedo of single scattering with the film's Fresnel and of multiple scattering
// (Kulla and Conty 2017).
Rgb film_reflectance(const LayeredMaterial& m, const V3f& wo, Random& random, int samples) {
  const float alpha = std::max(square(m.base.roughness), kMinAlpha);
  const float alpha_x = lerp(alpha, 1.0f, square(m.layers.anisotropy));
  const GgxLobe lobe(alpha_x, alpha, wo);
  const FilmLayer film(m.layers, Rgb(0.04f));
  Rgb single(0.0f);
  float e = 0.0f;
  for (int i = 0; i < samples; ++i) {
    const V3f wi = lobe.sample(random.next_2d());
    if (!(wi.z > 0.0f)) continue;
    const GgxLobe::Eval eval = lobe.eval(wi);
    const float weight = eval.value / (eval.pdf * static_cast<float>(samples));
    single += film.fresnel(std::min(eval.cos_d, 1.0f)) * weight;
    e += weight;
  }
  constexpr int kSteps = 200;
  Rgb mean(0.0f);
  for (int k = 0; k < kSteps; ++k)
    mean += film.fresnel(std::sqrt((static_cast<float>(k) + 0.5f) / kSteps)) / static_cast<float>(kSteps);
  const float mean_e = m.layers.anisotropy > 0.0f ? anisotropic_average_albedo(std::sqrt(alpha_x), std::sqrt(alpha)).e
                                                  : ggx_average_albedo(std::sqrt(alpha)).e;
  Rgb multiple;
  for (int c = 0; c < 3; ++c) multiple[c] = mean[c] * mean[c] * mean_e / (1.0f - mean[c] * (1.0f - mean_e));
  return single + multiple * (1.0f - e);
}

// KHR_materials_iridescence, "rgb_mix": the base gets 1 - max(S) in all channels, so a channel
// loses max(S) - S of the light that passes the coat.
TEST(FilmFurnace, ChannelsLoseTheirDistanceToTheBrightest) {
  constexpr int kViews = 48;
  constexpr int kSamples = 8000;
  uint64_t seed = 1;
  float worst = 0.0f, worst_brightest = 0.0f;
  for (const auto& [ior, nm] : {std::pair(1.0f, 400.0f), std::pair(1.0f, 150.0f), std::pair(1.3f, 250.0f),
                                std::pair(1.3f, 800.0f), std::pair(1.8f, 400.0f), std::pair(2.4f, 300.0f)}) {
    for (const float roughness : {0.0f, 0.3f, 0.6f, 1.0f}) {
      for (const float coat : {-1.0f, 0.0f, 1.0f}) {
        for (const float anisotropy : {0.0f, 1.0f}) {
          if (anisotropy > 0.0f && (roughness != 0.3f || coat > -1.0f)) continue;
          const LayeredMaterial m = film_on_white(roughness, ior, nm, coat, anisotropy);
          Random random(seed++);
          Rgb returned(0.0f), expected(0.0f), variance(0.0f);
          float brightest = 0.0f;
          for (int v = 0; v < kViews; ++v) { // as a sphere is seen
            const float mu = std::sqrt((static_cast<float>(v) + 0.5f) / kViews);
            const V3f wo = view(mu, std::fmod(static_cast<float>(v) * 0.618034f, 1.0f));
            const LayeredBsdf bsdf(m.base, m.layers, wo);
            const MeanWeight mean = mean_weight(bsdf, 1000 * seed + static_cast<uint64_t>(v), kSamples);
            const Rgb reflected = film_reflectance(m, wo, random, kSamples);
            returned += mean.value / kViews;
            variance += mean.error * mean.error / (kViews * kViews);
            brightest += max_component(mean.value) / kViews;
            expected += (Rgb(1.0f) - (Rgb(max_component(reflected)) - reflected) * bsdf.coat_transmittance()) / kViews;
          }
          const float error = std::sqrt(max_component(variance));
          EXPECT_LT(error, 1.2e-3f);
          // Anisotropic films are those of a mean alpha (README.md).
          const float tolerance = (anisotropy > 0.0f ? 5e-3f : 2.5e-3f) + 4.0f * error;
          EXPECT_NEAR(brightest, 1.0f, tolerance) << test::describe(m, 0.0f) << " seed " << seed - 1;
          worst_brightest = std::max(worst_brightest, std::abs(brightest - 1.0f));
          for (int c = 0; c < 3; ++c) {
            worst = std::max(worst, std::abs(returned[c] - expected[c]));
            EXPECT_NEAR(returned[c], expected[c], tolerance)
                << test::describe(m, 0.0f) << " channel " << c << " seed " << seed - 1;
          }
        }
      }
    }
  }
  RecordProperty("worst", std::to_string(worst));
  RecordProperty("worst_brightest", std::to_string(worst_brightest));
}

// The figures of renderer/bsdf/README.md: random films on a white dielectric, each from one
// direction, in the brightest channel; albedo() in all channels.
TEST(FilmFurnace, RandomFilmsStayWithinStatedError) {
  constexpr int kFilms = 200;
  constexpr int kSamples = 20000;
  for (const bool anisotropic : {false, true}) {
    Random random(8);
    double squares = 0.0, noise = 0.0, lowest = 0.0, highest = 0.0, albedo_squares = 0.0, albedo_worst = 0.0;
    for (uint64_t i = 0; i < kFilms; ++i) {
      LayeredMaterial m = test::whitened(test::random_material(random, 0.0f));
      LayerParameters layers;
      layers.iridescence = m.layers.iridescence;
      layers.iridescence_ior = m.layers.iridescence_ior;
      layers.iridescence_thickness_nm = m.layers.iridescence_thickness_nm;
      layers.anisotropy = anisotropic ? m.layers.anisotropy : 0.0f;
      m.layers = layers;
      m.base.metallic = 0.0f;
      const float mu = 0.01f + 0.99f * random.next_1d();
      const LayeredBsdf bsdf(m.base, m.layers, view(mu, random.next_1d()));
      const MeanWeight mean = mean_weight(bsdf, 2000 + i, kSamples);
      const auto error = static_cast<double>(max_component(mean.error));
      const double beyond = static_cast<double>(max_component(mean.value)) - 1.0;
      EXPECT_LT(beyond, (anisotropic ? 0.03 : 0.015) + 4.5 * error) << test::describe(m, mu);
      EXPECT_GT(beyond, -0.03 - 4.5 * error) << test::describe(m, mu);
      lowest = std::min(lowest, beyond);
      highest = std::max(highest, beyond);
      squares += beyond * beyond / kFilms;
      noise += error * error / kFilms;
      for (int c = 0; c < 3; ++c) {
        const auto off = static_cast<double>(bsdf.albedo()[c] - mean.value[c]);
        albedo_squares += off * off / (3.0 * kFilms);
        albedo_worst = std::max(albedo_worst, std::abs(off));
      }
    }
    EXPECT_LT(squares - noise, square(anisotropic ? 4e-3 : 2.5e-3));
    EXPECT_LT(albedo_squares, square(6e-3));
    RecordProperty(anisotropic ? "anisotropic" : "isotropic",
                   std::to_string(lowest) + " to " + std::to_string(highest) + " rms " +
                       std::to_string(std::sqrt(squares)) + " noise " + std::to_string(std::sqrt(noise)) +
                       " albedo rms " + std::to_string(std::sqrt(albedo_squares)) + " worst " +
                       std::to_string(albedo_worst));
  }
}

} // namespace
} // namespace kindling
