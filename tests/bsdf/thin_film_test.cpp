// Tests of the thin film against Airy's formula integrated over the spectrum, and of its limits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/fresnel.h"
#include "renderer/bsdf/thin_film.h"

#include "tests/bsdf/observer.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace kindling {
namespace {

using test::integrate_spectrum;
using test::Random;
using test::to_rec709;
using test::Vec;

constexpr double kPiD = std::numbers::pi;

// Interfaces as in KHR_materials_iridescence: unpolarized, by Schlick, with phases of 0 and pi.
struct Film {
  double r12, r23; // amplitudes, signed
  double opd_nm;

  Film(double cos_1, double film_ior, double base_f0, double thickness_nm) {
    const auto schlick = [](double f0, double c) { return f0 + (1.0 - f0) * std::pow(1.0 - c, 5.0); };
    const double cos_2 = std::sqrt(1.0 - (1.0 - cos_1 * cos_1) / (film_ior * film_ior));
    const double base_ior = (1.0 + std::sqrt(base_f0)) / (1.0 - std::sqrt(base_f0));
    const double f12 = std::pow((film_ior - 1.0) / (film_ior + 1.0), 2.0);
    const double f23 = std::pow((base_ior - film_ior) / (base_ior + film_ior), 2.0);
    r12 = (film_ior >= 1.0 ? -1.0 : 1.0) * std::sqrt(schlick(f12, cos_1));
    r23 = (base_ior >= film_ior ? -1.0 : 1.0) * std::sqrt(schlick(f23, cos_2));
    opd_nm = 2.0 * film_ior * thickness_nm * cos_2;
  }
  // Airy 1833: the sum over all reflections, squared.
  [[nodiscard]] double reflectance(double nm) const {
    const std::complex<double> e = std::polar(1.0, 2.0 * kPiD * opd_nm / nm);
    return std::norm((r12 + r23 * e) / (1.0 + r12 * r23 * e));
  }
  // Mean over the phase: the limit of a thick film.
  [[nodiscard]] double mean() const {
    const double a = r12 * r12, b = r23 * r23;
    return a + (1.0 - a) * (1.0 - a) * b / (1.0 - a * b);
  }
  // Amplitude of the first harmonic of the reflectance; each further one is smaller by r12 r23.
  [[nodiscard]] double first_harmonic() const {
    const double a = r12 * r12, b = r23 * r23;
    return 2.0 * std::abs((1.0 - a) * (1.0 - a) * b / (1.0 - a * b) - (1.0 - a)) * std::abs(r12 * r23);
  }
};

// As in the extension, the mean reflectance stays neutral and only the interference is colored by
// the observer. (The equal-energy white is not neutral in Rec. 709, so this differs from
// integrating all of it.)
Vec reference(const Film& film) {
  const double mean = film.mean();
  Vec rgb = integrate_spectrum([&](double nm) { return film.reflectance(nm) - mean; });
  for (double& c : rgb) c += mean;
  return rgb;
}

// Returns the maximum error of the Fourier transform of the extension's Gaussians over all path
// differences, in any channel of Rec. 709.
double error_of_fit() {
  const auto gaussian = [](double opd_nm, double value, double position, double variance) {
    const double phase = 2.0 * kPiD * opd_nm * 1e-9;
    return value * std::sqrt(2.0 * kPiD * variance) * std::cos(position * phase) * std::exp(-phase * phase * variance) /
           1.0685e-7;
  };
  double worst = 0.0;
  for (double opd = 0.0; opd < 3000.0; opd += 10.0) {
    const Vec fit =
        to_rec709({gaussian(opd, 5.4856e-13, 1.6810e6, 4.3278e9) + gaussian(opd, 9.7470e-14, 2.2399e6, 4.5282e9),
                   gaussian(opd, 4.4201e-13, 1.7953e6, 9.3046e9), gaussian(opd, 5.2481e-13, 2.2084e6, 6.6121e9)});
    const Vec exact = integrate_spectrum([&](double nm) { return std::cos(2.0 * kPiD * opd / nm); });
    for (size_t c = 0; c < 3; ++c) worst = std::max(worst, std::abs(fit[c] - exact[c]));
  }
  return worst;
}

struct Base {
  const char* name;
  Rgb f0;
};
const Base kBases[] = {
    {"glass of 1.5", Rgb(0.04f)},         {"glass of 1.8", Rgb(square(0.8f / 2.8f))}, {"air", Rgb(0.0f)},
    {"gold", {0.999f, 0.766f, 0.336f}}, // above F0 of the films, so that all channels have one phase
    {"copper", {0.955f, 0.638f, 0.538f}}, {"silver", {0.972f, 0.960f, 0.915f}}};

TEST(ThinFilm, MatchesSpectralIntegralWithinFitError) {
  const double fit = error_of_fit();
  EXPECT_LT(fit, 0.17); // in thick films; 0.05 below a path difference of 800 nm
  double squares = 0.0;
  int count = 0;
  for (const Base& base : kBases) {
    for (const float ior : {1.2f, 1.33f, 1.6f}) {
      for (const float cos_theta : {1.0f, 0.8f, 0.4f}) {
        for (float thickness = 50.0f; thickness < 900.0f; thickness += 37.0f) {
          const Rgb seen = thin_film_fresnel(cos_theta, 1.0f, ior, base.f0, thickness);
          for (size_t c = 0; c < 3; ++c) {
            const int channel = static_cast<int>(c);
            const Film film(static_cast<double>(cos_theta), static_cast<double>(ior),
                            std::min(static_cast<double>(base.f0[channel]), 0.9999), static_cast<double>(thickness));
            const double expected = std::min(std::max(reference(film)[c], 0.0), 1.0);
            const double first = film.first_harmonic();
            const double r = std::abs(film.r12 * film.r23);
            // Both harmonics may deviate by the error of the fit; those from the third are omitted,
            // and no channel's response to a harmonic is above 1.3.
            const double tolerance = first * ((1.0 + r) * fit + 1.3 * r * r / (1.0 - r)) + 2e-5;
            ASSERT_NEAR(static_cast<double>(seen[channel]), expected, tolerance)
                << base.name << ", film " << ior << ", " << thickness << " nm, cos " << cos_theta << ", channel " << c;
            squares += std::pow(static_cast<double>(seen[channel]) - expected, 2.0);
            ++count;
          }
        }
      }
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 0.01);
  RecordProperty("rms", std::to_string(std::sqrt(squares / count)));
}

// At normal incidence Schlick and Fresnel agree: the film is Airy's. Newton's colors of a soap
// film, from black: yellow, purple, blue, green, yellow, purple (Michel-Levy's chart at these
// retardations).
TEST(ThinFilm, SoapFilmShowsNewtonsColors) {
  const auto seen = [](float opd_nm) { return thin_film_fresnel(1.0f, 1.0f, 1.33f, Rgb(0.0f), opd_nm / 2.66f); };
  const auto describe = [&](float opd_nm) {
    const Rgb c = seen(opd_nm) / max_component(seen(opd_nm));
    return std::to_string(opd_nm) + ": " + std::to_string(c.x) + " " + std::to_string(c.y) + " " + std::to_string(c.z);
  };
  EXPECT_LT(max_component(seen(20.0f)), 0.3f * max_component(seen(250.0f))) << describe(20.0f);
  const Rgb yellow = seen(400.0f), purple = seen(520.0f), blue = seen(640.0f), green = seen(760.0f),
            yellow2 = seen(900.0f), purple2 = seen(1080.0f);
  EXPECT_GT(std::min(yellow.x, yellow.y), 1.5f * yellow.z) << describe(400.0f);
  EXPECT_GT(std::min(purple.x, purple.z), 1.3f * purple.y) << describe(520.0f);
  EXPECT_GT(blue.z, 1.3f * std::max(blue.x, blue.y)) << describe(640.0f);
  EXPECT_GT(green.y, 1.2f * std::max(green.x, green.z)) << describe(760.0f);
  EXPECT_GT(std::min(yellow2.x, yellow2.y), 1.5f * yellow2.z) << describe(900.0f);
  EXPECT_GT(std::min(purple2.x, purple2.z), 1.3f * purple2.y) << describe(1080.0f);
}

TEST(ThinFilm, IsSchlickWithoutFilm) {
  for (const float cos_theta : {0.0f, 0.1f, 0.5f, 1.0f}) {
    const Rgb f0(0.04f, 0.5f, 1.0f);
    const Rgb none = thin_film_fresnel(cos_theta, 1.0f, 1.4f, f0, 0.0f);
    for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(none[c], schlick_fresnel(f0[c], 1.0f, cos_theta));
    // The transition is continuous.
    Rgb previous = none;
    for (float thickness = 1e-4f; thickness < 0.04f; thickness += 1e-4f) {
      const Rgb f = thin_film_fresnel(cos_theta, 1.0f, 1.4f, f0, thickness);
      ASSERT_LT((f - previous).length(), 0.01f);
      previous = f;
    }
  }
}

TEST(ThinFilm, ThickFilmIsNeutral) {
  const Film film(0.7, 1.4, 0.04, 1.0);
  const Rgb f = thin_film_fresnel(0.7f, 1.0f, 1.4f, Rgb(0.04f), 20000.0f);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(f[c], static_cast<float>(film.mean()), 1e-5f);
}

TEST(ThinFilm, ReflectsAllBeyondCriticalAngle) {
  EXPECT_EQ(thin_film_fresnel(0.3f, 1.5f, 1.2f, Rgb(0.04f), 300.0f), Rgb(1.0f));
  EXPECT_LT(max_component(thin_film_fresnel(1.0f, 1.5f, 1.2f, Rgb(0.04f), 300.0f)), 0.2f);
}

TEST(ThinFilm, AnyInputGivesValidReflectance) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Random random(3);
  const float odd[] = {0.0f, -1.0f, 1.0f, 1e-30f, 1e30f, kNan, kInfinity, -kInfinity};
  for (int i = 0; i < 200000; ++i) {
    const auto draw = [&](float scale) {
      const float u = random.next_1d();
      return u < 0.2f ? odd[random.next_u64() % std::size(odd)] : scale * random.next_1d();
    };
    const Rgb f =
        thin_film_fresnel(draw(1.0f), draw(3.0f), draw(4.0f), {draw(1.0f), draw(1.0f), draw(1.0f)}, draw(2000.0f));
    ASSERT_TRUE(is_finite(f) && min_component(f) >= 0.0f && max_component(f) <= 1.0f) << i << " " << f;
  }
}

} // namespace
} // namespace kindling
