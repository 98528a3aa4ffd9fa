// Tests of means, variances and AOVs of the Film against values computed by hand.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace kindling {
namespace {

AovSet every_aov() {
  AovSet set;
  for (const AovInfo& info : kAovs) set.insert(info.aov);
  return set;
}

Film one_pixel_film(AovSet aovs = every_aov()) { return Film({1, 1}, {{0, 0}, {1, 1}}, aovs); }

FilmSample gray(float value, float weight = 1.0f) { return {Rgb(value), 1.0f, weight}; }

TEST(Film, MeanOfSamples) {
  Film film = one_pixel_film({});
  film.add({0, 0}, {Rgb(1.0f, 2.0f, 3.0f), 1.0f, 1.0f});
  film.add({0, 0}, {Rgb(3.0f, 0.0f, 0.0f), 0.0f, 1.0f});
  EXPECT_EQ(film.resolve_rgba(), (std::vector<float>{2.0f, 1.0f, 1.5f, 0.5f}));
  EXPECT_EQ(film.resolve(Aov::beauty), (std::vector<float>{2.0f, 1.0f, 1.5f}));
  EXPECT_EQ(film.resolve(Aov::samples), (std::vector<float>{2.0f}));
  EXPECT_EQ(film.total_samples(), 2U);
}

TEST(Film, NegativeWeightsDivideByTheirSum) {
  Film film = one_pixel_film({});
  film.add({0, 0}, gray(4.0f));
  film.add({0, 0}, gray(2.0f));
  film.add({0, 0}, gray(1.0f, -1.0f));
  EXPECT_FLOAT_EQ(film.resolve(Aov::beauty)[0], 5.0f);
}

TEST(Film, WeightsWithoutPositiveSumDivideByTheCount) {
  Film film = one_pixel_film({});
  film.add({0, 0}, gray(4.0f));
  film.add({0, 0}, gray(1.0f, -1.0f));
  EXPECT_FLOAT_EQ(film.resolve(Aov::beauty)[0], 1.5f);
}

TEST(Film, AlphaStaysInItsRange) {
  Film film = one_pixel_film({});
  film.add({0, 0}, {Rgb(1.0f), 1.0f, 1.0f});
  film.add({0, 0}, {Rgb(1.0f), 1.0f, 1.0f});
  film.add({0, 0}, {Rgb(0.0f), 0.0f, -1.0f});
  EXPECT_FLOAT_EQ(film.resolve(Aov::alpha)[0], 1.0f);
}

TEST(Film, VarianceOfTheMean) {
  Film film = one_pixel_film();
  for (const float y : {1.0f, 2.0f, 3.0f, 6.0f}) film.add({0, 0}, gray(y));
  // s^2 = (4 + 1 + 0 + 9) / 3; the variance of the mean is s^2 / 4.
  EXPECT_NEAR(film.resolve(Aov::variance)[0], 14.0 / 12.0, 1e-6);
}

TEST(Film, VarianceNeedsTwoSamples) {
  Film film = one_pixel_film();
  film.add({0, 0}, gray(5.0f));
  EXPECT_EQ(film.resolve(Aov::variance)[0], 0.0f);
}

// Over many pixels of n samples, the mean of the estimate is sigma^2 / n.
TEST(Film, VarianceIsUnbiased) {
  constexpr int kPixels = 20000;
  constexpr int kSamples = 4;
  Film film({kPixels, 1}, {{0, 0}, {kPixels, 1}}, every_aov());
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (int x = 0; x < kPixels; ++x)
    for (int s = 0; s < kSamples; ++s) film.add({x, 0}, gray(uniform(random)));
  double sum = 0.0;
  for (const float v : film.resolve(Aov::variance)) sum += v;
  // For the uniform distribution sigma^2 = 1/12 and the fourth central moment is 1/80.
  // Var(s^2) = (m4 - sigma^4 (n - 3) / (n - 1)) / n; the tolerance is 5 standard errors.
  const double sigma2 = 1.0 / 12.0;
  const double variance_of_s2 = (1.0 / 80.0 - sigma2 * sigma2 * (kSamples - 3.0) / (kSamples - 1.0)) / kSamples;
  const double standard_error = std::sqrt(variance_of_s2 / kPixels) / kSamples;
  EXPECT_NEAR(sum / kPixels, sigma2 / kSamples, 5.0 * standard_error);
}

// With signed weights, the estimate agrees with the variance of the means of many pixels.
TEST(Film, VarianceUnderNegativeLobes) {
  constexpr int kPixels = 4000;
  constexpr int kSamples = 256;
  Film film({kPixels, 1}, {{0, 0}, {kPixels, 1}}, every_aov());
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (int x = 0; x < kPixels; ++x)
    for (int s = 0; s < kSamples; ++s) {
      const float weight = uniform(random) < 0.1f ? -1.0f : 1.0f;
      film.add({x, 0}, gray(uniform(random) + (weight < 0.0f ? 0.5f : 0.0f), weight));
    }
  const std::vector<float> means = film.resolve(Aov::beauty);
  double sum = 0.0;
  double squares = 0.0;
  double estimate = 0.0;
  for (int x = 0; x < kPixels; ++x) {
    sum += means[3 * static_cast<size_t>(x)];
    squares += square(means[3 * static_cast<size_t>(x)]);
  }
  for (const float v : film.resolve(Aov::variance)) estimate += v;
  const double mean = sum / kPixels;
  const double spread = (squares - kPixels * mean * mean) / (kPixels - 1);
  // The relative standard error of the variance of a normal sample is sqrt(2 / (N - 1)) = 2.2 %;
  // the first-order formula adds O(1/n).
  EXPECT_NEAR(estimate / kPixels / spread, 1.0, 5.0 * std::sqrt(2.0 / (kPixels - 1)) + 4.0 / kSamples);
}

TEST(Film, TotalsAreWeightedSums) {
  Film film = one_pixel_film({});
  film.add({0, 0}, {Rgb(1.0f, 2.0f, 3.0f), 1.0f, 1.0f});
  film.add({0, 0}, {Rgb(4.0f, 0.0f, 1.0f), 1.0f, -0.5f});
  const Film::Totals totals = film.totals({0, 0});
  EXPECT_EQ(totals.rgb, (std::array<double, 3>{-1.0, 2.0, 2.5}));
  EXPECT_EQ(totals.weight, 0.5);
}

TEST(Film, CutKeepsItsPixels) {
  AovSet aovs;
  for (const AovInfo& info : kAovs) aovs.insert(info.aov);
  Film film(V2i(9, 8), {V2i(1, 2), V2i(7, 6)}, aovs);
  for (int y = 2; y < 6; ++y)
    for (int x = 1; x < 7; ++x)
      for (int i = 0; i < x; ++i) {
        film.add({x, y}, gray(static_cast<float>(10 * x + y + i)));
        FilmSurface hit;
        hit.hit = true;
        hit.depth = static_cast<float>(x + 10 * y);
        film.add_surface({x, y}, hit, 1.0f);
      }
  const PixelRect crop{V2i(3, 3), V2i(6, 5)};
  const Film part = film.cut(crop);
  EXPECT_EQ(part.crop().min, crop.min);
  EXPECT_EQ(part.crop().max, crop.max);
  EXPECT_EQ(part.total_samples(), 2U * (3 + 4 + 5));
  for (const AovInfo& info : kAovs) {
    const std::vector<float> whole = film.resolve(info.aov);
    const std::vector<float> cut = part.resolve(info.aov);
    const auto channels = static_cast<size_t>(info.channels);
    for (size_t y = 0; y < 2; ++y)
      for (size_t i = 0; i < 3 * channels; ++i)
        EXPECT_EQ(cut[y * 3 * channels + i], whole[((y + 1) * 6 + 2) * channels + i]) << info.name;
  }
}

TEST(Film, SurfaceMeans) {
  Film film = one_pixel_film();
  FilmSurface hit;
  hit.hit = true;
  hit.albedo = Rgb(0.5f, 0.25f, 1.0f);
  hit.normal = V3f(0.0f, 0.0f, 1.0f);
  hit.depth = 4.0f;
  hit.position = V3f(1.0f, 2.0f, 3.0f);
  hit.guide_albedo = Rgb(1.0f, 0.5f, 0.25f);
  hit.guide_normal = V3f(0.0f, -1.0f, 0.0f);
  hit.emission = Rgb(1.0f);
  hit.direct = Rgb(2.0f);
  film.add({0, 0}, gray(7.0f));
  film.add_surface({0, 0}, hit, 1.0f);
  FilmSurface miss;
  miss.emission = Rgb(3.0f);
  miss.depth = 100.0f; // ignored, because nothing was hit
  film.add({0, 0}, gray(3.0f));
  film.add_surface({0, 0}, miss, 1.0f);

  EXPECT_EQ(film.resolve(Aov::albedo), (std::vector<float>{0.25f, 0.125f, 0.5f}));
  EXPECT_EQ(film.resolve(Aov::normal), (std::vector<float>{0.0f, 0.0f, 0.5f}));
  EXPECT_EQ(film.resolve(Aov::denoising_albedo), (std::vector<float>{0.5f, 0.25f, 0.125f}));
  EXPECT_EQ(film.resolve(Aov::denoising_normal), (std::vector<float>{0.0f, -0.5f, 0.0f}));
  EXPECT_EQ(film.resolve(Aov::depth), (std::vector<float>{4.0f}));
  EXPECT_EQ(film.resolve(Aov::position), (std::vector<float>{1.0f, 2.0f, 3.0f}));
  EXPECT_EQ(film.resolve(Aov::emission)[0], 2.0f);
  EXPECT_EQ(film.resolve(Aov::direct)[0], 1.0f);
  EXPECT_EQ(film.resolve(Aov::indirect)[0], 2.0f); // 5 - 2 - 1
}

TEST(Film, IndirectOfDirectLightAloneIsZero) {
  Film film = one_pixel_film();
  FilmSurface surface;
  surface.hit = true;
  for (int s = 1; s < 100; ++s) {
    surface.emission = Rgb(0.1f * static_cast<float>(s));
    surface.direct = Rgb(1.0f / static_cast<float>(s));
    film.add({0, 0}, {surface.emission + surface.direct, 1.0f, 1.0f});
    film.add_surface({0, 0}, surface, 1.0f);
  }
  EXPECT_EQ(film.resolve(Aov::indirect), (std::vector<float>{0.0f, 0.0f, 0.0f}));
}

TEST(Film, NothingHitLeavesZeros) {
  Film film = one_pixel_film();
  film.add({0, 0}, gray(1.0f));
  film.add_surface({0, 0}, FilmSurface{}, 1.0f);
  EXPECT_EQ(film.resolve(Aov::depth), (std::vector<float>{0.0f}));
  EXPECT_EQ(film.resolve(Aov::position), (std::vector<float>{0.0f, 0.0f, 0.0f}));
}

TEST(Film, PixelsWithoutSamplesAreBlackAndTransparent) {
  const Film film = one_pixel_film();
  EXPECT_EQ(film.resolve_rgba(), (std::vector<float>{0.0f, 0.0f, 0.0f, 0.0f}));
  EXPECT_EQ(film.total_samples(), 0U);
}

TEST(Film, CropAddressesPixelsOfTheWholeImage) {
  Film film({100, 80}, {{10, 20}, {13, 22}}, {});
  film.add({10, 20}, gray(1.0f));
  film.add({12, 20}, gray(2.0f));
  film.add({11, 21}, gray(3.0f));
  const std::vector<float> rgb = film.resolve(Aov::beauty);
  ASSERT_EQ(rgb.size(), 3U * 2U * 3U);
  EXPECT_EQ(rgb[0], 1.0f);
  EXPECT_EQ(rgb[2 * 3], 2.0f);
  EXPECT_EQ(rgb[(3 + 1) * 3], 3.0f);
  EXPECT_EQ(rgb[1 * 3], 0.0f);
}

TEST(Film, MemoryFollowsRequestedAovs) {
  const PixelRect whole{{0, 0}, {64, 64}};
  const Film plain({64, 64}, whole, {});
  const Film full({64, 64}, whole, every_aov());
  EXPECT_LE(plain.memory_bytes(), 64U * 64U * 72U);
  EXPECT_GT(full.memory_bytes(), plain.memory_bytes());
}

// Returns the bytes of the film in whole pages that were touched.
size_t touched_bytes(Film& film) {
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  size_t touched = 0;
  for (const Film::Plane& plane : film.planes()) {
    const auto first = (reinterpret_cast<uintptr_t>(plane.bytes.data()) + page - 1) / page * page;
    const auto last = reinterpret_cast<uintptr_t>(plane.bytes.data() + plane.bytes.size()) / page * page;
    std::vector<unsigned char> pages((last - first) / page);
    EXPECT_EQ(mincore(reinterpret_cast<void*>(first), last - first, pages.data()), 0);
    for (const unsigned char state : pages) touched += (state & 1U) != 0 ? page : 0;
  }
  return touched;
}

// A film is not cleared before threads write to it.
TEST(Film, TouchesOnlyPagesOfSamples) {
  const V2i size(2048, 2048);
  Film film(size, {{0, 0}, size}, {});
  film.trim_outliers();
  ASSERT_GT(film.memory_bytes(), 1024U << 20);
  for (int y = 0; y < 8; ++y) film.add({1000, 1000 + y}, {.radiance = Rgb(1.0f)});
  const size_t touched = touched_bytes(film);
  EXPECT_GT(touched, 0U);
#ifndef __SANITIZE_THREAD__      // its calloc() clears all memory
  EXPECT_LT(touched, 64U << 20); // 16 records, on huge pages
#endif
  EXPECT_EQ(film.totals({1000, 1000}).rgb[0], 1.0);
  EXPECT_EQ(film.totals({1001, 1000}).rgb[0], 0.0);
  EXPECT_EQ(film.totals({1001, 1000}).weight, 0.0);
}

TEST(ZeroedArray, StartsAtZeroAndCopiesByValue) {
  ZeroedArray<uint64_t> some(5);
  EXPECT_TRUE(std::all_of(some.begin(), some.end(), [](uint64_t x) { return x == 0; }));
  some[4] = 7;
  ZeroedArray<uint64_t> copy = some;
  some[4] = 8;
  EXPECT_EQ(copy[4], 7U);
  const ZeroedArray<uint64_t> moved = std::move(copy);
  EXPECT_EQ(moved.size(), 5U);
  EXPECT_EQ(moved[4], 7U);
  some = ZeroedArray<uint64_t>();
  EXPECT_TRUE(some.empty());
  EXPECT_EQ(some.begin(), some.end());
  EXPECT_THROW(ZeroedArray<uint64_t>(std::numeric_limits<size_t>::max() / 4), std::bad_alloc);
}

TEST(Aovs, NamesAreUniqueAndRoundTrip) {
  for (const AovInfo& info : kAovs) {
    EXPECT_EQ(aov_from_name(info.name), info.aov);
    EXPECT_EQ(aov_info(info.aov).name, info.name);
  }
  EXPECT_FALSE(aov_from_name("shadow").has_value());
}

} // namespace
} // namespace kindling
