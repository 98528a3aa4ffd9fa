// Tests of outlier trimming: blocks of known Gini coefficient, films with and without fireflies.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"
#include "renderer/film/outliers.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>

namespace kindling {
namespace {

using Blocks = std::array<BlockSum, kOutlierBlocks>;

void add_to_block(BlockSum& block, const Rgb& radiance, double weight) {
  for (int c = 0; c < 3; ++c) block.rgb[c] += weight * static_cast<double>(radiance[c]);
  block.weight += weight;
}

Blocks gray_blocks(const std::array<float, kOutlierBlocks>& means) {
  Blocks blocks;
  for (size_t i = 0; i < means.size(); ++i) add_to_block(blocks[i], Rgb(means[i]), 1.0);
  return blocks;
}

TEST(Outliers, NamesRoundTrip) {
  for (const Outliers outliers : {Outliers::keep, Outliers::trim})
    EXPECT_EQ(outliers_from_name(outliers_name(outliers)), outliers);
  EXPECT_FALSE(outliers_from_name("drop"));
}

TEST(Outliers, KeepsSimilarBlocks) {
  EXPECT_FALSE(outliers_trimmed(gray_blocks({2, 2, 2, 2, 2})));
  // Blocks 1 to 5: G = 20 / (5 15) = 0.27 and k = floor(0.67) = 0.
  EXPECT_FALSE(outliers_trimmed(gray_blocks({5, 3, 1, 2, 4})));
}

// Blocks 1 to 4 and 14: G = 56 / (5 24) = 0.47 and k = floor(1.17) = 1.
TEST(Outliers, RemovesBrightBlock) {
  Blocks blocks = gray_blocks({4, 3, 1, 14, 2});
  const std::optional<Rgb> trimmed = outliers_trimmed(blocks);
  ASSERT_TRUE(trimmed);
  EXPECT_FLOAT_EQ(trimmed->x, 3.0f);
  // The color of the block is removed as well.
  blocks[3].rgb[0] = 0.0;
  blocks[3].rgb[2] = 100.0;
  ASSERT_TRUE(outliers_trimmed(blocks));
  EXPECT_EQ(*outliers_trimmed(blocks), *trimmed);
  // Blocks are weighted means.
  add_to_block(blocks[0], Rgb(4.0f), 1.0);
  EXPECT_FLOAT_EQ(outliers_trimmed(blocks)->x, (2.0f + 3.0f + 8.0f) / 4.0f);
}

// With all the light in one block G = 0.8 and k = 2, which gives the median.
TEST(Outliers, RemovesAllLightInOneBlock) {
  const std::optional<Rgb> trimmed = outliers_trimmed(gray_blocks({0, 0, 7, 0, 0}));
  ASSERT_TRUE(trimmed);
  EXPECT_EQ(*trimmed, Rgb(0.0f));
}

TEST(Outliers, KeepsUndecidableBlocks) {
  EXPECT_FALSE(outliers_trimmed(Blocks{}));
  EXPECT_FALSE(outliers_trimmed(gray_blocks({0, 0, 0, 0, 0})));
  Blocks two{};
  add_to_block(two[0], Rgb(1.0f), 1.0);
  add_to_block(two[4], Rgb(1000.0f), 1.0);
  EXPECT_FALSE(outliers_trimmed(two));
  Blocks negative = gray_blocks({1, 1, 1, 1, 1000});
  EXPECT_TRUE(outliers_trimmed(negative));
  add_to_block(negative[3], Rgb(1.0f), -2.0); // from a negative lobe of a filter
  EXPECT_FALSE(outliers_trimmed(negative));
}

constexpr int kPixels = 200;

// Uniform noise around 1; samples with `is_firefly(pixel, sample)` are 1000 times as bright.
template <typename IsFirefly>
Film noisy_film(bool trim, int samples, const IsFirefly& is_firefly) {
  Film film({kPixels, 1}, {{0, 0}, {kPixels, 1}}, AovSet{});
  if (trim) film.trim_outliers();
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.9f, 1.1f);
  for (int x = 0; x < kPixels; ++x)
    for (int i = 0; i < samples; ++i) {
      const float y = uniform(random) * (is_firefly(x, i) ? 1000.0f : 1.0f);
      film.add({x, 0}, {Rgb(y), 1.0f, 1.0f, static_cast<uint32_t>(i)});
    }
  return film;
}

bool same_beauty(const Film& a, const Film& b) {
  const std::vector<float> x = a.resolve(Aov::beauty), y = b.resolve(Aov::beauty);
  return std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) == 0;
}

// Without outliers, a trimmed film equals the untrimmed film to the bit.
TEST(Outliers, FilmWithoutFirefliesIsUnchanged) {
  const auto none = [](int, int) { return false; };
  EXPECT_TRUE(same_beauty(noisy_film(false, 64, none), noisy_film(true, 64, none)));
}

// Every third pixel has a firefly.
TEST(Outliers, RemovesFirefliesFromFilm) {
  const auto one = [](int x, int i) { return x % 3 == 0 && i == x * 7 % 64; };
  const Film complete = noisy_film(false, 64, one), trimmed = noisy_film(true, 64, one);
  const std::vector<float> with_fireflies = complete.resolve(Aov::beauty), beauty = trimmed.resolve(Aov::beauty);
  for (size_t i = 0; i < beauty.size(); ++i) {
    EXPECT_GT(with_fireflies[i], i / 3 % 3 == 0 ? 10.0f : 0.9f);
    EXPECT_NEAR(beauty[i], 1.0f, 5.0f * 0.058f / 6.2f); // three blocks of 12 or 13 samples, or all
  }
  // Other AOVs are means of all samples.
  EXPECT_EQ(trimmed.resolve(Aov::alpha), complete.resolve(Aov::alpha));
  EXPECT_EQ(trimmed.memory_bytes() - complete.memory_bytes(), size_t{kPixels} * 224);
}

// With many samples, rare bright samples are part of the image: the estimator is consistent.
TEST(Outliers, KeepsAllBlocksAtManySamples) {
  std::mt19937 random(11);
  std::bernoulli_distribution often(0.1);
  std::vector<bool> fireflies(size_t{kPixels} * 4096);
  for (size_t i = 0; i < fireflies.size(); ++i) fireflies[i] = often(random);
  const auto some = [&](int x, int i) { return fireflies[static_cast<size_t>(x) * 4096 + static_cast<size_t>(i)]; };
  EXPECT_TRUE(same_beauty(noisy_film(false, 4096, some), noisy_film(true, 4096, some)));
}

} // namespace
} // namespace kindling
