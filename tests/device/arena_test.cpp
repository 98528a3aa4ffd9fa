// An arena copies every array of a view to one block, and the scene needs nothing outside of it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/arena.h"

#include "renderer/device/host_device.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

namespace kindling::test {
namespace {

class Arenas : public testing::Test {
 protected:
  std::unique_ptr<Device> device = make_host_device(1);
};

bool lies_in(const void* address, const DeviceArray<std::byte>& block) {
  const auto at = reinterpret_cast<uintptr_t>(address), begin = reinterpret_cast<uintptr_t>(block.data());
  return at >= begin && at < begin + block.size();
}

TEST_F(Arenas, CopyArraysOnce) {
  std::vector<uint32_t> numbers(1000);
  std::iota(numbers.begin(), numbers.end(), 0U);
  const auto place = [&](Arena& arena, std::array<std::span<const uint32_t>, 4>& spans) {
    spans = {numbers, numbers, std::span(numbers).first(10), {}};
    for (auto& span : spans) arena.place(span);
  };
  std::array<std::span<const uint32_t>, 4> spans;
  Arena counter;
  place(counter, spans);
  EXPECT_GE(counter.bytes(), 1010 * sizeof(uint32_t));
  EXPECT_LT(counter.bytes(), 1010 * sizeof(uint32_t) + 2 * Arena::kAlignment);

  const DeviceArray<std::byte> block(*device, counter.bytes());
  Arena arena(*device, block.data());
  place(arena, spans);
  EXPECT_EQ(arena.bytes(), counter.bytes());
  EXPECT_EQ(spans[0].data(), spans[1].data());
  EXPECT_NE(spans[0].data(), numbers.data());
  EXPECT_TRUE(std::equal(spans[0].begin(), spans[0].end(), numbers.begin(), numbers.end()));
  EXPECT_EQ(spans[2].size(), 10U);
  EXPECT_TRUE(spans[3].empty());
  for (const auto& span : {spans[0], spans[2]}) {
    EXPECT_TRUE(lies_in(span.data(), block) && lies_in(&span.back(), block));
    EXPECT_EQ(reinterpret_cast<uintptr_t>(span.data()) % Arena::kAlignment, 0U);
  }
}

// Views within arrays, and spans of spans.
TEST_F(Arenas, FollowViewsInsideOfArrays) {
  const std::vector<V3f> first{V3f(1), V3f(2), V3f(3)}, second{V3f(4), V3f(5)};
  const std::vector<std::span<const V3f>> keys{first, second};
  std::vector<GeometryView> geometries(3);
  geometries[1].positions = first;
  geometries[2].later_positions = keys;
  WorldView world;
  const auto place = [&](Arena& arena) {
    world = {};
    world.geometries = geometries;
    arena.place_arrays(world);
  };
  Arena counter;
  place(counter);
  const DeviceArray<std::byte> block(*device, counter.bytes());
  Arena arena(*device, block.data());
  place(arena);
  ASSERT_EQ(world.geometries.size(), 3U);
  EXPECT_TRUE(lies_in(&world.geometries[2], block));
  EXPECT_TRUE(world.geometries[0].positions.empty());
  EXPECT_TRUE(lies_in(world.geometries[1].positions.data(), block));
  EXPECT_EQ(world.geometries[1].positions[2], V3f(3));
  const auto& later = world.geometries[2].later_positions;
  ASSERT_EQ(later.size(), 2U);
  EXPECT_TRUE(lies_in(&later[1], block) && lies_in(&later[1][1], block));
  EXPECT_EQ(later[0].data(), world.geometries[1].positions.data()); // the same array
  EXPECT_EQ(later[1][1], V3f(5));
  EXPECT_EQ(geometries[1].positions.data(), first.data()); // the original is as it was
}

TEST_F(Arenas, CopyTheTexelsOfEachLevel) {
  const std::vector<std::byte> texels(3 * (4 * 2 + 2 * 1), std::byte{7});
  std::vector<TextureView> textures(1);
  textures[0].pixel_bytes = 3;
  textures[0].level_count = 2;
  textures[0].levels[0] = {texels.data(), 4, 2};
  textures[0].levels[1] = {texels.data() + 24, 2, 1};
  std::span<const TextureView> placed = textures;
  Arena counter;
  counter.place(placed);
  const DeviceArray<std::byte> block(*device, counter.bytes());
  placed = textures;
  Arena arena(*device, block.data());
  arena.place(placed);
  for (const size_t level : {size_t{0}, size_t{1}}) {
    EXPECT_TRUE(lies_in(placed[0].levels[level].pixels, block));
    EXPECT_EQ(placed[0].levels[level].pixels[5], std::byte{7});
  }
  EXPECT_EQ(placed[0].levels[2].pixels, nullptr);
}

} // namespace
} // namespace kindling::test
