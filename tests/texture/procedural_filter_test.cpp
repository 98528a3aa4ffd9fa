// Tests of filtered procedural textures: means, variance reduction and point counts.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/hash.h"
#include "tests/texture/graph_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using K = ProceduralKind;
using T = ProceduralType;
using Node = GraphBuilder::Node;

struct Pattern {
  std::string name;
  bool filters_itself;
  std::function<Node(GraphBuilder&)> make; // features of about size 1, values from 0 to 1
};

Node turbulence(GraphBuilder& g, int octaves) {
  const Node p = g.add(K::position, T::vector3);
  Node sum{-1};
  float scale = 1.0f;
  for (int i = 0; i < octaves; ++i, scale *= 2.0f) {
    const Node at = g.add(K::multiply, T::vector3, {{"in1", p}, {"in2", scale}});
    const Node octave = g.add(K::absval, T::float_, {{"in", g.add(K::noise3d, T::float_, {{"position", at}})}});
    const Node weighed = g.add(K::multiply, T::float_, {{"in1", octave}, {"in2", 1.0f / scale}});
    sum = i == 0 ? weighed : g.add(K::add, T::float_, {{"in1", sum}, {"in2", weighed}});
  }
  return sum;
}

std::vector<Pattern> patterns() {
  const auto raised = [](GraphBuilder& g, Node x) {
    return g.add(K::remap, T::float_, {{"in", x}, {"inlow", -2.0f}, {"inhigh", 2.0f}});
  };
  return {
      {"checkerboard", true,
       [](GraphBuilder& g) {
         return g.add(K::checkerboard, T::color3,
                      {{"color1", V3f(0.9f)}, {"color2", V3f(0.1f)}, {"uvtiling", V2f(1.0f, 1.0f)}});
       }},
      {"stripes", true,
       [](GraphBuilder& g) {
         const Node u = g.add(K::extract, T::float_, {{"in", g.add(K::texcoord, T::vector2)}, {"index", 0.0f}});
         const Node saw = g.add(K::modulo, T::float_, {{"in1", u}, {"in2", 1.5f}});
         return g.add(K::ifgreater, T::float_, {{"value1", 0.5f}, {"value2", saw}, {"in1", 0.8f}, {"in2", 0.2f}});
       }},
      {"sine", true,
       [](GraphBuilder& g) {
         const Node x =
             g.add(K::dotproduct, T::float_, {{"in1", g.add(K::position, T::vector3)}, {"in2", V3f(3, 2, 0)}});
         return g.add(K::add, T::float_, {{"in1", g.add(K::sin, T::float_, {{"in", x}})}, {"in2", 1.0f}});
       }},
      {"noise", true, [&](GraphBuilder& g) { return raised(g, g.add(K::noise3d, T::float_)); }},
      {"fractal", true,
       [&](GraphBuilder& g) {
         return raised(g, g.add(K::fractal2d, T::float_, {{"octaves", 4.0f}}));
       }},
      {"turbulence", true, [](GraphBuilder& g) { return turbulence(g, 4); }},
      {"cells", true, [](GraphBuilder& g) { return g.add(K::cellnoise3d, T::float_); }},
      {"worley", true, [](GraphBuilder& g) { return g.add(K::worleynoise2d, T::float_); }},
      {"squared noise", false,
       [](GraphBuilder& g) {
         const Node n = g.add(K::noise3d, T::float_);
         return g.add(K::multiply, T::float_, {{"in1", n}, {"in2", n}});
       }},
      {"marble", false,
       [](GraphBuilder& g) {
         const Node x = g.add(K::extract, T::float_, {{"in", g.add(K::position, T::vector3)}, {"index", 0.0f}});
         const Node warp = g.add(K::multiply, T::float_, {{"in1", turbulence(g, 4)}, {"in2", 4.0f}});
         const Node wave = g.add(K::sin, T::float_, {{"in", g.add(K::add, T::float_, {{"in1", x}, {"in2", warp}})}});
         return g.add(K::power, T::float_,
                      {{"in1", g.add(K::remap, T::float_, {{"in", wave}, {"inlow", -1.0f}})}, {"in2", 0.6f}});
       }},
      {"thresholded cells", false,
       [](GraphBuilder& g) {
         return g.add(K::ifgreater, T::float_,
                      {{"value1", g.add(K::cellnoise2d, T::float_)}, {"value2", 0.7f}, {"in1", 0.9f}, {"in2", 0.1f}});
       }},
  };
}

V2f random_shift(uint32_t k) { return {to_unit_float(hash_u32(2 * k)), to_unit_float(hash_u32(2 * k + 1))}; }

// Returns a random point near a plane that is not aligned with the lattice.
V3f point(uint32_t k, float range) {
  const float x = to_unit_float(hash_u32(3 * k + 77)) * range, y = to_unit_float(hash_u32(3 * k + 78)) * range;
  return {x, y, 0.37f + 0.01f * static_cast<float>(k % 64)};
}

struct Moments {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  void add(double x) { sum += x, squares += x * x, ++count; }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double variance() const { return std::max(squares / count - mean() * mean(), 0.0); }
};

// With increasing footprints the mean over all points stays constant, and the variance decreases.
TEST(ProceduralFilter, KeepsMeanAndReducesVariance) {
  for (const Pattern& pattern : patterns()) {
    GraphBuilder g;
    const ProceduralTexture texture = g.texture(pattern.make(g));
    EXPECT_EQ(texture.filters_itself(), pattern.filters_itself) << pattern.name;
    constexpr uint32_t kPoints = 6000;
    Moments sharp;
    for (uint32_t k = 0; k < 4 * kPoints; ++k) sharp.add(value_at(texture, point(k, 3000.0f)).x);
    double last = sharp.variance();
    for (const float width : {0.3f, 1.0f, 3.0f, 20.0f}) {
      Moments seen;
      for (uint32_t k = 0; k < kPoints; ++k)
        seen.add(value_at(texture, point(k + 50000, 3000.0f), width, random_shift(k)).x);
      const double error = 4.5 * std::sqrt(sharp.variance() / sharp.count + seen.variance() / seen.count) + 1e-4 +
                           (width >= 3.0f ? 0.004 * sharp.mean() : 0.0); // means of |noise| and Worley are rounded
      EXPECT_NEAR(seen.mean(), sharp.mean(), error) << pattern.name << " at " << width;
      EXPECT_LE(seen.variance(), last * 1.1 + 0.01 * sharp.variance()) << pattern.name << " at " << width;
      last = seen.variance();
    }
    EXPECT_LT(last, sharp.variance() / (pattern.filters_itself ? 100.0 : 12.0)) << pattern.name;
  }
}

// A filtered value is closer than a single point to the true mean over the footprint, computed from
// many points.
TEST(ProceduralFilter, ApproximatesMeanOverFootprint) {
  for (const Pattern& pattern : patterns()) {
    GraphBuilder g;
    const ProceduralTexture texture = g.texture(pattern.make(g));
    for (const float width : {0.25f, 0.7f, 2.5f}) {
      double filtered_error = 0.0, sharp_error = 0.0;
      for (uint32_t k = 0; k < 150; ++k) {
        const V3f at = point(k, 50.0f);
        constexpr int kSide = 16;
        double truth = 0.0;
        for (int i = 0; i < kSide * kSide; ++i) {
          const V2f shift = random_shift(static_cast<uint32_t>(i) + 1000 * k);
          const float x = (static_cast<float>(i % kSide) + shift.x) / kSide - 0.5f;
          const float y = (static_cast<float>(i / kSide) + shift.y) / kSide - 0.5f;
          truth += value_at(texture, at + V3f(x * width, y * width, 0.0f)).x;
        }
        truth /= kSide * kSide;
        // A single random point of the footprint, like that of a ray.
        const V2f shift = random_shift(k + 999999);
        const V3f somewhere = at + V3f((shift.x - 0.5f) * width, (shift.y - 0.5f) * width, 0.0f);
        filtered_error += std::pow(value_at(texture, at, width, shift).x - truth, 2.0);
        sharp_error += std::pow(value_at(texture, somewhere).x - truth, 2.0);
      }
      EXPECT_LT(filtered_error, sharp_error * (width < 0.5f ? 0.75 : 0.45)) << pattern.name << " at " << width;
    }
  }
}

// The integral is exact if the edges of the pattern are parallel to the axes.
TEST(ProceduralFilter, ChecksAndStripesAreExact) {
  GraphBuilder g;
  const ProceduralTexture board = g.texture(patterns()[0].make(g));
  // A square of side 1 around (1, 0.5) has half of each color.
  EXPECT_NEAR(value_at(board, V3f(1.0f, 0.5f, 0.0f), 1.0f).x, 0.5f, 1e-5f);
  // A square of side 0.5 around (0.9, 0.5) has 0.35 of 0.5 in cell (0, 0).
  EXPECT_NEAR(value_at(board, V3f(0.9f, 0.5f, 0.0f), 0.5f).x, 0.1f + 0.8f * 0.3f, 1e-5f);
  EXPECT_NEAR(value_at(board, V3f(0.5f, 0.5f, 0.0f), 0.5f).x, 0.1f, 1e-5f);
  EXPECT_NEAR(value_at(board, V3f(0.3f, 0.9f, 0.0f), 1e5f).x, 0.5f, 1e-3f);
  const ProceduralTexture stripes = g.texture(patterns()[1].make(g));
  EXPECT_NEAR(value_at(stripes, V3f(0.25f, 0.0f, 0.0f), 0.25f).x, 0.8f, 1e-5f);
  EXPECT_NEAR(value_at(stripes, V3f(0.25f, 0.0f, 0.0f), 1.5f).x, 0.4f, 1e-5f); // a whole period
  EXPECT_NEAR(value_at(stripes, V3f(0.5f, 0.0f, 0.0f), 0.4f).x, 0.5f, 1e-5f);  // over an edge
}

TEST(ProceduralFilter, PointCountFollowsFootprint) {
  GraphBuilder g;
  const ProceduralTexture marble = g.texture(patterns()[9].make(g));
  const auto count = [&](float width) {
    const auto samples = streams_at(marble, V3f(0.5f), width);
    return marble.point_count({samples.data(), marble.streams.size()});
  };
  EXPECT_EQ(count(0.0f), 1);
  EXPECT_EQ(count(1e-3f), 1);
  EXPECT_EQ(count(0.5f), 16);
  const ProceduralTexture board = g.texture(patterns()[0].make(g));
  const auto samples = streams_at(board, V3f(0.5f), 3.0f);
  EXPECT_EQ(board.point_count({samples.data(), board.streams.size()}), 1);
}

} // namespace
} // namespace kindling::test
