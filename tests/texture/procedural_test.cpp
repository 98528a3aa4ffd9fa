// Tests of procedural nodes against values computed by hand, and of their compilation.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/noise.h"
#include "tests/texture/graph_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <tuple>
#include <vector>

namespace kindling::test {
namespace {

using K = ProceduralKind;
using T = ProceduralType;
using Node = GraphBuilder::Node;

// Returns the value of a node whose first input varies over the surface, and checks that the value
// is the same with a constant input, where the whole graph is folded.
float scalar(K kind, float x, std::initializer_list<std::pair<std::string_view, Given>> others = {},
             std::string_view first = "in") {
  float values[2] = {};
  for (const bool varying : {false, true}) {
    GraphBuilder g;
    const Node uv = g.add(K::texcoord, T::vector2);
    const Node u = varying ? g.add(K::extract, T::float_, {{"in", uv}, {"index", 0.0f}})
                           : g.add(K::constant, T::float_, {{"value", x}});
    std::vector<std::pair<std::string_view, Given>> given{{first, u}};
    given.insert(given.end(), others);
    // 100 is added because negative values would be clamped.
    const Node sum = g.add(K::add, T::float_, {{"in1", g.add(kind, T::float_, given)}, {"in2", 100.0f}});
    const ProceduralTexture texture = g.texture(sum);
    EXPECT_EQ(texture.instruction_count() > 0, varying);
    values[varying ? 1 : 0] = value_at(texture, V3f(x, 0.3f, 0.7f)).x - 100.0f;
  }
  EXPECT_NEAR(values[0], values[1], 1e-5f) << definition_of(kind).name;
  return values[1];
}

constexpr float kTolerance = 1.6e-5f; // two roundings of 100

TEST(ProceduralNodes, Math) {
  EXPECT_NEAR(scalar(K::add, 0.25f, {{"in2", 0.5f}}, "in1"), 0.75f, kTolerance);
  EXPECT_NEAR(scalar(K::subtract, 0.25f, {{"in2", 0.5f}}, "in1"), -0.25f, kTolerance);
  EXPECT_NEAR(scalar(K::multiply, 0.25f, {{"in2", -3.0f}}, "in1"), -0.75f, kTolerance);
  EXPECT_NEAR(scalar(K::divide, 0.25f, {{"in2", 0.5f}}, "in1"), 0.5f, kTolerance);
  EXPECT_NEAR(scalar(K::modulo, 7.25f, {{"in2", 2.0f}}, "in1"), 1.25f, kTolerance);
  EXPECT_NEAR(scalar(K::modulo, -0.25f, {{"in2", 2.0f}}, "in1"), 1.75f, kTolerance);
  EXPECT_NEAR(scalar(K::power, 0.25f, {{"in2", 0.5f}}, "in1"), 0.5f, kTolerance);
  EXPECT_NEAR(scalar(K::min, 0.25f, {{"in2", -0.5f}}, "in1"), -0.5f, kTolerance);
  EXPECT_NEAR(scalar(K::max, 0.25f, {{"in2", -0.5f}}, "in1"), 0.25f, kTolerance);
  EXPECT_NEAR(scalar(K::atan2, 1.0f, {{"inx", -1.0f}}, "iny"), 2.3561945f, kTolerance);
  EXPECT_NEAR(scalar(K::absval, -0.75f), 0.75f, kTolerance);
  EXPECT_NEAR(scalar(K::sign, -0.75f), -1.0f, kTolerance);
  EXPECT_NEAR(scalar(K::floor, -0.75f), -1.0f, kTolerance);
  EXPECT_NEAR(scalar(K::ceil, 0.25f), 1.0f, kTolerance);
  EXPECT_NEAR(scalar(K::round, 1.75f), 2.0f, kTolerance);
  EXPECT_NEAR(scalar(K::fract, -0.75f), 0.25f, kTolerance);
  EXPECT_NEAR(scalar(K::sqrt, 6.25f), 2.5f, kTolerance);
  EXPECT_NEAR(scalar(K::exp, 1.0f), 2.7182818f, kTolerance);
  EXPECT_NEAR(scalar(K::ln, 2.7182818f), 1.0f, kTolerance);
  EXPECT_NEAR(scalar(K::sin, 0.5f), 0.47942554f, kTolerance);
  EXPECT_NEAR(scalar(K::cos, 0.5f), 0.87758256f, kTolerance);
  EXPECT_NEAR(scalar(K::tan, 0.5f), 0.54630249f, kTolerance);
  EXPECT_NEAR(scalar(K::asin, 0.5f), 0.52359878f, kTolerance);
  EXPECT_NEAR(scalar(K::acos, 0.5f), 1.0471976f, kTolerance);
  EXPECT_NEAR(scalar(K::clamp, 1.5f, {{"low", 0.25f}, {"high", 0.75f}}), 0.75f, kTolerance);
  EXPECT_NEAR(scalar(K::mix, 0.8f, {{"bg", 0.2f}, {"mix", 0.25f}}, "fg"), 0.35f, kTolerance);
  EXPECT_NEAR(scalar(K::smoothstep, 0.5f, {{"low", 0.25f}, {"high", 1.25f}}), 0.15625f, kTolerance);
  EXPECT_NEAR(scalar(K::smoothstep, 2.5f, {{"low", 0.25f}, {"high", 1.25f}}), 1.0f, kTolerance);
  EXPECT_NEAR(scalar(K::remap, 0.5f, {{"inlow", -1.0f}, {"inhigh", 1.0f}, {"outlow", 2.0f}, {"outhigh", 4.0f}}), 3.5f,
              kTolerance);
  EXPECT_NEAR(scalar(K::range, 0.25f, {{"inlow", 0.0f}, {"inhigh", 1.0f}, {"gamma", 2.0f}, {"outhigh", 3.0f}}), 1.5f,
              kTolerance);
  EXPECT_NEAR(scalar(K::invert, 0.25f), 0.75f, kTolerance);
  EXPECT_NEAR(scalar(K::contrast, 0.25f, {{"amount", 2.0f}, {"pivot", 0.5f}}), 0.0f, kTolerance);
}

TEST(ProceduralNodes, Conditions) {
  const auto test = [](K kind, float x) {
    return scalar(kind, x, {{"value2", 0.5f}, {"in1", 3.0f}, {"in2", 7.0f}, {"none", 0.0f}}, "value1");
  };
  EXPECT_NEAR(test(K::ifgreater, 0.75f), 3.0f, kTolerance);
  EXPECT_NEAR(test(K::ifgreater, 0.5f), 7.0f, kTolerance);
  EXPECT_NEAR(test(K::ifgreatereq, 0.5f), 3.0f, kTolerance);
  EXPECT_NEAR(test(K::ifequal, 0.5f), 3.0f, kTolerance);
  EXPECT_NEAR(test(K::ifequal, 0.25f), 7.0f, kTolerance);
  for (const float which : {0.0f, 1.0f, 2.0f}) {
    EXPECT_NEAR(scalar(K::switch_, which, {{"in1", 1.0f}, {"in2", 2.0f}, {"in3", 3.0f}, {"none", 0.0f}}, "which"),
                1.0f + which, kTolerance);
  }
}

TEST(ProceduralNodes, Vectors) {
  GraphBuilder g;
  const Node p = g.add(K::position, T::vector3); // (3, 4, 12)
  const V3f at(3.0f, 4.0f, 12.0f);
  const auto value = [&](Node node) { return value_at(g.texture(node), at); };
  EXPECT_EQ(value(g.add(K::dotproduct, T::float_, {{"in1", p}, {"in2", V3f(1, 2, 3)}})).x, 47.0f);
  EXPECT_EQ(value(g.add(K::magnitude, T::float_, {{"in", p}})).y, 13.0f);
  EXPECT_EQ(value(g.add(K::distance, T::float_, {{"in1", p}, {"in2", V3f(3, 0, 9)}})).x, 5.0f);
  const V4f unit = value(g.add(K::normalize, T::vector3, {{"in", p}}));
  EXPECT_NEAR(unit.z, 12.0f / 13.0f, 1e-6f);
  const V4f cross = value(g.add(K::crossproduct, T::vector3, {{"in1", p}, {"in2", V3f(0, -1, 0)}}));
  EXPECT_EQ(V3f(cross.x, cross.y, cross.z), V3f(12.0f, 0.0f, 0.0f)); // z = -3 is clamped
  const Node separated = g.add(K::separate3, T::float_, {{"in", p}});
  EXPECT_EQ(value({separated.number, 1}).x, 4.0f);
  const Node pair =
      g.add(K::combine2, T::vector2, {{"in1", Node{separated.number, 2}}, {"in2", Node{separated.number, 0}}});
  EXPECT_EQ(value(pair), V4f(12.0f, 3.0f, 0.0f, 1.0f));
  const Node three = g.add(K::combine3, T::color3, {{"in1", 0.5f}, {"in2", Node{separated.number, 0}}, {"in3", 0.25f}});
  EXPECT_EQ(value(three), V4f(0.5f, 3.0f, 0.25f, 1.0f));
  const Node four = g.add(K::combine2, T::color4, {{"in1", three}, {"in2", 0.125f}});
  EXPECT_EQ(value(four), V4f(0.5f, 3.0f, 0.25f, 0.125f));
  EXPECT_EQ(value(g.add(K::convert, T::vector4, {{"in", pair}})), V4f(12.0f, 3.0f, 0.0f, 1.0f));
  EXPECT_EQ(value(g.add(K::convert, T::color3, {{"in", four}})), V4f(0.5f, 3.0f, 0.25f, 1.0f));
  EXPECT_EQ(value(g.add(K::convert, T::color3, {{"in", Node{separated.number, 1}}})), V4f(4.0f, 4.0f, 4.0f, 1.0f));
  EXPECT_NEAR(value(g.add(K::luminance, T::color4, {{"in", four}})).x,
              0.2126f * 0.5f + 0.7152f * 3.0f + 0.0722f * 0.25f, 1e-6f);
  EXPECT_EQ(value(g.add(K::luminance, T::color4, {{"in", four}})).w, 0.125f);
  EXPECT_EQ(value(g.add(K::multiply, T::vector3, {{"in1", p}, {"in2", 2.0f}})), V4f(6.0f, 8.0f, 24.0f, 1.0f));
}

TEST(ProceduralNodes, Placement) {
  GraphBuilder g;
  const Node uv = g.add(K::texcoord, T::vector2);
  const auto place = [&](float order, const V2f& at) {
    const Node node = g.add(K::place2d, T::vector2,
                            {{"texcoord", uv},
                             {"pivot", V2f(0.5f, 0.5f)},
                             {"scale", V2f(0.5f, 2.0f)},
                             {"rotate", 90.0f},
                             {"offset", V2f(-3.0f, -4.0f)},
                             {"operationorder", order}});
    const V4f value = value_at(g.texture(node), V3f(at.x, at.y, 0.0f));
    return V2f(value.x, value.y);
  };
  // Relative to the pivot (0.25, 1); scaled (0.5, 0.5); rotated (0.5, -0.5); minus offset, plus
  // pivot.
  EXPECT_LT((place(0.0f, V2f(0.75f, 1.5f)) - V2f(4.0f, 4.0f)).length(), 1e-5f);
  // Minus pivot and offset (-1.25, 5); rotated (5, 1.25); scaled (10, 0.625); plus pivot.
  EXPECT_LT((place(1.0f, V2f(-3.75f, 1.5f)) - V2f(10.5f, 1.125f)).length(), 1e-5f);
}

TEST(ProceduralNodes, RampsAndSplits) {
  GraphBuilder g;
  const auto at = [&](Node node, float u, float v) { return value_at(g.texture(node), V3f(u, v, 0.0f)).x; };
  const Node lr = g.add(K::ramplr, T::float_, {{"valuel", 1.0f}, {"valuer", 3.0f}});
  EXPECT_NEAR(at(lr, 0.25f, 0.9f), 1.5f, 1e-6f);
  EXPECT_NEAR(at(lr, 7.0f, 0.9f), 3.0f, 1e-6f);
  const Node tb = g.add(K::ramptb, T::float_, {{"valuet", 1.0f}, {"valueb", 3.0f}});
  EXPECT_NEAR(at(tb, 0.25f, 0.75f), 1.5f, 1e-6f);
  const Node split = g.add(K::splitlr, T::float_, {{"valuel", 1.0f}, {"valuer", 3.0f}, {"center", 0.5f}});
  EXPECT_EQ(at(split, 0.45f, 0.0f), 1.0f);
  EXPECT_EQ(at(split, 0.55f, 0.0f), 3.0f);
  const Node split_tb = g.add(K::splittb, T::float_, {{"valuet", 1.0f}, {"valueb", 3.0f}, {"center", 0.5f}});
  EXPECT_EQ(at(split_tb, 0.0f, 0.45f), 3.0f);
  EXPECT_EQ(at(split_tb, 0.0f, 0.55f), 1.0f);
}

TEST(ProceduralNodes, Patterns) {
  GraphBuilder g;
  const V3f p(1.25f, -2.5f, 3.75f);
  const auto value = [&](Node node) { return value_at(g.texture(node), p); };
  // Cells with an odd sum of coordinates have color1.
  const Node board =
      g.add(K::checkerboard, T::color3, {{"color1", V3f(0.5f)}, {"color2", V3f(0.25f)}, {"uvtiling", V2f(2.0f)}});
  for (const auto& [u, v, color] :
       {std::tuple{0.1f, 0.1f, 0.25f}, {0.6f, 0.1f, 0.5f}, {0.6f, 0.6f, 0.25f}, {-0.1f, 0.1f, 0.5f}})
    EXPECT_EQ(value_at(g.texture(board), V3f(u, v, 0.0f)).y, color) << u << " " << v;
  EXPECT_NEAR(value(g.add(K::noise3d, T::float_, {{"amplitude", 2.0f}, {"pivot", 0.5f}})).x, 0.5f + 2.0f * 0.04038083f,
              1e-5f);
  EXPECT_NEAR(value(g.add(K::noise2d, T::vector3, {{"amplitude", V3f(1, 2, 3)}, {"pivot", 5.0f}})).y,
              5.0f + 2.0f * noise::perlin_rgb(V2f(p.x, p.y)).y, 1e-5f);
  const V4f four = value(g.add(K::noise3d, T::vector4, {{"amplitude", V4f(1.0f)}, {"pivot", 5.0f}}));
  EXPECT_NEAR(four.w, 5.0f + noise::perlin(p + V3f(19, 73, 29)), 1e-5f);
  const Node fractal = g.add(K::fractal3d, T::float_,
                             {{"octaves", 3.0f}, {"lacunarity", 2.5f}, {"diminish", 0.4f}, {"amplitude", 2.0f}});
  const Node raised = g.add(K::add, T::float_, {{"in1", fractal}, {"in2", 5.0f}});
  EXPECT_NEAR(value(raised).x,
              5.0f + 2.0f * (noise::perlin(p) + 0.4f * noise::perlin(p * 2.5f) + 0.16f * noise::perlin(p * 6.25f)),
              2e-5f);
  EXPECT_NEAR(value(g.add(K::cellnoise2d, T::float_)).x, noise::cell(V2f(p.x, p.y)), 1e-6f);
  V3f nearest;
  const V3f distances = noise::worley(p, 0.5f, nearest);
  EXPECT_NEAR(value(g.add(K::worleynoise3d, T::vector3, {{"jitter", 0.5f}})).z, distances.z, 1e-6f);
  EXPECT_NEAR(value(g.add(K::worleynoise3d, T::float_, {{"jitter", 0.5f}, {"style", 1.0f}})).x, noise::cell(nearest),
              1e-6f);
}

TEST(ProceduralTexture, ClampsToRangeOfTexels) {
  GraphBuilder g;
  const Node p = g.add(K::position, T::vector3);
  EXPECT_EQ(value_at(g.texture(p), V3f(-1.0f, 1e9f, 0.5f)), V4f(0.0f, 65504.0f, 0.5f, 1.0f));
  const Node nothing = g.add(K::divide, T::vector3, {{"in1", p}, {"in2", 0.0f}});
  EXPECT_EQ(value_at(g.texture(nothing), V3f(0.0f, 1.0f, -1.0f)), V4f(0.0f, 65504.0f, 0.0f, 1.0f));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(value_at(g.texture(g.add(K::noise3d, T::float_, {{"pivot", 0.5f}})), V3f(nan)).x, 0.5f);
  EXPECT_TRUE(g.texture(g.add(K::convert, T::color4, {{"in", p}})).has_alpha());
  EXPECT_FALSE(g.texture(p).has_alpha());
}

TEST(ProceduralTexture, RemovesNeedlessInstructions) {
  GraphBuilder g;
  const Node a = g.add(K::constant, T::float_, {{"value", 2.0f}});
  const Node b = g.add(K::multiply, T::float_, {{"in1", a}, {"in2", 3.0f}});
  static_cast<void>(g.add(K::noise3d, T::float_));
  EXPECT_EQ(g.texture(b).instruction_count(), 0U);
  EXPECT_TRUE(g.texture(b).streams.empty() || g.texture(b).instruction_count() == 0);
  EXPECT_EQ(value_at(g.texture(b), V3f(0.0f)).x, 6.0f);
  // Amplitude 1 and pivot 0 are folded, which leaves position and noise.
  EXPECT_EQ(g.texture(g.add(K::noise3d, T::float_)).instruction_count(), 2U);
}

TEST(ProceduralTexture, DefinitionsHaveDistinctNames) {
  std::set<std::string_view> names;
  for (const ProceduralDefinition& definition : procedural_definitions()) {
    EXPECT_TRUE(names.insert(definition.name).second) << definition.name;
    EXPECT_EQ(find_procedural_definition(definition.name), &definition);
    std::set<std::string_view> inputs;
    for (const ProceduralInputRule& rule : definition.inputs) EXPECT_TRUE(inputs.insert(rule.name).second) << rule.name;
  }
  EXPECT_EQ(find_procedural_definition("wood"), nullptr);
}

} // namespace
} // namespace kindling::test
