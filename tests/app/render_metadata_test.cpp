// Image metadata survives as text, exact to the bit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/render_metadata.h"

#include <gtest/gtest.h>

namespace kindling::app::test {
namespace {

TEST(RenderMetadata, SurvivesJsonExactly) {
  ImageMetadata metadata;
  metadata.text = {{"kindling:scene", "a \"b\".gltf"}};
  metadata.numbers = {{"kindling:renderSeconds", 0.1f}, {"whole", 3.0f}};
  metadata.integers = {{"kindling:seed", 2147483647}};
  for (int i = 0; i < 16; ++i) {
    metadata.world_to_camera[i / 4][i % 4] = 1.0f / static_cast<float>(i + 3);
    metadata.world_to_ndc[i / 4][i % 4] = -1e-20f * static_cast<float>(i);
  }
  const ImageMetadata again = metadata_from_json(metadata_to_json(metadata));
  EXPECT_EQ(again.text, metadata.text);
  EXPECT_EQ(again.numbers, metadata.numbers);
  EXPECT_EQ(again.integers, metadata.integers);
  EXPECT_EQ(again.world_to_camera, metadata.world_to_camera);
  EXPECT_EQ(again.world_to_ndc, metadata.world_to_ndc);
}

TEST(RenderMetadata, LeavesOutUnreadableMembers) {
  EXPECT_TRUE(metadata_from_json("no JSON").text.empty());
  EXPECT_TRUE(metadata_from_json("[1, 2]").text.empty());
  const ImageMetadata some = metadata_from_json(
      R"({"text":{"a":1,"b":"c"},"integers":{"d":"e","f":2.5,"g":3},"world_to_camera":[1,2],"world_to_ndc":7})");
  EXPECT_EQ(some.text, (std::map<std::string, std::string>{{"b", "c"}}));
  EXPECT_EQ(some.integers, (std::map<std::string, int>{{"g", 3}}));
  EXPECT_EQ(some.world_to_camera, M44f());
}

} // namespace
} // namespace kindling::app::test
