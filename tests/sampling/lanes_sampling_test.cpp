// Eight samples at once have the bits of eight single ones: warps, pixel filters, draws, cells.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/bounce_draws.h"
#include "renderer/sampling/distribution_2d.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/spherical_triangle.h"
#include "renderer/sampling/warp.h"
#include "tests/base/same_bits.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <vector>

namespace kindling {
namespace {

using test::lane_of;
using test::same_bits;

constexpr int kVectors = 125'000; // a million numbers

// Draws whose ends are as frequent as the interior.
float edge_draw(test::Random& random) {
  const float u = random.next_1d();
  return random.next_u64() % 16 == 0 ? (u < 0.5f ? 0.0f : kOneMinusEpsilon) : u;
}

TEST(LanesSampling, SinesAndCosinesOfTurns) {
  test::Random random(1);
  for (int i = 0; i < kVectors; ++i) {
    LaneNumbers turns;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane)
      turns[lane] = (random.next_1d() - 0.5f) * (i % 2 == 0 ? 4.0f : 1e5f);
    const SinCosOf<Lanes> found = sincos_turns(turns.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const SinCos expected = sincos_turns(turns[lane]);
      ASSERT_TRUE(same_bits(found.sin[lane], expected.sin) && same_bits(found.cos[lane], expected.cos)) << turns[lane];
    }
  }
}

// The center of the disk and its corners are among them.
TEST(LanesSampling, DisksAndHemispheres) {
  test::Random random(12);
  for (int i = 0; i < kVectors; ++i) {
    LaneNumbers x, y;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const bool at_center = random.next_u64() % 16 == 0;
      x[lane] = at_center ? 0.5f : edge_draw(random);
      y[lane] = at_center ? 0.5f : random.next_u64() % 16 == 0 ? x[lane] : edge_draw(random);
    }
    const Imath::Vec2<Lanes> u(x.load(), y.load());
    const auto on_disk = sample_uniform_disk(u);
    const auto direction = sample_cosine_hemisphere(u);
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const V2f alone(x[lane], y[lane]);
      ASSERT_TRUE(same_bits(lane_of(on_disk, lane), sample_uniform_disk(alone))) << alone;
      ASSERT_TRUE(same_bits(lane_of(direction, lane), sample_cosine_hemisphere(alone))) << alone;
    }
  }
}

// The triangles are large and small, near and far. Some are degenerate, some are seen edge-on, and
// some have the point at a corner.
TEST(LanesSampling, SphericalTriangles) {
  test::Random random(2);
  int degenerate = 0;
  const auto vector = [&](float scale) {
    const float x = random.next_1d(), y = random.next_1d(), z = random.next_1d();
    return V3f(x - 0.5f, y - 0.5f, z - 0.5f) * scale;
  };
  for (int i = 0; i < kVectors; ++i) {
    LaneVectors p0, p1, p2, from;
    LaneNumbers u_x, u_y;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const uint64_t kind = random.next_u64() % 16;
      const float size = kind < 4 ? 1e-3f : 1.0f;
      p0.set(lane, vector(2.0f));
      p1.set(lane, p0[lane] + vector(size));
      p2.set(lane, kind == 4 ? p1[lane] : p0[lane] + vector(size));
      from.set(lane, kind == 5 ? p0[lane] : kind == 6 ? p0[lane] * 2.0f - p1[lane] : vector(2.0f));
      u_x[lane] = edge_draw(random), u_y[lane] = edge_draw(random);
    }
    const SphericalTriangleOf<Lanes> triangles(p0.load(), p1.load(), p2.load(), from.load());
    const auto found = triangles.sample({u_x.load(), u_y.load()});
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const SphericalTriangle triangle(p0[lane], p1[lane], p2[lane], from[lane]);
      ASSERT_TRUE(same_bits(triangles.pdf()[lane], triangle.pdf()));
      ASSERT_TRUE(same_bits(triangles.solid_angle()[lane], triangle.solid_angle()));
      if (!(triangle.pdf() > 0.0f)) {
        ++degenerate;
        continue;
      }
      const SphericalTriangle::Sample expected = triangle.sample({u_x[lane], u_y[lane]});
      ASSERT_TRUE(same_bits(lane_of(found.direction, lane), expected.direction));
      ASSERT_TRUE(same_bits(lane_of(found.barycentrics, lane), expected.barycentrics));
    }
  }
  EXPECT_GT(degenerate, kVectors / 4);
}

TEST(LanesSampling, PixelFilters) {
  for (const FilterKind kind :
       {FilterKind::blackman_harris, FilterKind::gaussian, FilterKind::box, FilterKind::mitchell}) {
    const PixelFilter filter({kind, 0.0f});
    test::Random random(3);
    for (int i = 0; i < kVectors; ++i) {
      LaneNumbers u_x, u_y;
      for (size_t lane = 0; lane < Lanes::kCount; ++lane) u_x[lane] = edge_draw(random), u_y[lane] = edge_draw(random);
      const PixelFilter::SampleOf<Lanes> found = filter.sample(Imath::Vec2<Lanes>(u_x.load(), u_y.load()));
      for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
        const PixelFilter::Sample expected = filter.sample(V2f(u_x[lane], u_y[lane]));
        ASSERT_TRUE(same_bits(lane_of(found.offset, lane), expected.offset)) << filter_name(kind);
        ASSERT_EQ(found.weight[lane], expected.weight) << filter_name(kind);
      }
    }
  }
}

TEST(LanesSampling, BitsInReverseOrder) {
  test::Random random(6);
  for (int i = 0; i < 100'000; ++i) {
    Words8 words;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane)
      words[lane] = i < 32 ? 1U << i : static_cast<uint32_t>(random.next_u64());
    const Words8 reversed = owen_sobol::reverse_bits(words);
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const uint32_t word = words[lane];
      ASSERT_EQ(reversed[lane], owen_sobol::reverse_bits(word));
      if (i < 32) {
        ASSERT_EQ(reversed[lane], 0x80000000U >> i);
      }
    }
  }
}

TEST(LanesSampling, DrawsOfAnyNumberOfVertices) {
  for (const SamplerKind kind :
       {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::independent, SamplerKind::jittered}) {
    const Sampler sampler(7, kind, 64);
    test::Random random(4);
    for (size_t count = 0; count <= 40; ++count) {
      for (int repeat = 0; repeat < 100; ++repeat) {
        std::vector<BounceAddress> addresses(count);
        for (BounceAddress& at : addresses) {
          const auto x = static_cast<int>(random.next_u64() % 500), y = static_cast<int>(random.next_u64() % 500);
          at.address = sampler.address({x, y}, static_cast<uint32_t>(random.next_u64() % 64));
          at.dimension = 8 + 8 * static_cast<uint32_t>(random.next_u64() % 20);
        }
        std::vector<BounceDraws> draws(count);
        draw_bounces(addresses, draws);
        std::vector<LightDraws> lights(count);
        draw_lights(addresses, lights);
        for (size_t i = 0; i < count; ++i) {
          const BounceDraws expected = draw_bounce(addresses[i].address, addresses[i].dimension);
          ASSERT_EQ(draws[i].choice, expected.choice) << sampler_name(kind) << ", " << i << " of " << count;
          ASSERT_EQ(draws[i].direction, expected.direction);
          ASSERT_EQ(draws[i].light, expected.light);
          ASSERT_EQ(draws[i].roulette, expected.roulette);
          ASSERT_EQ(draws[i].spare, expected.spare);
          ASSERT_EQ(lights[i].light, expected.light);
          ASSERT_EQ(lights[i].spare, expected.spare);
        }
      }
    }
  }
}

TEST(LanesSampling, CellsOfManyDraws) {
  test::Random random(5);
  std::vector<float> weights(97 * 31);
  for (float& weight : weights) weight = random.next_1d() < 0.3f ? 0.0f : random.next_1d();
  const Distribution2D distribution(weights, 97, 31);
  for (size_t count = 0; count < 200; ++count) {
    std::vector<V2f> draws(count);
    for (V2f& u : draws) {
      const float x = edge_draw(random);
      u = {x, edge_draw(random)};
    }
    std::vector<Distribution2D::Cell> cells(count);
    distribution.find(draws, cells);
    for (size_t i = 0; i < count; ++i) {
      const Distribution2D::Sample expected = distribution.sample(draws[i]);
      ASSERT_EQ(cells[i].column, expected.column);
      ASSERT_EQ(cells[i].row, expected.row);
      ASSERT_EQ(distribution.find(draws[i]).column, expected.column);
      ASSERT_EQ(distribution.find(draws[i]).row, expected.row);
    }
  }
}

} // namespace
} // namespace kindling
