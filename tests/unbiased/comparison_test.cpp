// The statistical comparison has the false alarm rate of its level and the power that it predicts.
// SPDX-License-Identifier: Apache-2.0
#include "tests/sampling/random.h"
#include "tests/unbiased/comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace kindling::test {
namespace {

constexpr V2i kSize(32, 24);

float normal(Random& random) {
  const double radius = std::sqrt(-2.0 * std::log1p(-random.next_double()));
  return static_cast<float>(radius * std::cos(2.0 * std::numbers::pi * random.next_double()));
}

// Images with pixels of mean `mean` and standard deviation `noise`.
Images noisy_images(Random& random, size_t seeds, float mean, float noise) {
  Images images(kSize);
  std::vector<float> rgb(static_cast<size_t>(kSize.x) * static_cast<size_t>(kSize.y) * 3);
  for (size_t seed = 0; seed < seeds; ++seed) {
    for (size_t i = 0; i < rgb.size(); i += 3) rgb[i] = rgb[i + 1] = rgb[i + 2] = mean + noise * normal(random);
    images.add(rgb);
  }
  return images;
}

TEST(Comparison, QuantilesMatchTables) {
  EXPECT_NEAR(two_sided_z(0.05), 1.9600, 1e-4);
  EXPECT_NEAR(two_sided_z(1e-6), 4.8916, 1e-4);
  // Student's t: two-sided 0.05 for 10 degrees of freedom is 2.228, 1e-6 for 47 is 5.622.
  EXPECT_NEAR((Difference{2.228, 1.0, 10.0}.z()), 1.960, 0.02);
  EXPECT_NEAR((Difference{-5.622, 1.0, 47.0}.z()), -4.892, 0.02);
}

// Checks that a binomial count is within four standard deviations.
void expect_share(int count, int of, double share) {
  EXPECT_NEAR(count, of * share, 4.0 * std::sqrt(of * share * (1.0 - share)));
}

TEST(Comparison, FalseAlarmsAndPowerMatchTheirStatement) {
  constexpr int kTrials = 150;
  Random random(17);
  const Family family{0.2, 1};
  int alarms = 0, found = 0;
  double power = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    const Images base = noisy_images(random, 32, 1.0f, 0.4f);
    alarms += compare(noisy_images(random, 24, 1.0f, 0.5f), base, false, family).agrees ? 0 : 1;
    const Verdict biased = compare(noisy_images(random, 24, 0.99f, 0.5f), base, false, family);
    found += std::fabs(biased.whole_z) > family.whole_threshold() ? 1 : 0;
    power += biased.power / kTrials;
  }
  // Bonferroni's level is an upper bound; the exact one for independent blocks is 1 - 0.9 * (1 -
  // 0.1 / 12)^12 = 0.186.
  expect_share(alarms, kTrials, 0.186);
  EXPECT_GT(power, 0.5);
  expect_share(found, kTrials, power);
}

TEST(Comparison, FindsLossInOneBlock) {
  Random random(3);
  const Images base = noisy_images(random, 32, 1.0f, 0.3f);
  Images tested(kSize);
  for (int seed = 0; seed < 32; ++seed) {
    std::vector<float> rgb(static_cast<size_t>(kSize.x) * static_cast<size_t>(kSize.y) * 3);
    for (size_t i = 0; i < rgb.size(); ++i) {
      const size_t x = i / 3 % static_cast<size_t>(kSize.x), y = i / 3 / static_cast<size_t>(kSize.x);
      rgb[i] = (x >= 8 && x < 16 && y < 8 ? 0.95f : 1.0f) + 0.3f * normal(random);
    }
    tested.add(rgb);
  }
  const Verdict verdict = compare(tested, base, false, {});
  EXPECT_FALSE(verdict.agrees);
  EXPECT_EQ(verdict.worst_block, 1U);
}

TEST(Comparison, PairsCancelSharedNoise) {
  const std::vector<double> a{1.0, 5.0, 2.0, 4.0}, b{1.1, 4.9, 2.1, 3.9};
  EXPECT_NEAR(paired_difference_of(a, b).standard_error, 0.2 / std::sqrt(12.0), 1e-4);
  EXPECT_GT(difference_of(a, b).standard_error, 1.0);
}

TEST(Comparison, LightAddsUp) {
  Images sum(kSize);
  const std::vector<float> ones(static_cast<size_t>(kSize.x * kSize.y) * 3, 1.0f);
  for (int part = 0; part < 3; ++part) {
    Images images(kSize);
    images.add(ones);
    sum.add_light(images);
  }
  EXPECT_EQ(sum.seeds(), 1U);
  EXPECT_NEAR(sum.mean(), 3.0, 1e-12);
  EXPECT_NEAR(sum.block(11)[0], 3.0, 1e-12);
}

} // namespace
} // namespace kindling::test
