// Light of light paths by light group and pass: its parts sum to all of it to the bit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"
#include "tests/film/add_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace kindling {
namespace {

constexpr V2i kImageSize(6, 5);
constexpr PixelRect kImage{V2i(0, 0), kImageSize};

AovSet splat_passes() {
  AovSet aovs;
  for (const Aov aov :
       {Aov::diffuse_indirect, Aov::glossy_indirect, Aov::transmission_indirect, Aov::emit, Aov::direct, Aov::indirect})
    aovs.insert(aov);
  return aovs;
}

Film film_for_splats(const PixelRect& crop = kImage, AovSet aovs = splat_passes()) {
  Film film(kImageSize, crop, aovs);
  film.enable_splats(kImage);
  film.split_by_light_groups({"key", "fill", "dark"});
  return film;
}

struct PlacedSplat {
  V2i pixel;
  Rgb radiance;
  SplatParts parts;
};

// Radiances of all magnitudes; nothing belongs to the last group.
std::vector<PlacedSplat> random_splats(size_t count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  std::vector<PlacedSplat> splats(count);
  for (PlacedSplat& splat : splats) {
    splat.pixel.x = static_cast<int>(random() % 6);
    splat.pixel.y = static_cast<int>(random() % 5);
    for (int c = 0; c < 3; ++c) splat.radiance[c] = std::exp2(50.0f * uniform(random) - 35.0f);
    splat.parts.group = static_cast<uint8_t>(random() % 2);
    const Rgb diffuse{uniform(random), uniform(random), uniform(random)};
    splat.parts.passes = {diffuse, Rgb(1.0f) - diffuse, Rgb(0.0f)};
    if (random() % 4 == 0) splat.parts.passes = {Rgb(0.0f), Rgb(0.0f), Rgb(1.0f)};
  }
  return splats;
}

void add_splats(Film& film, const std::vector<PlacedSplat>& splats) {
  for (const PlacedSplat& splat : splats) {
    film.add_splat(splat.pixel, splat.radiance, splat.parts);
    if (film.crop().contains({splat.pixel, splat.pixel + V2i(1)})) film.add_light_paths(splat.pixel, 3);
  }
}

Film::ConstPlane plane_named(const Film& film, std::string_view name) {
  for (const Film::ConstPlane& plane : film.planes())
    if (plane.name == name) return plane;
  return {};
}

void expect_equal_planes(const Film& a, const Film& b) {
  const auto of_a = a.planes(), of_b = b.planes();
  ASSERT_EQ(of_a.size(), of_b.size());
  for (size_t p = 0; p < of_a.size(); ++p) {
    ASSERT_EQ(of_a[p].bytes.size(), of_b[p].bytes.size()) << of_a[p].name;
    EXPECT_EQ(std::memcmp(of_a[p].bytes.data(), of_b[p].bytes.data(), of_a[p].bytes.size()), 0) << of_a[p].name;
  }
}

TEST(SplatParts, HavePlanesOfTheSplatArea) {
  Film film = film_for_splats({V2i(2, 1), V2i(4, 3)});
  std::vector<std::string> names;
  for (const Film::Plane& plane : film.planes()) {
    names.emplace_back(plane.name);
    EXPECT_EQ(plane.of_splats, plane.name.starts_with("splat"));
    EXPECT_EQ(plane.bytes.size(), plane.bytes_per_pixel * (plane.of_splats ? 30 : 4)) << plane.name;
  }
  EXPECT_EQ(names, (std::vector<std::string>{"beauty", "components", "light groups", "light passes", "splats",
                                             "splat groups", "splat passes"}));
  EXPECT_EQ(plane_named(film, "splat groups").bytes_per_pixel, 3 * 48U);
  EXPECT_EQ(plane_named(film, "splat passes").bytes_per_pixel, 3 * 48U);
  // The order of the calls does not matter.
  Film other(kImageSize, kImage, splat_passes());
  other.split_by_light_groups({"key", "fill", "dark"});
  other.enable_splats();
  expect_equal_planes(other, film_for_splats());
  Film plain(kImageSize, kImage, {});
  plain.enable_splats();
  EXPECT_EQ(plain.planes().size(), 2U);
}

TEST(SplatParts, SumToAllToTheBit) {
  Film film = film_for_splats();
  const std::vector<PlacedSplat> splats = random_splats(5000);
  add_splats(film, splats);
  const auto* const all = reinterpret_cast<const SplatSum*>(plane_named(film, "splats").bytes.data());
  for (const char* name : {"splat groups", "splat passes"}) {
    const auto* const parts = reinterpret_cast<const RadianceSum*>(plane_named(film, name).bytes.data());
    for (size_t i = 0; i < 30; ++i) {
      RadianceSum total{};
      for (size_t p = 0; p < 3; ++p) total.add(parts[3 * i + p]);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(total.rgb[c] == all[i].rgb[c]) << name << " at " << i;
    }
  }
  for (const float value : film.resolve_light_group(2)) EXPECT_EQ(value, 0.0f);
}

TEST(SplatParts, OrderMergesAndCutsDoNotMatter) {
  std::vector<PlacedSplat> splats = random_splats(3000);
  Film whole = film_for_splats();
  add_splats(whole, splats);
  std::shuffle(splats.begin(), splats.end(), std::mt19937(5));
  Film sum = film_for_splats(), half = film_for_splats();
  for (size_t i = 0; i < splats.size(); ++i) add_splats(i % 2 == 0 ? sum : half, {splats[i]});
  sum.add(half);
  expect_equal_planes(sum, whole);

  // Parts of the image: light of each reaches all pixels.
  Film merged = film_for_splats();
  for (const PixelRect& crop : {PixelRect{V2i(0, 0), V2i(6, 2)}, PixelRect{V2i(0, 2), V2i(6, 5)}}) {
    Film part = film_for_splats(crop);
    for (size_t i = 0; i < splats.size(); ++i)
      if ((i % 3 == 0) == (crop.min.y == 0)) {
        part.add_splat(splats[i].pixel, splats[i].radiance, splats[i].parts);
        part.add_light_paths(crop.min, 3);
      }
    merged.add(part);
  }
  for (const char* name : {"splat groups", "splat passes"})
    EXPECT_TRUE(std::ranges::equal(plane_named(merged, name).bytes, plane_named(whole, name).bytes)) << name;

  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 6; ++x) whole.add({x, y}, {Rgb(0.0f), 1.0f, 1.0f});
  const PixelRect rect{V2i(1, 2), V2i(5, 4)};
  const Film part = whole.cut(rect);
  const auto expect_cut = [&](const std::vector<float>& found, const std::vector<float>& all) {
    for (size_t y = 0; y < 2; ++y)
      for (size_t i = 0; i < 12; ++i) EXPECT_EQ(found[y * 12 + i], all[((y + 2) * 6 + 1) * 3 + i]);
  };
  for (size_t group = 0; group < 3; ++group)
    expect_cut(part.resolve_light_group(group), whole.resolve_light_group(group));
  for (const Aov aov : {Aov::diffuse_indirect, Aov::glossy_indirect, Aov::transmission_indirect, Aov::indirect})
    expect_cut(part.resolve(aov), whole.resolve(aov));
}

// A pass has the same values whichever others are stored.
TEST(SplatParts, SomePassesAreThoseOfAll) {
  AovSet one;
  one.insert(Aov::glossy_indirect);
  Film all = film_for_splats(), few = film_for_splats(kImage, one);
  for (Film* film : {&all, &few}) {
    add_splats(*film, random_splats(500));
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) film->add({x, y}, {Rgb(0.0f), 1.0f, 1.0f});
  }
  EXPECT_EQ(few.resolve(Aov::glossy_indirect), all.resolve(Aov::glossy_indirect));
  EXPECT_NE(few.resolve(Aov::glossy_indirect), std::vector<float>(5 * 6 * 3, 0.0f));
  EXPECT_EQ(plane_named(few, "splat passes").bytes_per_pixel, 48U);
}

// One sample and two light paths, one of which brings light that is half diffuse.
TEST(SplatParts, MeansAreThoseOfSamplesPlusThoseOfLightPaths) {
  Film film = film_for_splats();
  const FilmSample sample{Rgb(1.0f), 1.0f, 1.0f};
  std::array<Rgb, kLightPassCount> passes;
  passes.fill(Rgb(0.0f));
  passes[static_cast<size_t>(LightPass::glossy_indirect)] = Rgb(1.0f);
  film.add({1, 1}, sample);
  add_light_groups(film, {1, 1}, std::array{Rgb(0.25f), Rgb(0.75f), Rgb(0.0f)}, sample);
  add_light_passes(film, {1, 1}, passes, sample);
  film.add_light_paths({0, 0}, 2);
  film.add_splat({1, 1}, Rgb(4.0f), {.group = 1, .passes = {Rgb(0.5f), Rgb(0.5f), Rgb(0.0f)}});
  const auto at = [](const std::vector<float>& values) { return values[(6 + 1) * 3]; };
  EXPECT_EQ(at(film.resolve(Aov::beauty)), 3.0f);
  EXPECT_EQ(at(film.resolve(Aov::direct)), 0.0f);
  EXPECT_EQ(at(film.resolve(Aov::indirect)), 3.0f);
  EXPECT_EQ(at(film.resolve_light_group(0)), 0.25f);
  EXPECT_EQ(at(film.resolve_light_group(1)), 2.75f);
  EXPECT_EQ(at(film.resolve(Aov::diffuse_indirect)), 1.0f);
  EXPECT_EQ(at(film.resolve(Aov::glossy_indirect)), 2.0f);
  EXPECT_EQ(at(film.resolve(Aov::transmission_indirect)), 0.0f);
  EXPECT_EQ(at(film.resolve(Aov::emit)), 0.0f);
}

} // namespace
} // namespace kindling
