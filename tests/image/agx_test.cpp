// The AgX curve against nodes of Blender's table, and at the ends of its range.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/agx.h"
#include "renderer/image/display_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kindling {
namespace {

// IEC 61966-2-1.
float srgb_of(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

struct Node {
  Rgb scene;   // linear Rec. 709
  Rgb display; // sRGB-encoded
};

// Nodes of AgX_Base_sRGB.cube as Blender 4.5 ships it (57 nodes a side, E-Gamut, -10 to +15 stops;
// values to the power of 2.4), which no interpolation blurs. 1e-5 covers the six digits of the
// table and single precision.
TEST(Agx, EqualsNodesOfBlendersTable) {
  const Node nodes[] = {{{0.01681394f, 0.01681425f, 0.02724546f}, {0.109218f, 0.114628f, 0.153229f}},
                        {{0.02587106f, 0.003052111f, 0.02082761f}, {0.140648f, 0.033723f, 0.126766f}},
                        {{0.2014865f, 0.01132843f, 0.00410989f}, {0.465698f, 0.092934f, 0.0f}},
                        {{0.7355766f, 0.04921727f, 0.8975612f}, {0.728545f, 0.464128f, 0.777208f}},
                        {{2.495328f, 0.6895982f, 2.096298f}, {0.883539f, 0.762625f, 0.860844f}},
                        {{0.1656322f, 0.01954028f, 0.1333429f}, {0.428226f, 0.169622f, 0.394183f}},
                        {{30.04171f, 17.6586f, 2.136554f}, {1.0f, 0.995459f, 0.936186f}},
                        {{0.007663504f, 0.002613296f, 0.001503646f}, {0.053067f, 0.014684f, 0.005937f}},
                        {{0.002847558f, 0.002847471f, 0.002848007f}, {0.016535f, 0.016535f, 0.016539f}},
                        {{0.03667028f, 0.005574876f, 0.01936911f}, {0.177260f, 0.052435f, 0.121567f}}};
  for (const Node& node : nodes) {
    const Rgb mapped = tone_map_agx(node.scene);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(srgb_of(mapped[c]), node.display[c], 1e-5f) << node.scene;
  }
}

TEST(Agx, KeepsMiddleGrayAndEndsAtWhite) {
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(tone_map_agx(Rgb(0.18f))[c], 0.18f, 1e-6f);
    EXPECT_NEAR(tone_map_agx(Rgb(0.18f * std::exp2(6.5f)))[c], 1.0f, 1e-6f);
    EXPECT_EQ(tone_map_agx(Rgb(0.0f))[c], 0.0f);
    EXPECT_EQ(tone_map_agx(Rgb(-1.0f))[c], 0.0f);
    EXPECT_EQ(tone_map_agx(Rgb(std::numeric_limits<float>::quiet_NaN()))[c], 0.0f);
    EXPECT_EQ(tone_map_agx(Rgb(std::numeric_limits<float>::infinity()))[c], 1.0f);
  }
}

TEST(Agx, GrowsWithExposureAndStaysInRange) {
  for (const Rgb& color : {Rgb(1, 0, 0), Rgb(0, 1, 0), Rgb(0, 0, 1), Rgb(1, 0.5f, 0.1f), Rgb(1)}) {
    float before = -1.0f;
    for (float stops = -14.0f; stops <= 12.0f; stops += 0.25f) {
      const Rgb mapped = tone_map_agx(color * std::exp2(stops));
      const float luminance = 0.2126f * mapped.x + 0.7152f * mapped.y + 0.0722f * mapped.z;
      EXPECT_GE(luminance, before - 1e-6f) << color << " at " << stops;
      EXPECT_GE(min_component(mapped), 0.0f);
      EXPECT_LE(max_component(mapped), 1.0f);
      before = luminance;
    }
  }
}

TEST(Agx, ViewAppliesExposureBeforeTheCurve) {
  Result<DisplayTransform> view = DisplayTransform::create({"AgX", 2.0f, ""});
  ASSERT_TRUE(view.ok()) << view.error().message;
  float pixel[4] = {0.1f, 0.2f, 0.05f, 1.0f};
  view.value().apply(pixel);
  const Rgb expected = tone_map_agx(Rgb(0.4f, 0.8f, 0.2f));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], srgb_of(expected[c]), 1e-5f);
}

} // namespace
} // namespace kindling
