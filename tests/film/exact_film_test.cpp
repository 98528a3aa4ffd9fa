// Tests that a film depends only on the set of its samples, not on their order or distribution.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace kindling {
namespace {

constexpr V2i kSize(12, 9);
constexpr PixelRect kCrop{V2i(1, 2), V2i(11, 8)};
constexpr float kMitchellWeight = 1.1449341f; // magnitude of all weights with Mitchell's filter

AovSet all_aovs() {
  AovSet set;
  for (const AovInfo& info : kAovs) set.insert(info.aov);
  return set;
}

Film empty_film(const PixelRect& crop = kCrop, AovSet aovs = all_aovs(), bool trim = true) {
  Film film(kSize, crop, aovs);
  if (trim) film.trim_outliers();
  return film;
}

struct PlacedSample {
  V2i pixel;
  FilmSample sample;
  FilmSurface surface;
};

// Returns samples with radiance of all magnitudes, fireflies, and negative weights.
std::vector<PlacedSample> random_samples(uint32_t per_pixel) {
  std::mt19937 random(3);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  const auto any_size = [&](int minimum, int span) {
    const float mantissa = 1.0f + uniform();
    return std::ldexp(mantissa, minimum + static_cast<int>(random() % static_cast<uint32_t>(span)));
  };
  std::vector<PlacedSample> samples;
  for (int y = kCrop.min.y; y < kCrop.max.y; ++y)
    for (int x = kCrop.min.x; x < kCrop.max.x; ++x)
      for (uint32_t i = 0; i < per_pixel; ++i) {
        PlacedSample& placed = samples.emplace_back();
        placed.pixel = V2i(x, y);
        const float brightness = random() % 100 == 0 ? any_size(10, 28) : any_size(-20, 10);
        placed.sample = {brightness * Rgb{uniform(), uniform(), uniform()}, uniform(),
                         random() % 8 == 0 ? -kMitchellWeight : kMitchellWeight, i};
        placed.surface.hit = random() % 4 != 0;
        placed.surface.albedo = Rgb{uniform(), uniform(), uniform()};
        placed.surface.normal = V3f{uniform() - 0.5f, -uniform(), uniform()};
        placed.surface.depth = any_size(-10, 50);
        placed.surface.position = V3f(any_size(-10, 50), -any_size(-10, 50), uniform());
        placed.surface.guide_albedo = Rgb{uniform(), 0.0f, uniform()};
        placed.surface.guide_normal = V3f{-uniform(), uniform(), 0.0f};
        placed.surface.emission = Rgb(uniform(), 0.0f, any_size(-30, 60));
        placed.surface.direct = 0.5f * placed.sample.radiance;
      }
  return samples;
}

void add(Film& film, const PlacedSample& placed) {
  film.add(placed.pixel, placed.sample);
  film.add_surface(placed.pixel, placed.surface, placed.sample.weight);
}

void expect_same(const Film& a, const Film& b) {
  const auto planes_a = a.planes(), planes_b = b.planes();
  ASSERT_EQ(planes_a.size(), planes_b.size());
  for (size_t p = 0; p < planes_a.size(); ++p) {
    ASSERT_EQ(planes_a[p].bytes.size(), planes_b[p].bytes.size());
    EXPECT_EQ(std::memcmp(planes_a[p].bytes.data(), planes_b[p].bytes.data(), planes_a[p].bytes.size()), 0)
        << planes_a[p].name;
  }
  for (const AovInfo& info : kAovs) {
    const std::vector<float> x = a.resolve(info.aov), y = b.resolve(info.aov);
    EXPECT_EQ(std::memcmp(x.data(), y.data(), x.size() * sizeof(float)), 0) << info.name;
  }
  for (int y = a.crop().min.y; y < a.crop().max.y; ++y)
    for (int x = a.crop().min.x; x < a.crop().max.x; ++x) {
      const Film::Totals s = a.totals({x, y}), t = b.totals({x, y});
      EXPECT_TRUE(s.rgb == t.rgb && s.weight == t.weight) << x << "," << y;
    }
}

TEST(ExactFilm, OrderOfSamplesDoesNotMatter) {
  std::vector<PlacedSample> samples = random_samples(60);
  Film first = empty_film();
  for (const PlacedSample& placed : samples) add(first, placed);
  std::mt19937 random(1);
  for (int i = 0; i < 5; ++i) {
    std::shuffle(samples.begin(), samples.end(), random);
    Film film = empty_film();
    for (const PlacedSample& placed : samples) add(film, placed);
    expect_same(first, film);
  }
}

// Samples are divided by their indices, by rectangles of pixels, and at random; parts are merged in
// random order.
TEST(ExactFilm, PartsAddUpToWhole) {
  const std::vector<PlacedSample> samples = random_samples(60);
  Film whole = empty_film();
  for (const PlacedSample& placed : samples) add(whole, placed);
  const PixelRect left{kCrop.min, V2i(5, kCrop.max.y)}, right{V2i(5, kCrop.min.y), kCrop.max};
  std::mt19937 random(2);
  for (int division = 0; division < 6; ++division) {
    std::vector<Film> parts;
    for (int i = 0; i < 6; ++i) parts.push_back(empty_film(division % 3 == 1 ? (i % 2 == 0 ? left : right) : kCrop));
    for (const PlacedSample& placed : samples) {
      uint32_t part = random() % 6;
      if (division % 3 == 0) part = placed.sample.index / 10;
      if (division % 3 == 1) part = part / 2 * 2 + (placed.pixel.x < 5 ? 0 : 1);
      add(parts[part], placed);
    }
    std::shuffle(parts.begin(), parts.end(), random);
    Film merged = empty_film();
    for (const Film& part : parts) merged.add(part);
    merged.add(empty_film({kCrop.min, kCrop.min})); // no pixels
    expect_same(whole, merged);
    EXPECT_EQ(merged.total_samples(), samples.size());
  }
  // A film that lacks a sample differs.
  Film lacking = empty_film();
  for (size_t i = 1; i < samples.size(); ++i) add(lacking, samples[i]);
  EXPECT_NE(std::memcmp(whole.planes()[0].bytes.data(), lacking.planes()[0].bytes.data(), 72), 0);
}

TEST(ExactFilm, CutsAddUpToWhole) {
  Film whole = empty_film();
  for (const PlacedSample& placed : random_samples(12)) add(whole, placed);
  Film merged = empty_film();
  for (const PixelRect& crop :
       {PixelRect{V2i(4, 2), V2i(11, 8)}, PixelRect{V2i(1, 5), V2i(4, 8)}, PixelRect{V2i(1, 2), V2i(4, 5)}})
    merged.add(whole.cut(crop));
  expect_same(whole, merged);
}

TEST(ExactFilm, PlanesRoundTrip) {
  Film film = empty_film();
  for (const PlacedSample& placed : random_samples(12)) add(film, placed);
  Film copy = empty_film();
  const Film& from = film;
  const auto source = from.planes();
  size_t bytes = 0;
  for (size_t p = 0; p < source.size(); ++p) {
    const Film::Plane target = copy.planes()[p];
    EXPECT_EQ(target.name, source[p].name);
    ASSERT_EQ(target.bytes.size(), source[p].bytes.size());
    EXPECT_EQ(target.bytes.size(), target.bytes_per_pixel * static_cast<size_t>(kCrop.pixel_count()));
    std::memcpy(target.bytes.data(), source[p].bytes.data(), source[p].bytes.size());
    bytes += target.bytes.size();
  }
  expect_same(film, copy);
  EXPECT_EQ(bytes, film.memory_bytes());
}

TEST(ExactFilm, PlanesFollowRequestedAovs) {
  const auto sizes = [](AovSet aovs, bool trim) {
    std::vector<std::pair<std::string, size_t>> of_planes;
    const Film film = empty_film(kCrop, aovs, trim);
    for (const Film::ConstPlane& plane : film.planes()) of_planes.emplace_back(plane.name, plane.bytes_per_pixel);
    return of_planes;
  };
  using Sizes = std::vector<std::pair<std::string, size_t>>;
  EXPECT_EQ(sizes({}, false), (Sizes{{"beauty", 72}}));
  EXPECT_EQ(sizes({}, true), (Sizes{{"beauty", 72}, {"blocks", 224}}));
  AovSet direct, depth, guide;
  guide.insert(Aov::denoising_normal);
  EXPECT_EQ(sizes(guide, false), (Sizes{{"beauty", 72}, {"guides", 48}}));
  direct.insert(Aov::direct);
  depth.insert(Aov::depth);
  EXPECT_EQ(sizes(direct, false), (Sizes{{"beauty", 72}, {"components", 96}}));
  EXPECT_EQ(sizes(depth, false), (Sizes{{"beauty", 72}, {"surface", 128}}));
  AovSet passes;
  for (const Aov pass : {Aov::glossy_direct, Aov::environment}) passes.insert(pass);
  EXPECT_EQ(sizes(passes, false), (Sizes{{"beauty", 72}, {"light passes", 96}}));
  EXPECT_EQ(sizes(all_aovs(), true), (Sizes{{"beauty", 72},
                                            {"variance", 56},
                                            {"surface", 128},
                                            {"guides", 48},
                                            {"components", 96},
                                            {"blocks", 224},
                                            {"light passes", 480},
                                            {"lobe colors", 72},
                                            {"nearest", 56},
                                            {"shadow catcher", 104}}));
  Film grouped({1, 1}, {{0, 0}, {1, 1}}, {});
  grouped.split_by_light_groups({"key", "fill", "sky"});
  EXPECT_EQ(grouped.planes().back().name, "light groups");
  EXPECT_EQ(grouped.planes().back().bytes_per_pixel, 144U);
  AovSet mattes;
  mattes.insert(Matte::object);
  EXPECT_EQ(sizes(mattes, false), (Sizes{{"beauty", 72}})); // mattes are no plane
}

// The records have the layout that README.md describes.
TEST(ExactFilm, RecordsAreFixedPointWords) {
  Film film({1, 1}, {{0, 0}, {1, 1}}, {});
  film.add({0, 0}, {Rgb(1.5f, -0x1p-55f, 0x1p40f), 0.25f, 1.0f});
  film.add({0, 0}, {Rgb(0.0f), 0.25f, 1.0f});
  uint64_t words[9];
  ASSERT_EQ(film.planes()[0].bytes.size(), sizeof words);
  std::memcpy(words, film.planes()[0].bytes.data(), sizeof words);
  const uint64_t ones = std::numeric_limits<uint64_t>::max();
  const uint64_t expected[9] = {uint64_t{3} << 54, 0, ones, ones, 0, uint64_t{1} << 31, 1 << 27, 1 << 29, 2};
  for (size_t i = 0; i < 9; ++i) EXPECT_EQ(words[i], expected[i]) << i;
}

// Compared with sums in long double, means are exact to the last bit of a float or to a unit of the
// sums.
TEST(ExactFilm, MeansMatchLongDouble) {
  const std::vector<PlacedSample> samples = random_samples(60);
  Film film = empty_film(kCrop, {}, false);
  std::vector<long double> sums(static_cast<size_t>(kCrop.pixel_count()) * 4, 0.0L);
  for (const PlacedSample& placed : samples) {
    add(film, placed);
    const auto index =
        static_cast<size_t>((placed.pixel.y - kCrop.min.y) * kCrop.width() + placed.pixel.x - kCrop.min.x);
    for (int c = 0; c < 3; ++c)
      sums[index * 4 + static_cast<size_t>(c)] +=
          static_cast<long double>(placed.sample.weight) * static_cast<long double>(placed.sample.radiance[c]);
    sums[index * 4 + 3] += static_cast<long double>(placed.sample.weight);
  }
  const std::vector<float> rgb = film.resolve(Aov::beauty);
  for (size_t i = 0; i < rgb.size() / 3; ++i) {
    ASSERT_GT(sums[i * 4 + 3], 0.0L);
    for (size_t c = 0; c < 3; ++c) {
      const auto mean = static_cast<double>(sums[i * 4 + c] / sums[i * 4 + 3]);
      EXPECT_NEAR(static_cast<double>(rgb[i * 3 + c]), mean, 0x1.0001p-24 * std::abs(mean));
    }
  }
}

// A constant image is constant to the bit with any filter weights, for values down to 2^-30.
TEST(ExactFilm, ConstantImagesAreExact) {
  std::mt19937 random(4);
  for (int round = 0; round < 2000; ++round) {
    const float uniform = static_cast<float>(random() >> 8) * 0x1p-24f;
    const float value = round == 0 ? 1.0f : std::ldexp(1.0f + uniform, static_cast<int>(random() % 68) - 29);
    for (const bool lobes : {false, true}) {
      Film film({1, 1}, {{0, 0}, {1, 1}}, all_aovs());
      const uint32_t samples = 1 + random() % 40;
      for (uint32_t i = 0; i < samples; ++i) {
        const float weight = !lobes ? 1.0f : i % 3 == 2 ? -kMitchellWeight : kMitchellWeight;
        FilmSurface surface;
        surface.hit = true;
        surface.albedo = Rgb(0.18f);
        surface.position = V3f(value);
        film.add({0, 0}, {Rgb(value), 1.0f, weight, i});
        film.add_surface({0, 0}, surface, weight);
      }
      const std::vector<float> rgba = film.resolve_rgba();
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(rgba[c], value) << samples;
        EXPECT_EQ(film.resolve(Aov::position)[c], value) << samples;
        EXPECT_NEAR(film.resolve(Aov::albedo)[c], 0.18f, lobes ? 1e-8f * 40.0f : 0.0f);
      }
      EXPECT_EQ(rgba[3], 1.0f);
      EXPECT_EQ(film.resolve(Aov::indirect)[0], value);
    }
  }
}

// Darker values have an absolute precision of 2^-56 for each sample.
TEST(ExactFilm, DarkPixelsHaveAbsolutePrecision) {
  for (const float value : {3.3e-14f, 3.3e-11f, 3.3e-9f, 3.3e9f, 0.7e12f}) {
    Film film({1, 1}, {{0, 0}, {1, 1}}, all_aovs());
    for (uint32_t i = 0; i < 100; ++i) film.add({0, 0}, {Rgb(value) * (i % 2 == 0 ? 0.5f : 1.5f), 1.0f, 1.0f, i});
    const double relative = std::max(0x1p-23, 0x1p-56 / static_cast<double>(value));
    EXPECT_NEAR(film.resolve(Aov::beauty)[0] / value, 1.0, relative);
    if (value < 1e-12f) continue; // its square is below the unit of the moments
    const double variance = 0.25 * static_cast<double>(value) * static_cast<double>(value) / 99.0;
    EXPECT_NEAR(static_cast<double>(film.resolve(Aov::variance)[0]) / variance, 1.0, value < 1e-10f ? 0.02 : 1e-6)
        << value;
  }
}

TEST(ExactFilm, ClampsExcessiveSamplesWithoutSideEffects) {
  Film film({2, 1}, {{0, 0}, {2, 1}}, all_aovs());
  film.trim_outliers();
  constexpr float kHuge = std::numeric_limits<float>::max();
  for (uint32_t i = 0; i < 4; ++i)
    for (int x = 0; x < 2; ++x) film.add({x, 0}, {Rgb(1.0f, 2.0f, 3.0f), 1.0f, 1.0f, i});
  const std::vector<float> before = film.resolve_rgba();
  film.add({0, 0}, {Rgb(kHuge, 2.0f, -kHuge), 1.0f, 1.0f, 4});
  film.add({0, 0}, {Rgb(std::numeric_limits<float>::quiet_NaN(), 2.0f, 3.0f), 1.0f, 1.0f, 5});
  const Film::Totals totals = film.totals({0, 0});
  EXPECT_EQ(totals.rgb, (std::array<double, 3>{0x1p40 + 4.0, 12.0, -0x1p40 + 15.0}));
  EXPECT_EQ(totals.weight, 6.0);
  const std::vector<float> after = film.resolve_rgba();
  EXPECT_TRUE(std::equal(after.begin() + 4, after.end(), before.begin() + 4));
  for (const AovInfo& info : kAovs)
    for (const float value : film.resolve(info.aov)) EXPECT_TRUE(std::isfinite(value)) << info.name;
}

} // namespace
} // namespace kindling
