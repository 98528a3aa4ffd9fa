// Tests of the mean reflectance of films over lobes against sampled and fine quadrature.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/film_layer.h"
#include "renderer/bsdf/ggx_lobe.h"

#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kindling {
namespace {

using test::Random;
using test::view;

struct RandomFilm {
  LayerParameters layers;
  Rgb base_f0;
};
RandomFilm random_film(Random& random) {
  RandomFilm film;
  film.layers.iridescence = 1.0f;
  film.layers.iridescence_ior = random.next_1d() < 0.25f ? 1.0f : 1.0f + 1.4f * random.next_1d();
  film.layers.iridescence_thickness_nm = 50.0f + 950.0f * random.next_1d();
  film.layers.clearcoat = random.next_1d() < 0.6f ? 0.0f : random.next_1d();
  film.base_f0 = test::color(random) * 0.2f;
  return film;
}

// Returns the means of the film and of (1 - cos)^5 over the visible normals at the view cosine mu,
// weighted by G2 / G1.
struct LobeMean {
  Rgb film{0.0f};
  GgxAlbedo seen{0.0f, 0.0f};
};
LobeMean lobe_mean(const FilmLayer& film, float roughness, float mu) {
  constexpr uint32_t kSide = 40;
  const GgxLobe lobe(roughness * roughness, roughness * roughness, view(mu, 0.0f));
  LobeMean mean;
  for (uint32_t i = 0; i < kSide; ++i) {
    const float shift = std::fmod(static_cast<float>(i) * std::numbers::phi_v<float>, 1.0f);
    for (uint32_t j = 0; j < kSide; ++j) {
      const V3f wi = lobe.sample(
          {std::fmod((static_cast<float>(j) + shift) / kSide, 1.0f), (static_cast<float>(i) + 0.5f) / kSide});
      if (!(wi.z > 0.0f)) continue;
      const GgxLobe::Eval e = lobe.eval(wi);
      const float weight = e.value / e.pdf;
      mean.film += film.fresnel(std::min(e.cos_d, 1.0f)) * weight;
      mean.seen.e += weight;
      mean.seen.b += weight * pow5(std::max(1.0f - e.cos_d, 0.0f));
    }
  }
  mean.film = mean.film / mean.seen.e;
  return mean;
}

// The mean over the views of a sphere is the error of a white furnace.
TEST(FilmAlbedo, MeansMatchQuadrature) {
  Random random(1);
  constexpr int kFilms = 60;
  constexpr int kViews = 40;
  double squares = 0.0, worst_mean = 0.0, worst = 0.0;
  for (int i = 0; i < kFilms; ++i) {
    const RandomFilm random_one = random_film(random);
    const float roughness = 0.02f + 0.98f * random.next_1d();
    const FilmLayer film(random_one.layers, random_one.base_f0);
    const FilmAlbedo albedo(film, roughness);
    V3d mean(0.0);
    for (int v = 0; v < kViews; ++v) {
      const float mu = std::sqrt((static_cast<float>(v) + random.next_1d()) / kViews);
      const LobeMean exact = lobe_mean(film, roughness, mu);
      const Rgb found = Rgb(albedo.schlick_share() * exact.seen.b / exact.seen.e) + albedo.residual(mu);
      for (int c = 0; c < 3; ++c) {
        const double error = static_cast<double>(found[c]) - static_cast<double>(exact.film[c]);
        mean[c] += error / kViews;
        squares += error * error / (3.0 * kFilms * kViews);
        worst = std::max(worst, std::abs(error));
        EXPECT_LT(std::abs(error), 0.08) // thick films of an index below their surroundings
            << "mu " << mu << " roughness " << roughness << " film " << random_one.layers.iridescence_ior << " "
            << random_one.layers.iridescence_thickness_nm << " coat " << random_one.layers.clearcoat;
      }
    }
    for (int c = 0; c < 3; ++c) {
      worst_mean = std::max(worst_mean, std::abs(mean[c]));
      EXPECT_LT(std::abs(mean[c]), 0.005) << "roughness " << roughness << " film " << random_one.layers.iridescence_ior
                                          << " " << random_one.layers.iridescence_thickness_nm;
    }
  }
  EXPECT_LT(std::sqrt(squares), 5e-3);
  RecordProperty("rms", std::to_string(std::sqrt(squares)));
  RecordProperty("worst", std::to_string(worst));
  RecordProperty("worst_mean", std::to_string(worst_mean));
}

TEST(FilmAlbedo, HemisphericalMeanMatchesFineQuadrature) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const RandomFilm random_one = random_film(random);
    const FilmLayer film(random_one.layers, random_one.base_f0);
    constexpr int kSteps = 2000;
    V3d mean(0.0);
    for (int k = 0; k < kSteps; ++k)
      mean += V3d(film.fresnel(std::sqrt((static_cast<float>(k) + 0.5f) / kSteps))) / kSteps;
    const Rgb found = FilmAlbedo(film, 0.5f).mean_fresnel();
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(static_cast<double>(found[c]), mean[c], 5e-3)
          << random_one.layers.iridescence_ior << " " << random_one.layers.iridescence_thickness_nm;
  }
}

TEST(FilmAlbedo, TableRowsAreMeans) {
  for (uint32_t r = 0; r < kFilmRoughnessNodes; ++r) {
    for (uint32_t m = 0; m < kFilmNodes; ++m) {
      int sum = 0;
      for (uint32_t k = 0; k < kFilmNodes; ++k) sum += kFilmTable[(r * kFilmNodes + k) * kFilmNodes + m];
      EXPECT_NEAR(sum, 65535, 8) << r << " " << m;
    }
  }
}

TEST(FilmAlbedo, NodesAreFoundAgain) {
  for (uint32_t k = 0; k < kFilmNodes; ++k) {
    const FilmAlbedo::Position at = FilmAlbedo::position(film_node_cosine(k));
    EXPECT_NEAR(static_cast<float>(at.node) + at.fraction, static_cast<float>(k), 2e-4f);
  }
}

} // namespace
} // namespace kindling
