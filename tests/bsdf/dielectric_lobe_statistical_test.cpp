// Statistical tests of the dielectric lobe: sampling against its pdf, white furnace, albedos.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_lobe.h"
#include "renderer/bsdf/layer_parameters.h"

#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/chi_square.h"

#include "renderer/sampling/warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace kindling {
namespace {

using test::Random;
using test::view;

DielectricParameters interface(float roughness, float eta, bool thin_walled = false) {
  DielectricParameters p;
  p.alpha_x = p.alpha_y = roughness * roughness;
  p.eta = eta;
  p.thin_walled = thin_walled;
  return p;
}

std::string describe_interface(const DielectricParameters& p, float mu) {
  return "alpha " + std::to_string(p.alpha_x) + " " + std::to_string(p.alpha_y) + " eta " + std::to_string(p.eta) +
         " specular " + std::to_string(p.specular) + (p.thin_walled ? " thin" : "") + " mu " + std::to_string(mu);
}

std::vector<DielectricParameters> interface_grid() {
  std::vector<DielectricParameters> all;
  for (const float eta : {1.5f, 1.0f / 1.5f, 1.05f, 1.0f / 1.05f, 2.4f}) {
    for (const float roughness : {0.1f, 0.35f, 1.0f}) all.push_back(interface(roughness, eta));
  }
  for (const float eta : {1.5f, 1.0f / 1.5f}) {
    DielectricParameters p = interface(0.3f, eta);
    p.alpha_x = 0.5f;
    p.tint = {0.8f, 0.4f, 0.2f};
    p.specular_color = {0.5f, 1.0f, 2.0f};
    all.push_back(p);
    p.thin_walled = true;
    all.push_back(p);
    p = interface(0.3f, eta); // KHR_materials_anisotropy at full strength
    p.alpha_x = 1.0f;
    all.push_back(p);
    p = interface(0.3f, eta);
    p.iridescence = 1.0f;
    p.film_ior = 1.8f;
    all.push_back(p);
  }
  for (const float roughness : {0.0f, 0.1f, 0.5f}) all.push_back(interface(roughness, 1.5f, true));
  return all;
}

// Tests each hemisphere of the sphere in the stereographic plane, where narrow lobes stay round.
// Samples on the other side count as absorbed, with the probability that the density leaves over.
TEST(DielectricLobeStatistical, SamplingMatchesPdf) {
  const std::vector<DielectricParameters> all = interface_grid();
  constexpr float kViews[] = {0.95f, 0.5f, 0.1f};
  constexpr int kSamples = 40000;
  const double level = test::sidak_level(0.01, static_cast<int>(2 * all.size() * std::size(kViews)));
  uint64_t seed = 100;
  for (const DielectricParameters& p : all) {
    for (const float mu : kViews) {
      const DielectricLobe lobe(p, view(mu, 0.3f));
      double lost = 0.0, integral = 0.0, error = 0.0;
      for (const float side : {1.0f, -1.0f}) {
        ++seed;
        if (p.alpha_x < 0.001f && (side < 0.0f || mu < 0.3f)) continue; // floats do not resolve the lobe on the plane
        const auto draw = [&](Random& random) -> std::optional<V3f> {
          const float u = random.next_1d();
          const auto s = lobe.sample(u, random.next_2d());
          if (!s || s->wi.z * side < 0.0f) return std::nullopt;
          return V3f(s->wi.x, s->wi.y, s->wi.z * side);
        };
        test::ChiSquareOptions options = {.seed = seed,
                                          .pilot_samples = 8192,
                                          .samples = kSamples,
                                          .bins = 96,
                                          .min_extent = 2e-5,
                                          .may_be_absorbed = true};
        const auto result = test::chi_square_hemisphere(
            draw,
            [&](const V3f& w) {
              return lobe.eval({w.x, w.y, w.z * side}).pdf;
            },
            options);
        EXPECT_GT(result.p_value, level) << describe_interface(p, mu) << " side " << side << ": " << result.summary;
        lost += side > 0.0f ? result.absorbed : result.absorbed - 1.0;
        integral += result.integral;
        error += result.absorbed * (1.0 - result.absorbed) / kSamples;
      }
      if (p.alpha_x < 0.001f) continue;
      // The integral of the density and the lost fraction make up all draws.
      EXPECT_NEAR(integral + lost, 1.0, 4.0 * std::sqrt(error) + 2e-3) << describe_interface(p, mu);
    }
  }
}

struct Passed {
  Rgb up{0.0f};
  Rgb down{0.0f};
  double error = 0.0; // standard error of the red channel of their sum
};

Passed mean_passed(const DielectricLobe& lobe, uint64_t seed, int samples) {
  Random random(seed);
  double up[3] = {0.0, 0.0, 0.0};
  double down[3] = {0.0, 0.0, 0.0};
  double squares = 0.0;
  for (int i = 0; i < samples; ++i) {
    const float u = random.next_1d();
    const auto s = lobe.sample(u, random.next_2d());
    if (!s) continue;
    for (int c = 0; c < 3; ++c) (s->wi.z > 0.0f ? up : down)[c] += static_cast<double>(s->weight[c]);
    squares += static_cast<double>(s->weight.x) * static_cast<double>(s->weight.x);
  }
  Passed mean;
  for (int c = 0; c < 3; ++c) {
    mean.up[c] = static_cast<float>(up[c] / samples);
    mean.down[c] = static_cast<float>(down[c] / samples);
  }
  const double sum = (up[0] + down[0]) / samples;
  mean.error = std::sqrt(std::max(squares / samples - sum * sum, 0.0) / samples);
  return mean;
}

// Returns the relative error of the tables on a white interface: README.md.
double table_error(const DielectricParameters& p) { return p.thin_walled ? 3e-3 : p.eta > 1.0f ? 0.012 : 0.03; }

TEST(DielectricLobeStatistical, WhiteFurnace) {
  uint64_t seed = 1000;
  for (const float eta : {1.05f, 1.33f, 1.5f, 2.4f, 1.0f / 1.05f, 1.0f / 1.33f, 1.0f / 1.5f, 1.0f / 2.4f}) {
    for (const bool thin_walled : {false, true}) {
      if (thin_walled && eta < 1.0f) continue;
      for (const float roughness : {0.0f, 0.05f, 0.2f, 0.5f, 0.8f, 1.0f}) {
        if (thin_walled && roughness == 0.0f) continue;
        for (const float specular : {1.0f, 0.4f}) {
          for (const float mu : {1.0f, 0.6f, 0.2f, 0.05f}) {
            DielectricParameters p = interface(roughness, eta, thin_walled);
            p.specular = specular;
            const DielectricLobe lobe(p, view(mu, 0.1f));
            const Passed mean = mean_passed(lobe, seed++, 5000);
            EXPECT_NEAR(static_cast<double>(mean.up.x + mean.down.x), 1.0, table_error(p) + 4.5 * mean.error)
                << describe_interface(p, mu) << " seed " << seed - 1;
            EXPECT_NEAR(lobe.reflected_albedo().x + lobe.transmitted_albedo().x, 1.0f, 1e-5f);
          }
        }
      }
    }
  }
}

// Tinted, colored and with a film: never above 1; the estimates are close to the sampled albedos.
TEST(DielectricLobeStatistical, ConservesEnergy) {
  Random random(9);
  for (uint64_t i = 0; i < 300; ++i) {
    const V2f drawn = random.next_2d();
    DielectricParameters p = interface(drawn.x, 1.02f + 1.4f * drawn.y, i % 3 == 0);
    if (i % 2 == 1) p.eta = 1.0f / p.eta;
    p.specular = random.next_1d();
    p.specular_color = {3.0f * random.next_1d(), 3.0f * random.next_1d(), 3.0f * random.next_1d()};
    p.tint = {random.next_1d(), random.next_1d(), random.next_1d()};
    p.iridescence = i % 4 == 0 ? random.next_1d() : 0.0f;
    const float mu = std::max(random.next_1d(), 0.02f);
    const DielectricLobe lobe(p, view(mu, random.next_1d()));
    const Passed mean = mean_passed(lobe, 5000 + i, 4000);
    const Rgb all = mean.up + mean.down + lobe.straight_transmittance();
    EXPECT_LT(static_cast<double>(max_component(all)), 1.0 + 0.03 + 5.0 * mean.error + 5e-3)
        << describe_interface(p, mu);
    if (p.eta < 1.0f) continue;
    for (int c = 0; c < 3; ++c) {
      const double tolerance = (p.iridescence > 0.0f ? 0.2 : 0.03) + 5.0 * mean.error; // the film is not in the tables
      EXPECT_NEAR(static_cast<double>(mean.up[c]), static_cast<double>(lobe.reflected_albedo()[c]), tolerance)
          << describe_interface(p, mu) << " iridescence " << p.iridescence;
      EXPECT_NEAR(static_cast<double>(mean.down[c]), static_cast<double>(lobe.transmitted_albedo()[c]), tolerance)
          << describe_interface(p, mu) << " iridescence " << p.iridescence;
    }
  }
}

// The error of the quadrature for anisotropic facets: anisotropic_interface.h.
TEST(DielectricLobeStatistical, AnisotropicFurnace) {
  uint64_t seed = 9000;
  for (const float eta : {1.5f, 1.0f / 1.5f}) {
    for (const float alpha_x : {0.5f, 1.0f}) {
      for (const float mu : {1.0f, 0.5f, 0.15f}) {
        for (const float azimuth : {0.0f, 0.13f, 0.25f}) {
          DielectricParameters p = interface(0.4f, eta);
          p.alpha_x = alpha_x;
          const DielectricLobe lobe(p, view(mu, azimuth));
          const Passed mean = mean_passed(lobe, seed++, 20000);
          const double quadrature = eta > 1.0f ? 0.005 : 0.02;
          EXPECT_NEAR(static_cast<double>(mean.up.x + mean.down.x), 1.0, quadrature + 4.5 * mean.error)
              << describe_interface(p, mu) << " " << azimuth;
          EXPECT_NEAR(static_cast<double>(mean.up.x), static_cast<double>(lobe.reflected_albedo().x),
                      quadrature + 4.5 * mean.error)
              << describe_interface(p, mu) << " " << azimuth;
        }
      }
    }
  }
}

// Follows light through a solid sphere until it leaves. Chords of a sphere meet it at one angle;
// the azimuth of the microfacets is random at each end.
TEST(DielectricLobeStatistical, GlassSphereKeepsItsLight) {
  constexpr int kPaths = 200000;
  uint64_t seed = 12000;
  for (const float alpha : {0.04f, 0.25f}) {
    for (const float alpha_x : {alpha, lerp(alpha, 1.0f, 0.25f), 1.0f}) { // anisotropy of 0, 0.5 and 1
      Random random(seed++);
      double sum = 0.0, squares = 0.0;
      for (int i = 0; i < kPaths; ++i) {
        DielectricParameters p;
        p.alpha_x = alpha_x;
        p.alpha_y = alpha;
        double weight = 1.0;
        float mu = std::sqrt(random.next_1d());
        for (int bounce = 0; bounce < 300; ++bounce) {
          const DielectricLobe lobe(p, view(mu, random.next_1d()));
          const float u = random.next_1d();
          const auto s = lobe.sample(u, random.next_2d());
          weight *= s ? static_cast<double>(s->weight.x) : 0.0;
          if (!s || (p.eta > 1.0f) == (s->wi.z > 0.0f)) break; // lost, or outside
          mu = std::abs(s->wi.z);
          p.eta = 1.0f / 1.5f;
        }
        sum += weight / kPaths;
        squares += weight * weight / kPaths;
      }
      const double error = std::sqrt((squares - sum * sum) / kPaths);
      EXPECT_NEAR(sum, 1.0, 0.003 + 3.5 * error) << alpha_x << " " << alpha << " +- " << error;
      EXPECT_LT(error, 0.003);
    }
  }
}

} // namespace
} // namespace kindling
