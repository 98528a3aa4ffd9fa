// Transmission through a thin film on glass, against Airy's sum with exact interfaces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_lobe.h"
#include "renderer/bsdf/thin_film.h"

#include "tests/bsdf/layered_materials.h"
#include "tests/bsdf/observer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace kindling {
namespace {

using test::Random;
using test::Vec;
using test::view;
using Complex = std::complex<double>;

constexpr double kPiD = std::numbers::pi;

// Fresnel's amplitudes of both polarizations, from the side of index `from`.
struct Amplitudes {
  double r[2], t[2];
  double cos_beyond;
};
Amplitudes fresnel_amplitudes(double from, double to, double cos_from) {
  const double cos_to = std::sqrt(1.0 - square(from / to) * (1.0 - cos_from * cos_from));
  const double s = from * cos_from + to * cos_to, p = to * cos_from + from * cos_to;
  return {{(from * cos_from - to * cos_to) / s, (to * cos_from - from * cos_to) / p},
          {2.0 * from * cos_from / s, 2.0 * from * cos_from / p},
          cos_to};
}

// A film between air and a base, seen from the air: Airy's sums of reflection and of transmission,
// each by itself.
struct AiryFilm {
  Amplitudes upper, lower;
  double opd_nm, flux; // of the transmitted light over that of its squared amplitude

  AiryFilm(double cos_theta, double film_ior, double base_ior, double thickness_nm)
      : upper(fresnel_amplitudes(1.0, film_ior, cos_theta)),
        lower(fresnel_amplitudes(film_ior, base_ior, upper.cos_beyond)),
        opd_nm(2.0 * film_ior * thickness_nm * upper.cos_beyond), flux(base_ior * lower.cos_beyond / cos_theta) {}

  [[nodiscard]] Complex turned(double nm) const { return std::polar(1.0, 2.0 * kPiD * opd_nm / nm); }
  [[nodiscard]] double reflectance(double nm) const {
    double sum = 0.0;
    for (const int i : {0, 1})
      sum += std::norm((upper.r[i] + lower.r[i] * turned(nm)) / (1.0 + upper.r[i] * lower.r[i] * turned(nm)));
    return 0.5 * sum;
  }
  [[nodiscard]] double transmittance(double nm) const {
    double sum = 0.0;
    for (const int i : {0, 1})
      sum += flux * std::norm(upper.t[i] * lower.t[i] / (1.0 + upper.r[i] * lower.r[i] * turned(nm)));
    return 0.5 * sum;
  }
  // Transmittance without interference: the limit of a thick film.
  [[nodiscard]] double mean_transmittance() const {
    double sum = 0.0;
    for (const int i : {0, 1}) {
      const double a = square(upper.r[i]), b = square(lower.r[i]);
      sum += (1.0 - a) * (1.0 - b) / (1.0 - a * b);
    }
    return 0.5 * sum;
  }
  // In Rec. 709, with a neutral mean as in KHR_materials_iridescence.
  [[nodiscard]] Vec transmitted_color() const {
    const double mean = mean_transmittance();
    Vec rgb = test::integrate_spectrum([&](double nm) { return transmittance(nm) - mean; });
    for (double& c : rgb) c += mean;
    return rgb;
  }
};

TEST(FilmTransmission, AirysSumsAddUpToOne) {
  for (const double ior : {1.2, 1.8, 2.4}) {
    for (const double cos_theta : {1.0, 0.6, 0.2}) {
      const AiryFilm film(cos_theta, ior, 1.5, 320.0);
      for (const double nm : {410.0, 532.0, 650.0})
        EXPECT_NEAR(film.reflectance(nm) + film.transmittance(nm), 1.0, 1e-12) << ior << " " << cos_theta << " " << nm;
    }
  }
}

DielectricParameters filmed_glass(float film_ior, float thickness_nm) {
  DielectricParameters p;
  p.iridescence = 1.0f;
  p.film_ior = film_ior;
  p.film_thickness_nm = thickness_nm;
  return p;
}

// The figures of renderer/bsdf/README.md: root mean square errors of the transmittance up to 60
// degrees, here, by rgb_mix() of the extension, and without the film.
TEST(FilmTransmission, IsThatOfAirysSum) {
  const struct {
    float film_ior;
    double error;
  } cases[] = {{1.2f, 0.006}, {1.33f, 0.007}, {1.8f, 0.016}, {2.4f, 0.019}};
  for (const auto& [film_ior, error] : cases) {
    double here = 0.0, mixed = 0.0, without = 0.0;
    int count = 0;
    for (const float cos_theta : {1.0f, 0.9f, 0.7f, 0.5f}) {
      for (float nm = 100.0f; nm < 900.0f; nm += 25.0f) {
        const Vec airy =
            AiryFilm(static_cast<double>(cos_theta), static_cast<double>(film_ior), 1.5, static_cast<double>(nm))
                .transmitted_color();
        const DielectricLobe glass(filmed_glass(film_ior, nm), view(cos_theta, 0.2f));
        const float plain = schlick_fresnel(0.04f, 1.0f, cos_theta);
        for (int c = 0; c < 3; ++c) {
          const double exact = airy[static_cast<size_t>(c)];
          here += square(static_cast<double>(glass.transmitted_albedo()[c]) - exact);
          mixed += square(1.0 - static_cast<double>(max_component(glass.reflected_albedo())) - exact);
          without += square(1.0 - static_cast<double>(plain) - exact);
          ++count;
        }
      }
    }
    const auto rms = [&](double sum) { return std::sqrt(sum / count); };
    EXPECT_LT(rms(here), error) << film_ior;
    EXPECT_GT(rms(mixed), 3.0 * rms(here)) << film_ior;
    EXPECT_GT(rms(without), 3.0 * rms(here)) << film_ior;
    RecordProperty("film of " + std::to_string(film_ior),
                   std::to_string(rms(here)) + " " + std::to_string(rms(mixed)) + " " + std::to_string(rms(without)));
  }
}

// Nothing is absorbed, and light goes the same way back.
TEST(FilmTransmission, IsComplementOfReflectionFromBothSides) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const V2f film = random.next_2d(), direction = random.next_2d();
    DielectricParameters p = filmed_glass(1.0f + 1.5f * film.x, 1000.0f * film.y);
    p.eta = 1.1f + random.next_1d();
    p.thin_walled = i % 3 == 0;
    const V3f wo = view(0.05f + 0.95f * direction.x, direction.y);
    const DielectricLobe lobe(p, wo);
    const Rgb reflected = lobe.reflected_albedo();
    const Rgb transmitted = lobe.transmitted_albedo() + lobe.straight_transmittance();
    ASSERT_LT((reflected + transmitted - Rgb(1.0f)).length(), 1e-5f) << i;
    const Rgb film_color = thin_film_fresnel(wo.z, 1.0f, p.film_ior, Rgb(dielectric_f0(p.eta)), p.film_thickness_nm);
    ASSERT_LT((reflected - film_color).length(), 1e-5f) << i;
    if (p.thin_walled) continue;
    const V3f inside = refracted_direction(wo, V3f(0.0f, 0.0f, 1.0f), refracted_cosine(wo.z, p.eta), p.eta);
    p.eta = 1.0f / p.eta;
    const DielectricLobe back(p, -inside);
    EXPECT_LT((back.transmitted_albedo() - transmitted).length(), 2e-3f) << i;
  }
}

// The extension's mix has weight for a film of less than full strength.
TEST(FilmTransmission, IsMixedByStrength) {
  DielectricParameters p = filmed_glass(1.8f, 400.0f);
  p.tint = {0.9f, 0.6f, 0.3f};
  const V3f wo = view(0.8f, 0.0f);
  const Rgb full = DielectricLobe(p, wo).transmitted_albedo();
  p.iridescence = 0.0f;
  const Rgb none = DielectricLobe(p, wo).transmitted_albedo();
  p.iridescence = 0.25f;
  EXPECT_LT((DielectricLobe(p, wo).transmitted_albedo() - lerp(none, full, 0.25f)).length(), 1e-6f);
}

// White rough glass returns all of the light in each channel.
TEST(FilmTransmission, RoughGlassLosesNothing) {
  uint64_t seed = 1;
  for (const float roughness : {0.15f, 0.4f, 0.8f}) {
    for (const float eta : {1.5f, 1.0f / 1.5f}) {
      for (const float mu : {0.95f, 0.5f}) {
        for (const bool thin : {false, true}) {
          DielectricParameters p = filmed_glass(1.8f, 400.0f);
          p.alpha_x = p.alpha_y = square(roughness);
          p.eta = eta;
          p.thin_walled = thin;
          const DielectricLobe lobe(p, view(mu, 0.1f));
          Random random(seed++);
          constexpr int kSamples = 40000;
          Rgb sum(0.0f), squares(0.0f);
          for (int i = 0; i < kSamples; ++i) {
            const float u = random.next_1d();
            const auto s = lobe.sample(u, random.next_2d());
            if (!s) continue;
            sum += s->weight / kSamples;
            squares += s->weight * s->weight / kSamples;
          }
          for (int c = 0; c < 3; ++c) {
            const float error = std::sqrt(std::max(squares[c] - sum[c] * sum[c], 0.0f) / kSamples);
            EXPECT_NEAR(sum[c], 1.0f, 0.04f + 4.5f * error) << roughness << " " << eta << " " << mu << " " << thin;
          }
        }
      }
    }
  }
}

} // namespace
} // namespace kindling
