// Differences of pictures have the names of what differs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/one_picture.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

AccumulationIdentity identity() {
  AccumulationIdentity identity;
  identity.program = "Kindling 1";
  identity.picture = R"({"filter":{"kind":"box","width":1},"seed":3})";
  identity.scene_hash = 0x1234;
  identity.size_px = V2i(64, 48);
  identity.crop = {V2i(0, 0), V2i(64, 48)};
  identity.samples_per_pixel = 64;
  identity.planned_samples = 64;
  return identity;
}

using Lines = std::vector<std::string>;

TEST(OnePicture, SameWhateverThePartAndTheCountOfSamples) {
  AccumulationIdentity other = identity();
  other.part = {3, 9};
  other.arguments = {"render", "elsewhere.gltf"};
  other.metadata = "{}";
  other.samples_per_pixel = 128; // further samples, laid out as the first 64
  EXPECT_EQ(picture_differences(identity(), other), Lines{});
}

TEST(OnePicture, EachDifferenceHasItsName) {
  const auto difference = [](auto change) {
    AccumulationIdentity other = identity();
    change(other);
    return picture_differences(identity(), other);
  };
  EXPECT_EQ(difference([](auto& o) { o.program = "Kindling 2"; }), Lines{"program: Kindling 1 and Kindling 2"});
  EXPECT_EQ(difference([](auto& o) { o.scene_hash = 0x1235; }),
            Lines{"scene hash: 0000000000001234 and 0000000000001235"});
  EXPECT_EQ(difference([](auto& o) { o.size_px.x = 65; }), Lines{"size: 64x48 and 65x48"});
  EXPECT_EQ(difference([](auto& o) { o.crop.min.y = 8; }), Lines{"crop: 0,0,64,48 and 0,8,64,48"});
  EXPECT_EQ(difference([](auto& o) { o.planned_samples = 32; }),
            Lines{"samples per pixel that the sampling is laid out for: 64 and 32"});
  EXPECT_EQ(difference([](auto& o) { o.picture = R"({"filter":{"kind":"box","width":1},"seed":4})"; }),
            Lines{"seed: 3 and 4"});
  EXPECT_EQ(difference([](auto& o) { o.picture = R"({"filter":{"kind":"mitchell"},"seed":3})"; }),
            (Lines{R"(filter/kind: "box" and "mitchell")", "filter/width: 1 and nothing"}));
  EXPECT_FALSE(difference([](auto& o) { o.picture = "not JSON"; }).empty());
  EXPECT_FALSE(difference([](auto& o) { o.picture = R"({"seed":3,"filter":{"kind":"box","width":1}})"; }).empty());
  EXPECT_EQ(difference([](auto& o) {
              o.picture = "{}";
              o.program.clear();
            }).size(),
            4U);
}

} // namespace
} // namespace kindling::test
