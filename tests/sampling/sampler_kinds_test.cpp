// Exact tests of each kind of sampler: nets over samples and squares of pixels, distinct addresses.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/bounce_draws.h"
#include "renderer/sampling/sampler.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace kindling {
namespace {

constexpr SamplerKind kStratified[] = {SamplerKind::blue_noise, SamplerKind::sobol};

using Point = std::array<float, 4>;

// Returns the maximum number of points in one box of sides 2^-bits[c]. If there are as many points
// as boxes, 1 means a net.
uint32_t max_in_a_box(const std::vector<Point>& points, const std::array<uint32_t, 4>& bits) {
  std::vector<uint32_t> counts(size_t{1} << (bits[0] + bits[1] + bits[2] + bits[3]), 0);
  uint32_t result = 0;
  for (const Point& p : points) {
    size_t box = 0;
    for (size_t c = 0; c < 4; ++c)
      box = (box << bits[c]) | static_cast<size_t>(p[c] * static_cast<float>(1U << bits[c]));
    result = std::max(result, ++counts[box]);
  }
  return result;
}

// Both sets of a bounce, as points of four dimensions.
Point first_set(const BounceDraws& u) { return {u.choice.x, u.choice.y, u.direction.x, u.direction.y}; }
Point second_set(const BounceDraws& u) { return {u.light.x, u.light.y, u.roulette, u.spare}; }

std::vector<Point> bounce_points(const Sampler& sampler, const V2i& pixel, uint32_t first, uint32_t count,
                                 uint32_t dimension, bool second) {
  std::vector<Point> points;
  for (uint32_t i = first; i < first + count; ++i) {
    const BounceDraws u = draw_bounce(sampler.address(pixel, i), dimension);
    points.push_back(second ? second_set(u) : first_set(u));
  }
  return points;
}

TEST(SamplerKinds, NamesRoundTrip) {
  for (const SamplerKind kind :
       {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::independent, SamplerKind::jittered})
    EXPECT_EQ(sampler_from_name(sampler_name(kind)), kind);
  EXPECT_FALSE(sampler_from_name("Sobol"));
  EXPECT_FALSE(sampler_from_name(""));
}

// Any 4^m aligned samples have one point in each box of every shape, in base 4.
TEST(SamplerKinds, BounceSetsAreNetsOfFourDimensions) {
  for (const SamplerKind kind : kStratified)
    for (const bool second : {false, true})
      for (uint32_t m = 0; m <= 4; ++m)
        for (const uint32_t block : {0U, 3U}) {
          const Sampler sampler(m, kind, 4U << (2 * m));
          const std::vector<Point> points =
              bounce_points(sampler, {200, 31}, block << (2 * m), 1U << (2 * m), 8 * m, second);
          for (uint32_t a = 0; a <= m; ++a)
            for (uint32_t b = 0; a + b <= m; ++b)
              for (uint32_t c = 0; a + b + c <= m; ++c)
                ASSERT_EQ(max_in_a_box(points, {2 * a, 2 * b, 2 * c, 2 * (m - a - b - c)}), 1U)
                    << sampler_name(kind) << " m " << m << ": " << a << " " << b << " " << c;
        }
}

// Any 2^k aligned samples are a net in the pairs of dimensions that are used together.
TEST(SamplerKinds, BouncePairsAreNetsOfTwoDimensions) {
  for (const SamplerKind kind : kStratified)
    for (const bool second : {false, true})
      for (uint32_t k = 0; k <= 9; ++k)
        for (const uint32_t block : {0U, 5U}) {
          const Sampler sampler(k + 7, kind, 8U << k);
          const std::vector<Point> points = bounce_points(sampler, {5, 1031}, block << k, 1U << k, 24, second);
          for (uint32_t a = 0; a <= k; ++a) {
            ASSERT_EQ(max_in_a_box(points, {a, k - a, 0, 0}), 1U) << sampler_name(kind) << " k " << k << " a " << a;
            ASSERT_EQ(max_in_a_box(points, {0, 0, a, k - a}), 1U) << sampler_name(kind) << " k " << k << " a " << a;
          }
        }
}

// With blue noise, all samples of an aligned square of pixels are one net.
TEST(SamplerKinds, SquaresOfPixelsAreNets) {
  for (const uint32_t log2_samples : {0U, 1U, 2U, 4U})
    for (const uint32_t log2_side : {1U, 2U, 3U}) {
      const Sampler sampler(3, SamplerKind::blue_noise, 1U << log2_samples);
      const uint32_t k = log2_samples + 2 * log2_side;
      std::vector<Point> film, bounce;
      const int side = 1 << log2_side;
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
          for (uint32_t i = 0; i < 1U << log2_samples; ++i) {
            const SampleAddress address = sampler.address({5 * side + x, 18 * side + y}, i);
            const V2f u = Sampler::sample_2d(address, 0);
            film.push_back({u.x, u.y, 0.0f, 0.0f});
            bounce.push_back(first_set(draw_bounce(address, 8)));
          }
      for (uint32_t a = 0; a <= k; ++a) {
        ASSERT_EQ(max_in_a_box(film, {a, k - a, 0, 0}), 1U) << k << " " << a;
        ASSERT_EQ(max_in_a_box(bounce, {0, 0, a, k - a}), 1U) << k << " " << a;
      }
      if (k % 2 == 0) {
        for (uint32_t a = 0; a <= k / 2; ++a)
          ASSERT_EQ(max_in_a_box(bounce, {2 * a, 0, k - 2 * a, 0}), 1U) << k << " " << a;
      }
    }
}

// No two samples of a tile or of a pixel have the same address, even beyond the planned number of
// samples.
TEST(SamplerKinds, AddressesDiffer) {
  for (const SamplerKind kind :
       {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::independent, SamplerKind::jittered})
    for (const uint32_t planned : {1U, 3U, 64U, 1U << 20, 0xffffffffU}) {
      const Sampler sampler(1, kind, planned);
      std::vector<uint64_t> seen;
      for (int y = 0; y < 16; ++y)
        for (int x = 120; x < 136; ++x)
          for (uint32_t i = 0; i < 70; ++i) {
            const SampleAddress address = sampler.address({x, y}, i);
            seen.push_back(uint64_t{address.key} << 32 | address.index);
          }
      std::sort(seen.begin(), seen.end());
      EXPECT_EQ(std::adjacent_find(seen.begin(), seen.end()), seen.end()) << sampler_name(kind) << " " << planned;
    }
}

TEST(SamplerKinds, BounceDrawsMatchSingleDraws) {
  for (uint32_t i = 0; i < 1000; ++i) {
    const SampleAddress address{i * 2654435761U, i * 40503U};
    const BounceDraws u = draw_bounce(address, i);
    ASSERT_EQ(u.choice, Sampler::sample_2d(address, i));
    ASSERT_EQ(u.light, Sampler::sample_2d(address, i + 1));
  }
}

} // namespace
} // namespace kindling
