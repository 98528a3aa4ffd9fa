// Parts of samples that sum to the beauty to the bit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"
#include "renderer/film/write_film.h"
#include "tests/film/add_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <vector>

namespace kindling {
namespace {

constexpr V2i kSplitSize(5, 4);
constexpr PixelRect kSplitCrop{V2i(0, 0), kSplitSize};

AovSet all_passes() {
  AovSet aovs;
  for (const AovInfo& info : kAovs)
    if (is_light_pass(info.aov)) aovs.insert(info.aov);
  return aovs;
}

Film split_film(AovSet aovs = all_passes(), const PixelRect& crop = kSplitCrop) {
  Film film(kSplitSize, crop, aovs);
  film.split_by_light_groups({"key", "fill", "dark"});
  return film;
}

struct SplitSample {
  V2i pixel;
  FilmSample sample;
  std::array<Rgb, 3> groups;
  std::array<Rgb, kLightPassCount> passes;
};

// Parts of all magnitudes, among them negative ones; the last group is black, as are some passes.
// The radiance is a float sum of the parts in yet another order.
std::vector<SplitSample> random_split_samples(uint32_t count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const auto magnitude = [&] { return std::exp2(60.0f * uniform(random) - 40.0f); };
  std::vector<SplitSample> samples(count);
  for (SplitSample& s : samples) {
    s.pixel.x = static_cast<int>(random() % 5);
    s.pixel.y = static_cast<int>(random() % 4);
    s.passes.fill(Rgb(0.0f));
    for (const size_t pass : {size_t{0}, size_t{3}, size_t{8}})
      s.passes[pass] = Rgb{magnitude(), uniform(random), -magnitude()};
    s.sample.radiance = s.passes[8] + s.passes[0] + s.passes[3];
    s.groups = {s.sample.radiance * 0.3f, s.sample.radiance * 0.7f, Rgb(0.0f)};
    s.sample.weight = random() % 3 == 0 ? -1.1449341f : 1.1449341f;
  }
  return samples;
}

void add_split(Film& film, const SplitSample& s) {
  film.add(s.pixel, s.sample);
  add_light_groups(film, s.pixel, s.groups, s.sample);
  add_light_passes(film, s.pixel, s.passes, s.sample);
}

template <typename Record>
std::span<const Record> records(const Film& film, std::string_view name) {
  for (const Film::ConstPlane& plane : film.planes())
    if (plane.name == name)
      return {reinterpret_cast<const Record*>(plane.bytes.data()), plane.bytes.size() / sizeof(Record)};
  return {};
}

void expect_parts_sum_to_beauty(const Film& film, std::string_view plane, size_t parts) {
  const auto beauty = records<PixelSum>(film, "beauty");
  const auto sums = records<RadianceSum>(film, plane);
  ASSERT_EQ(sums.size(), beauty.size() * parts);
  for (size_t i = 0; i < beauty.size(); ++i) {
    RadianceSum total{};
    for (size_t p = 0; p < parts; ++p) total.add(sums[i * parts + p]);
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(total.rgb[c] == beauty[i].rgb[c]) << plane << " at " << i;
  }
}

TEST(SplitLight, PartsSumToTheBeautyToTheBit) {
  Film film = split_film();
  const std::vector<SplitSample> samples = random_split_samples(4000);
  for (const SplitSample& s : samples) add_split(film, s);
  expect_parts_sum_to_beauty(film, "light groups", 3);
  expect_parts_sum_to_beauty(film, "light passes", kLightPassCount);
  // Rounding leaves differences, or the test would test nothing.
  size_t inexact = 0;
  for (const SplitSample& s : samples)
    for (int c = 0; c < 3; ++c)
      inexact += static_cast<double>(s.passes[0][c]) + static_cast<double>(s.passes[3][c]) +
                             static_cast<double>(s.passes[8][c]) !=
                         static_cast<double>(s.sample.radiance[c])
                     ? 1
                     : 0;
  EXPECT_GT(inexact, 1000U);
}

TEST(SplitLight, BlackPartsRemainBlack) {
  Film film = split_film();
  for (const SplitSample& s : random_split_samples(4000)) add_split(film, s);
  for (const float value : film.resolve_light_group(2)) EXPECT_EQ(value, 0.0f);
  for (const float value : film.resolve(Aov::glossy_direct)) EXPECT_EQ(value, 0.0f);
}

TEST(SplitLight, PartsOfClampedRadianceSumToIt) {
  Film film = split_film();
  const Rgb huge(0x1p41f, 1.0f, -0x1p42f);
  const std::array<Rgb, 3> groups{huge * 0.5f, huge * 0.5f, Rgb(0.0f)};
  film.add({1, 1}, {huge, 1.0f, 1.0f});
  add_light_groups(film, {1, 1}, groups, {huge, 1.0f, 1.0f});
  expect_parts_sum_to_beauty(film, "light groups", 3);
}

TEST(SplitLight, OrderMergesAndCutsDoNotMatter) {
  std::vector<SplitSample> samples = random_split_samples(3000);
  Film whole = split_film();
  for (const SplitSample& s : samples) add_split(whole, s);
  std::shuffle(samples.begin(), samples.end(), std::mt19937(5));
  Film sum = split_film(), half = split_film();
  for (size_t i = 0; i < samples.size(); ++i) add_split(i % 2 == 0 ? sum : half, samples[i]);
  sum.add(half);
  const auto planes = whole.planes(), others = sum.planes();
  ASSERT_EQ(planes.size(), 4U);
  ASSERT_EQ(others.size(), 4U);
  for (size_t p = 0; p < planes.size(); ++p)
    EXPECT_EQ(std::memcmp(planes[p].bytes.data(), others[p].bytes.data(), planes[p].bytes.size()), 0) << planes[p].name;

  const Film part = whole.cut({V2i(1, 1), V2i(4, 3)});
  EXPECT_EQ(part.light_groups(), whole.light_groups());
  const std::vector<float> all = whole.resolve_light_group(1), cut = part.resolve_light_group(1);
  const std::vector<float> all_diffuse = whole.resolve(Aov::diffuse_direct),
                           diffuse = part.resolve(Aov::diffuse_direct);
  for (size_t y = 0; y < 2; ++y)
    for (size_t i = 0; i < 9; ++i) {
      EXPECT_EQ(cut[y * 9 + i], all[((y + 1) * 5 + 1) * 3 + i]);
      EXPECT_EQ(diffuse[y * 9 + i], all_diffuse[((y + 1) * 5 + 1) * 3 + i]);
    }
}

// A pass has the same values whichever others are stored.
TEST(SplitLight, SomePassesAreThoseOfAll) {
  AovSet some;
  some.insert(Aov::glossy_indirect);
  some.insert(Aov::emit);
  Film all = split_film(), few = split_film(some);
  for (const SplitSample& s : random_split_samples(2000)) {
    add_split(all, s);
    add_split(few, s);
  }
  EXPECT_EQ(few.resolve(Aov::glossy_indirect), all.resolve(Aov::glossy_indirect));
  EXPECT_EQ(few.resolve(Aov::emit), all.resolve(Aov::emit));
  EXPECT_NE(few.resolve(Aov::emit), std::vector<float>(5 * 4 * 3, 0.0f));
  for (const float value : few.resolve(Aov::diffuse_direct)) EXPECT_EQ(value, 0.0f); // not stored
  EXPECT_LT(few.memory_bytes(), all.memory_bytes());
}

TEST(SplitLight, MeansAreTakenOverAllSamples) {
  Film film = split_film();
  const std::array<Rgb, 3> groups{Rgb(1.0f, 2.0f, 3.0f), Rgb(3.0f, 2.0f, 1.0f), Rgb(0.0f)};
  const FilmSample sample{Rgb(4.0f), 1.0f, 1.0f};
  film.add({0, 0}, sample);
  add_light_groups(film, {0, 0}, groups, sample);
  film.view().add_lobe_colors(0, {Rgb(0.5f), Rgb(0.25f), Rgb(0.125f)}, 1.0f);
  film.add({0, 0}, {Rgb(0.0f), 1.0f, 1.0f});
  const std::vector<float> key = film.resolve_light_group(0);
  EXPECT_EQ(std::vector<float>(key.begin(), key.begin() + 3), (std::vector<float>{0.5f, 1.0f, 1.5f}));
  EXPECT_EQ(film.resolve(Aov::diffuse_color)[0], 0.25f);
  EXPECT_EQ(film.resolve(Aov::glossy_color)[1], 0.125f);
  EXPECT_EQ(film.resolve(Aov::transmission_color)[2], 0.0625f);
}

TEST(SplitLight, FilmsWithoutItHaveNoPlanesOfIt) {
  EXPECT_EQ(Film(kSplitSize, kSplitCrop, AovSet{}).planes().size(), 1U);
  EXPECT_TRUE(Film(kSplitSize, kSplitCrop, AovSet{}).light_groups().empty());
}

TEST(SplitLight, LayersAreNamedAsBlenderDoes) {
  EXPECT_EQ(light_group_channels("key"),
            (std::vector<std::string>{"Combined_key.R", "Combined_key.G", "Combined_key.B"}));
  EXPECT_EQ(channel_names(Aov::diffuse_direct), (std::vector<std::string>{"DiffDir.R", "DiffDir.G", "DiffDir.B"}));
  EXPECT_EQ(channel_names(Aov::environment).front(), "Env.R");
}

} // namespace
} // namespace kindling
