// Ids of names, exact sums of coverage by id, their ranks, and the nearest sample.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/cryptomatte.h"
#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <random>
#include <vector>

namespace kindling {
namespace {

// The names and values are those of Psyop's own unit tests and sample images.
TEST(MatteIds, AreThoseOfPsyop) {
  const auto as_float = [](const char* name) { return std::bit_cast<float>(matte_id(name)); };
  EXPECT_FLOAT_EQ(as_float("hello"), 6.0705627102400005616e-17f);
  EXPECT_FLOAT_EQ(as_float("cube"), -4.08461912519e+15f);
  EXPECT_FLOAT_EQ(as_float("sphere"), 2.79018604383e+15f);
  EXPECT_FLOAT_EQ(as_float("plane"), 3.66557617593e-11f);
  EXPECT_FLOAT_EQ(as_float("\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0"), -1.3192631212399999468e-25f);
  EXPECT_FLOAT_EQ(as_float("m\xc3\xa4"
                           "dchen"),
                  6.2361298211599995797e+25f);
  EXPECT_EQ(matte_hex(matte_id("bunny")), "13851a76");
  EXPECT_EQ(matte_hex(matte_id("bush")), "f763d090");
  EXPECT_EQ(matte_hex(matte_id("default_333")), "64fdaf51");
  EXPECT_EQ(matte_hex(matte_id("flowerA.flowerA_petal10.:3594")), "0086fc22");
}

TEST(MatteIds, AreNormalFloats) {
  EXPECT_EQ(murmur_hash3(""), 0U);
  EXPECT_EQ(matte_id(""), 1U << 23);
  EXPECT_EQ(murmur_hash3("object365"), 0x0064028fU); // denormal
  EXPECT_EQ(matte_id("object365"), 0x00e4028fU);
  EXPECT_EQ(murmur_hash3("object1221"), 0xffd06e74U); // not a number
  EXPECT_EQ(matte_id("object1221"), 0xff506e74U);
  for (int i = 0; i < 20000; ++i)
    ASSERT_TRUE(std::isnormal(std::bit_cast<float>(matte_id("object" + std::to_string(i))))) << i;
}

TEST(MatteNames, FollowTheSpecification) {
  EXPECT_EQ(matte_channel_names(Matte::object, 3),
            (std::vector<std::string>{"CryptoObject00.r", "CryptoObject00.g", "CryptoObject00.b", "CryptoObject00.a",
                                      "CryptoObject01.r", "CryptoObject01.g", "CryptoObject01.b", "CryptoObject01.a"}));
  EXPECT_EQ(matte_channel_names(Matte::asset, 1).front(), "CryptoAsset00.r");
  EXPECT_EQ(matte_metadata_prefix(Matte::object), "cryptomatte/3ae39a5/");
  EXPECT_EQ(matte_metadata_prefix(Matte::material), "cryptomatte/be359d6/");
  EXPECT_EQ(matte_metadata_prefix(Matte::asset), "cryptomatte/f42029d/");
}

AovSet with_mattes() {
  AovSet aovs;
  for (const MatteInfo& info : kMattes) aovs.insert(info.matte);
  return aovs;
}

struct TestSample {
  V2i pixel;
  MatteIds ids;
  float weight;
};

std::vector<TestSample> random_matte_samples(size_t count) {
  std::mt19937 random(3);
  std::vector<TestSample> samples;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t object = 1 + static_cast<uint32_t>(random()) % 9;
    const auto pixel = static_cast<int>(random() % 15);
    samples.push_back(
        {V2i(pixel % 5, pixel / 5), {object, 20 + object % 4, 40 + object % 2}, random() % 3 == 0 ? -1.145f : 1.145f});
  }
  return samples;
}

void add(Film& film, const TestSample& sample) {
  film.add(sample.pixel, {Rgb(0.5f), 1.0f, sample.weight});
  film.add_matte(sample.pixel, sample.ids, sample.weight);
}

bool same_mattes(const Film& a, const Film& b) {
  const FlatMattes flat_a = a.mattes().flat(), flat_b = b.mattes().flat();
  return flat_a.counts == flat_b.counts &&
         std::ranges::equal(std::as_bytes(std::span(flat_a.terms)), std::as_bytes(std::span(flat_b.terms)));
}

TEST(MatteSums, DoNotDependOnTheOrder) {
  const V2i size(5, 3);
  std::vector<TestSample> samples = random_matte_samples(3000);
  Film all(size, {V2i(0), size}, with_mattes());
  for (const TestSample& sample : samples) add(all, sample);
  std::mt19937 random(8);
  for (int round = 0; round < 5; ++round) {
    std::ranges::shuffle(samples, random);
    // Three parts, two of them with the upper rows or the lower row alone.
    Film upper(size, {V2i(0), V2i(5, 2)}, with_mattes()), lower(size, {V2i(0, 2), size}, with_mattes());
    Film more(size, {V2i(0), size}, with_mattes());
    for (size_t i = 0; i < samples.size(); ++i)
      add(i % 3 == 0 ? more : samples[i].pixel.y < 2 ? upper : lower, samples[i]);
    Film sum(size, {V2i(0), size}, with_mattes());
    for (const Film* part : {&lower, &more, &upper}) sum.add(*part);
    EXPECT_TRUE(same_mattes(sum, all));
    EXPECT_FALSE(same_mattes(more, all));
  }
}

TEST(MatteSums, CopiesCutsAndFlatFormsKeepAll) {
  const V2i size(5, 3);
  Film film(size, {V2i(0), size}, with_mattes());
  for (const TestSample& sample : random_matte_samples(500)) add(film, sample);
  Film copy = film;
  EXPECT_TRUE(same_mattes(copy, film));
  copy.add_matte({0, 0}, {99, 98, 97}, 1.0f);
  EXPECT_FALSE(same_mattes(copy, film));
  const Film cut = film.cut({V2i(1, 1), V2i(4, 3)});
  std::vector<MatteTerm> of_cut, of_film;
  cut.mattes().list(0, of_cut);
  film.mattes().list(6, of_film);
  ASSERT_FALSE(of_cut.empty());
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(of_cut)), std::as_bytes(std::span(of_film))));
  Film restored(size, {V2i(0), size}, with_mattes());
  restored.mattes().set(film.mattes().flat());
  EXPECT_TRUE(same_mattes(restored, film));
  EXPECT_GE(restored.memory_bytes(), 15U * (72U + 24U));
}

TEST(MatteSums, SurviveInvalidTerms) {
  const auto term = [](uint32_t object, double weight) {
    MatteTerm made{{object, 0, 0}, 0, {}};
    made.weight.add(weight);
    return made;
  };
  MatteSums sums(2);
  sums.set({{0, 4}, {term(2, 1.0), term(1, 2.0), term(0, 4.0), term(2, 8.0)}});
  const FlatMattes sorted = sums.flat();
  EXPECT_EQ(sorted.counts, (std::vector<uint32_t>{0, 2}));
  EXPECT_EQ(sorted.terms[0].ids.object, 1U);
  EXPECT_EQ(sorted.terms[1].weight.value(), 9.0);
  for (const std::vector<uint32_t>& counts :
       {std::vector<uint32_t>{4294967295U, 4294967295U}, {1}, {1, 0}, {}, {1, 1, 1}, {0, 2}}) {
    sums.set({counts, {term(3, 1.0)}});
    EXPECT_LE(sums.flat().terms.size(), 1U);
  }
}

std::vector<MatteTerm> terms_of(const std::vector<std::pair<MatteIds, double>>& weights) {
  std::vector<MatteTerm> terms;
  for (const auto& [ids, weight] : weights) {
    terms.push_back({ids, 0, {}});
    terms.back().weight.add(weight);
  }
  return terms;
}

std::array<float, 6> ranks_of(const std::vector<MatteTerm>& terms, Matte matte, double divisor) {
  std::array<float, 6> ranks;
  ranks.fill(7.0f);
  rank_mattes(terms, matte, divisor, ranks);
  return ranks;
}

uint32_t id_at(const std::array<float, 6>& ranks, size_t rank) { return std::bit_cast<uint32_t>(ranks[2 * rank]); }

TEST(MatteRanks, AreSortedByCoverageThenId) {
  const std::vector<MatteTerm> terms =
      terms_of({{{1, 11, 0}, 2.0}, {{2, 12, 0}, 3.0}, {{3, 11, 0}, 2.0}, {{4, 13, 0}, 1.0}});
  const auto objects = ranks_of(terms, Matte::object, 8.0); // the fourth does not fit
  EXPECT_EQ(id_at(objects, 0), 2U);
  EXPECT_EQ(objects[1], 0.375f);
  EXPECT_EQ(id_at(objects, 1), 1U);
  EXPECT_EQ(id_at(objects, 2), 3U);
  const auto materials = ranks_of(terms, Matte::material, 8.0); // those of two objects are one
  EXPECT_EQ(id_at(materials, 0), 11U);
  EXPECT_EQ(materials[1], 0.5f);
  EXPECT_EQ(id_at(materials, 2), 13U);
  EXPECT_EQ(ranks_of({}, Matte::object, 8.0), (std::array<float, 6>{}));
}

TEST(MatteRanks, SumToTheCoverageUnderNegativeLobes) {
  // A pixel covered by three objects, one of them under the negative lobe alone.
  const std::vector<MatteTerm> terms = terms_of({{{1, 0, 0}, 6.0}, {{2, 0, 0}, -2.0}, {{3, 0, 0}, 4.0}});
  const auto full = ranks_of(terms, Matte::object, 8.0);
  EXPECT_EQ(id_at(full, 0), 1U);
  EXPECT_EQ(id_at(full, 1), 3U);
  EXPECT_EQ(id_at(full, 2), 0U);
  EXPECT_FLOAT_EQ(full[1], 0.6f);
  EXPECT_FLOAT_EQ(full[1] + full[3], 1.0f);
  const auto half = ranks_of(terms, Matte::object, 16.0);
  EXPECT_FLOAT_EQ(half[1] + half[3], 0.5f);
  const auto below = ranks_of(terms_of({{{1, 0, 0}, 1.0}, {{2, 0, 0}, -2.0}}), Matte::object, 8.0);
  EXPECT_EQ(below, (std::array<float, 6>{}));
}

TEST(MatteFilm, ResolvesCoverage) {
  Film film({2, 1}, {V2i(0), V2i(2, 1)}, with_mattes());
  for (int i = 0; i < 8; ++i) {
    film.add({0, 0}, {Rgb(1.0f), 1.0f, 1.0f});
    if (i < 5) film.add_matte({0, 0}, {1, 2, 3}, 1.0f);
    if (i == 5) film.add_matte({0, 0}, {4, 2, 3}, 1.0f); // the last two samples miss
  }
  const std::vector<float> objects = film.resolve_matte(Matte::object, 2);
  ASSERT_EQ(objects.size(), 8U);
  EXPECT_EQ(std::bit_cast<uint32_t>(objects[0]), 1U);
  EXPECT_EQ(objects[1], 0.625f);
  EXPECT_EQ(std::bit_cast<uint32_t>(objects[2]), 4U);
  EXPECT_EQ(objects[3], 0.125f);
  for (size_t i = 4; i < 8; ++i) EXPECT_EQ(objects[i], 0.0f); // no samples
  EXPECT_EQ(film.resolve_matte(Matte::material, 2)[1], 0.75f);
  const Film without({2, 1}, {V2i(0), V2i(2, 1)}, {});
  EXPECT_EQ(without.resolve_matte(Matte::object, 2), std::vector<float>(8, 0.0f));
}

TEST(NearestSampleOfPixel, DoesNotDependOnTheOrder) {
  AovSet aovs;
  aovs.insert(Aov::object_id);
  aovs.insert(Aov::uv);
  std::vector<NearestSample> samples;
  for (uint32_t i = 1; i <= 9; ++i)
    samples.push_back({.number = i, .distance2 = i >= 4 && i <= 6 ? 0.25f : 0.5f, .object_id = 100 + i});
  std::mt19937 random(2);
  for (int round = 0; round < 20; ++round) {
    std::ranges::shuffle(samples, random);
    Film film({1, 1}, {V2i(0), V2i(1)}, aovs), part({1, 1}, {V2i(0), V2i(1)}, aovs);
    film.add({0, 0}, {Rgb(1.0f), 1.0f, 1.0f});
    for (size_t i = 0; i < samples.size(); ++i) (i < 4 ? film : part).add_nearest({0, 0}, samples[i]);
    film.add(part);
    EXPECT_EQ(film.resolve(Aov::object_id)[0], 104.0f);
    EXPECT_EQ(film.resolve(Aov::uv)[2], 1.0f);
    EXPECT_TRUE(film.wants_nearest({0, 0}, 3, 0.25f));
    EXPECT_FALSE(film.wants_nearest({0, 0}, 5, 0.25f));
  }
}

TEST(NearestSampleOfPixel, MayBeAMiss) {
  AovSet aovs;
  aovs.insert(Aov::depth_nearest);
  Film film({1, 1}, {V2i(0), V2i(1)}, aovs);
  film.add({0, 0}, {Rgb(1.0f), 1.0f, 1.0f});
  film.add_nearest({0, 0}, {.number = 1, .distance2 = 0.5f, .object_id = 1, .material_id = 1, .depth = 3.0f});
  EXPECT_EQ(film.resolve(Aov::depth_nearest)[0], 3.0f);
  film.add_nearest({0, 0}, {.number = 2, .distance2 = 0.25f});
  EXPECT_EQ(film.resolve(Aov::depth_nearest)[0], 0.0f);
}

} // namespace
} // namespace kindling
