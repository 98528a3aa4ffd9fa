// Differences between renders are named, and only differences that matter count.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/render_identity.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

AccumulationIdentity identity() {
  AccumulationIdentity identity;
  identity.program = "Kindling 1";
  identity.image = R"({"--filter":"box","--lens":null,"--seed":3,"--size":[64,48]})";
  identity.scene_hash = 0x1234;
  identity.size_px = V2i(64, 48);
  identity.crop = {V2i(0, 0), V2i(64, 48)};
  identity.samples_per_pixel = 64;
  identity.planned_samples = 64;
  return identity;
}

using Differences = std::vector<ImageDifference>;

TEST(RenderIdentity, IgnoresPartAndNumberOfSamples) {
  AccumulationIdentity other = identity();
  other.part = {3, 9};
  other.arguments = {"render", "elsewhere.gltf"};
  other.metadata = "{}";
  other.samples_per_pixel = 128; // further samples with the same planned number
  EXPECT_EQ(image_differences(identity(), other), Differences{});
}

TEST(RenderIdentity, NamesEachDifference) {
  const auto difference = [](auto change) {
    AccumulationIdentity other = identity();
    change(other);
    return image_differences(identity(), other);
  };
  const auto other_image = [&](const char* image) { return difference([&](auto& o) { o.image = image; }); };
  EXPECT_EQ(difference([](auto& o) { o.program = "Kindling 2"; }),
            (Differences{{"program", "Kindling 1", "Kindling 2"}}));
  EXPECT_EQ(difference([](auto& o) { o.scene_hash = 0x1235; }),
            (Differences{{"scene hash", "0000000000001234", "0000000000001235"}}));
  EXPECT_EQ(difference([](auto& o) { o.size_px.x = 65; }), (Differences{{"size", "64x48", "65x48"}}));
  EXPECT_EQ(difference([](auto& o) { o.crop.min.y = 8; }), (Differences{{"crop", "0,0,64,48", "0,8,64,48"}}));
  EXPECT_EQ(difference([](auto& o) { o.planned_samples = 32; }),
            (Differences{{"planned samples per pixel", "64", "32"}}));
  EXPECT_EQ(other_image(R"({"--filter":"box","--lens":null,"--seed":4,"--size":[64,48]})"),
            (Differences{{"--seed", "3", "4"}}));
  EXPECT_EQ(
      other_image(R"({"--filter":"mitchell","--lens":2.8,"--seed":3})"),
      (Differences{{"--filter", "box", "mitchell"}, {"--lens", "none", "2.8"}, {"--size", "[64,48]", "nothing"}}));
  EXPECT_EQ(other_image("not JSON"), (Differences{{"settings", identity().image, "not JSON"}}));
  // Equal settings with another spelling: written by another program than the file claims.
  EXPECT_EQ(other_image(R"({"--seed":3,"--filter":"box","--lens":null,"--size":[64,48]})").size(), 1U);
  // Members that are among the settings are not named twice; the program is.
  EXPECT_EQ(difference([](auto& o) {
              o.image = R"({"--filter":"box","--lens":null,"--seed":3,"--size":[65,48]})";
              o.size_px.x = 65;
              o.program.clear();
            }),
            (Differences{{"program", "Kindling 1", ""}, {"--size", "[64,48]", "[65,48]"}}));
}

} // namespace
} // namespace kindling::test
