// Tests of opacity micromaps: they answer as the texture does, know most of it, and stay small.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/opacity/alpha_classes.h"
#include "renderer/world/opacity/build_opacity.h"
#include "renderer/world/world_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace kindling {
namespace {

constexpr std::array kWraps{TextureWrap::repeat, TextureWrap::mirrored_repeat, TextureWrap::clamp_to_edge};

// Leaves: discs of alpha 1 with soft edges on alpha 0, some of them 0.3. Of `type` u8 or f32.
std::shared_ptr<const Image> make_leaves(int width, int height, PixelType type, int channels = 4) {
  auto image = std::make_shared<Image>(Image{width, height, channels, type, {}});
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit;
  std::vector<std::array<float, 4>> discs(9);
  for (auto& disc : discs)
    disc = {unit(random), unit(random), 0.08f + 0.1f * unit(random), unit(random) < 0.3f ? 0.3f : 1.0f};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
      const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
      float alpha = 0.0f;
      for (const auto& [cx, cy, r, a] : discs)
        alpha = std::max(alpha, a * std::clamp((r - std::hypot(u - cx, v - cy)) * 40.0f, 0.0f, 1.0f));
      for (int c = 0; c < channels; ++c) {
        const float value = c == channels - 1 ? alpha : u;
        const auto byte = static_cast<uint8_t>(std::lround(value * 255.0f));
        const auto* from = type == PixelType::u8 ? reinterpret_cast<const std::byte*>(&byte)
                                                 : reinterpret_cast<const std::byte*>(&value);
        image->pixels.insert(image->pixels.end(), from, from + bytes_per_channel(type));
      }
    }
  return image;
}

// One mesh of triangles with texture coordinates, one material with one texture.
struct Leaves {
  std::vector<float> coordinates; // u and v of three corners for each triangle
  std::vector<V3f> positions;
  std::vector<uint32_t> indices;
  GeometryView geometry;
  ShadingMaterial material;
  std::vector<TextureView> textures;
  std::vector<uint8_t> covers;
  OpacityMicromaps maps;
  WorldView reading, mapped; // without and with micromaps

  void build(const TextureView& texture) {
    textures = {texture};
    geometry.stride = geometry.color_offset == GeometryView::kAbsent ? 2 : 6;
    const auto vertices = static_cast<uint32_t>(coordinates.size() / geometry.stride);
    positions.assign(vertices, V3f(0.0f));
    for (uint32_t i = 0; i < vertices; ++i) indices.push_back(i);
    geometry.positions = positions;
    geometry.indices = indices;
    geometry.attributes = coordinates;
    geometry.texcoord_offset[0] = 0;
    material.base_color.texture = 0;
    reading.geometries = {&geometry, 1};
    reading.materials = {&material, 1};
    reading.textures = textures;
    const OpacityInput input{reading.geometries, reading.materials, reading.textures, {}};
    covers = find_covering_meshes(input);
    maps = make_opacity_micromaps(input, covers);
    mapped = reading;
    mapped.opacity = {maps.first, maps.entries, maps.words};
  }

  // Adds triangles somewhere on the texture, about `size` of its width large.
  void add_random(int count, float size, std::mt19937& random) {
    std::uniform_real_distribution<float> around(-1.0f, 1.0f);
    for (int i = 0; i < count; ++i) {
      const float u = 3.0f * around(random), v = 3.0f * around(random);
      for (int k = 0; k < 3; ++k) {
        coordinates.push_back(u + size * around(random));
        coordinates.push_back(v + size * around(random));
      }
    }
  }
};

// Hits all over a triangle, on its edges, and at borders of micro-triangles.
accel::Hit random_hit(std::mt19937& random, uint32_t triangles) {
  std::uniform_real_distribution<float> unit;
  float u = unit(random), v = unit(random);
  if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
  switch (random() % 8) {
  case 0: u = 0.0f; break;
  case 1: v = 0.0f; break;
  case 2: u = 1.0f - v; break;
  case 3: u = std::floor(u * 128.0f) / 128.0f; break;
  case 4: v = std::nextafter(std::floor(v * 128.0f) / 128.0f, 2.0f * unit(random)); break;
  default: break;
  }
  return {.t = 1.0f, .u = u, .v = v, .instance = 0, .mesh = 0, .triangle = static_cast<uint32_t>(random()) % triangles};
}

// Compares decisions at random hits. Returns the share of hits that the maps know.
double compare(const Leaves& leaves, int hits, const std::string& what) {
  std::mt19937 random(11);
  int known = 0, different = 0;
  for (int i = 0; i < hits; ++i) {
    const accel::Hit hit = random_hit(random, static_cast<uint32_t>(leaves.indices.size() / 3));
    accel::Ray ray{.origin = V3f(0.0f),
                   .direction = V3f(0, 0, 1),
                   .t_max = kInfinity,
                   .key = static_cast<uint32_t>(random()),
                   .index = static_cast<uint32_t>(random())};
    ray.flags = i % 2 == 0 ? uint8_t{0} : uint8_t{kHitPartlyTransparent};
    known += leaves.mapped.opacity.at(hit) != Opacity::mixed ? 1 : 0;
    const bool same = leaves.reading.accepts_by_coverage(ray, hit) == leaves.mapped.accepts_by_coverage(ray, hit);
    if (!same && different++ == 0)
      ADD_FAILURE() << what << ": triangle " << hit.triangle << " at " << hit.u << ", " << hit.v;
  }
  EXPECT_EQ(different, 0) << what;
  return static_cast<double>(known) / hits;
}

TEST(OpacityMicromaps, AnswerAsTheTextureDoes) {
  std::mt19937 random(3);
  for (const PixelType type : {PixelType::u8, PixelType::f32})
    for (const int channels : {2, 4})
      for (const TextureWrap u : kWraps)
        for (const TextureWrap v : kWraps)
          for (const TextureFilter filter : {TextureFilter::linear, TextureFilter::nearest})
            for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
              const Texture texture(make_leaves(49, 32, type, channels), {u, v, filter, TextureEncoding::srgb});
              for (const float size : {0.1f, 1.0f, 20.0f}) {
                Leaves leaves;
                leaves.add_random(10, size, random);
                leaves.material.alpha_mode = mode;
                leaves.material.base_color_factor.w = random() % 2 == 0 ? 1.0f : 0.9f;
                leaves.build(texture);
                compare(leaves, 3000, "size " + std::to_string(size));
              }
            }
}

TEST(OpacityMicromaps, FollowTextureTransforms) {
  std::mt19937 random(4);
  const Texture texture(make_leaves(256, 128, PixelType::u8), {});
  for (int i = 0; i < 50; ++i) {
    Leaves leaves;
    leaves.add_random(10, 0.5f, random);
    std::uniform_real_distribution<float> around(-2.0f, 2.0f);
    leaves.material.base_color.transformed = true;
    for (float& m : leaves.material.base_color.m) m = around(random);
    leaves.material.alpha_mode = AlphaMode::mask;
    leaves.build(texture);
    compare(leaves, 4000, "transform " + std::to_string(i));
  }
}

// Squares just above the cutoff beside empty ones, and triangles whose micro-triangles end exactly
// where look-ups begin to blend them: a look-up that rounds outwards decides differently.
TEST(OpacityMicromaps, ReckonWithRounding) {
  auto image = std::make_shared<Image>(Image{64, 64, 4, PixelType::f32, {}});
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const std::array<float, 4> texel{1.0f, 1.0f, 1.0f, (x / 32 + y / 32) % 2 == 0 ? 0.500002f : 0.0f};
      const auto bytes = std::as_bytes(std::span(texel));
      image->pixels.insert(image->pixels.end(), bytes.begin(), bytes.end());
    }
  const Texture texture(image, {});
  std::mt19937 random(9);
  Leaves leaves;
  for (int i = 0; i < 200; ++i) {
    const float u = 50.0f + (static_cast<float>(random() % 64) + 0.5f) / 64.0f;
    const float v = 50.0f + (static_cast<float>(random() % 64) + 0.5f) / 64.0f;
    leaves.coordinates.insert(leaves.coordinates.end(), {u, v, u + 0.5f, v, u, v + 0.5f});
  }
  leaves.material.alpha_mode = AlphaMode::mask;
  leaves.build(texture);
  // The texels under a micro-triangle, 10 along each axis, lie in one square with a probability of
  // (23 / 32)^2 = 0.52.
  EXPECT_GT(compare(leaves, 200'000, "rounding"), 0.4);
}

// Cards show the whole texture; nine discs have short outlines.
TEST(OpacityMicromaps, KnowMostOfACard) {
  const Texture texture(make_leaves(512, 512, PixelType::u8), {});
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    Leaves leaves;
    leaves.coordinates = {0, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 0};
    leaves.material.alpha_mode = mode;
    leaves.build(texture);
    // The outlines of the discs are at most 10 widths of the card long, and cross 4 / pi of its 64
    // rows and columns of squares on each width: a fifth of all squares. Soft edges, which BLEND
    // shows, are 13 texels wide, where a square has 8.
    EXPECT_GT(compare(leaves, 200'000, "card"), mode == AlphaMode::mask ? 0.8 : 0.6);
  }
}

TEST(OpacityMicromaps, TrianglesWithOneOpacityHaveNoWords) {
  const Texture texture(make_leaves(64, 64, PixelType::u8), {});
  const AlphaClasses classes(texture, {});
  // A texel amid a disc, and one amid nothing.
  std::array<V2i, 3> found{};
  for (int y = 4; y < 60; ++y)
    for (int x = 4; x < 60; ++x) {
      Opacity common = classes.of_row(y - 4, x - 4, x + 4);
      for (int row = y - 3; row <= y + 4; ++row)
        if (classes.of_row(row, x - 4, x + 4) != common) common = Opacity::mixed;
      found[static_cast<size_t>(common)] = {x, y};
    }
  for (const Opacity wanted : {Opacity::transparent, Opacity::opaque}) {
    const V2i at = found[static_cast<size_t>(wanted)];
    ASSERT_NE(at, V2i(0));
    const float u = (static_cast<float>(at.x) + 0.5f) / 64.0f, v = (static_cast<float>(at.y) + 0.5f) / 64.0f,
                d = 2.0f / 64.0f;
    Leaves leaves;
    leaves.coordinates = {u - d, v - d, u + d, v - d, u - d, v + d};
    leaves.material.alpha_mode = AlphaMode::mask;
    leaves.build(texture);
    EXPECT_EQ(leaves.maps.entries, std::vector{OpacityMicromapsView::entry_of(0, static_cast<uint32_t>(wanted))});
  }
}

TEST(OpacityMicromaps, EqualCoordinatesShareAMap) {
  const Texture texture(make_leaves(256, 256, PixelType::u8), {});
  Leaves one, many;
  one.coordinates = {0, 1, 1, 1, 1, 0};
  for (int i = 0; i < 1000; ++i)
    many.coordinates.insert(many.coordinates.end(), one.coordinates.begin(), one.coordinates.end());
  for (Leaves* leaves : {&one, &many}) {
    leaves->material.alpha_mode = AlphaMode::mask;
    leaves->build(texture);
  }
  EXPECT_EQ(many.maps.words, one.maps.words);
  EXPECT_TRUE(std::ranges::all_of(many.maps.entries, [&](uint32_t entry) { return entry == one.maps.entries[0]; }));
}

// Many large triangles, all different: levels fall until they fit.
TEST(OpacityMicromaps, KeepTheirBudget) {
  std::mt19937 random(6);
  const Texture texture(make_leaves(1024, 1024, PixelType::u8), {});
  for (const int count : {10, 1000, 20'000}) {
    Leaves leaves;
    leaves.add_random(count, 0.5f, random);
    leaves.material.alpha_mode = AlphaMode::mask;
    leaves.build(texture);
    const size_t bytes = leaves.mapped.opacity.bytes();
    EXPECT_LE(bytes, OpacityMicromaps::max_bytes({.triangles = static_cast<uint64_t>(count), .materials = 1}));
    EXPECT_GT(compare(leaves, 20'000, std::to_string(count)), 0.3);
  }
}

TEST(OpacityMicromaps, UnusualCoordinatesAndTexelsAreRead) {
  auto image = std::make_shared<Image>(*make_leaves(64, 64, PixelType::f32));
  for (const auto& [texel, alpha] : {std::pair{70, NAN}, {80, 1e30f}, {90, -1.0f}, {1000, INFINITY}, {2000, 2.0f}})
    std::memcpy(&image->pixels[static_cast<size_t>(texel) * 16 + 12], &alpha, sizeof alpha);
  const Texture texture(image, {});
  std::mt19937 random(7);
  Leaves leaves;
  leaves.add_random(30, 0.5f, random);
  leaves.add_random(10, 1e4f, random);
  leaves.add_random(10, 1e9f, random);
  leaves.add_random(2, 0.0f, random);
  for (const float odd : {NAN, INFINITY, 1e38f}) {
    leaves.coordinates.insert(leaves.coordinates.end(), {0.0f, odd, 1.0f, 0.5f, odd, 0.0f});
  }
  leaves.material.alpha_mode = AlphaMode::mask;
  leaves.build(texture);
  compare(leaves, 100'000, "unusual");
}

TEST(OpacityMicromaps, MeshesThatOtherThingsDecideHaveNone) {
  const Texture texture(make_leaves(64, 64, PixelType::u8), {});
  const auto maps_of = [&](const auto& change) {
    Leaves leaves;
    leaves.coordinates = {0, 1, 1, 1, 1, 0};
    leaves.material.alpha_mode = AlphaMode::mask;
    change(leaves);
    leaves.build(texture);
    return leaves.maps.first.size();
  };
  EXPECT_EQ(maps_of([](Leaves&) {}), 1U);
  EXPECT_EQ(maps_of([](Leaves& l) { l.material.alpha_mode = AlphaMode::opaque; }), 0U);
  EXPECT_EQ(maps_of([](Leaves& l) { l.material.thin_wall = true; }), 0U);
  EXPECT_EQ(maps_of([](Leaves& l) { l.material.base_color.texcoord = 1; }), 0U);
  // A vertex color after the two texture coordinates of each record.
  const auto with_alpha = [](float alpha) {
    return [alpha](Leaves& l) {
      l.geometry.color_offset = 2;
      for (size_t corner = 3; corner-- > 0;)
        l.coordinates.insert(l.coordinates.begin() + static_cast<ptrdiff_t>(2 * corner + 2), {1.0f, 1.0f, 1.0f, alpha});
    };
  };
  EXPECT_EQ(maps_of(with_alpha(1.0f)), 1U);
  EXPECT_EQ(maps_of(with_alpha(0.5f)), 0U);
  EXPECT_EQ(maps_of(with_alpha(1.5f)), 0U);
}

// Texels of a row, by reading them one by one.
TEST(AlphaClasses, ReadAllTexelsOfARow) {
  for (const TextureWrap wrap : kWraps) {
    const Texture texture(make_leaves(150, 70, PixelType::u8),
                          {.wrap_u = wrap, .wrap_v = wrap, .filter = TextureFilter::nearest});
    const AlphaClasses classes(texture, {});
    std::mt19937 random(8);
    std::array<int, 3> seen{};
    for (int i = 0; i < 20'000; ++i) {
      const int64_t y = static_cast<int64_t>(random() % 300) - 150, x0 = static_cast<int64_t>(random() % 600) - 300;
      const int64_t x1 = x0 + static_cast<int64_t>(random() % (i % 3 == 0 ? 290 : 12));
      bool transparent = true, opaque = true;
      for (int64_t x = x0; x <= x1; ++x) {
        const float alpha = texture.sample_channel(
            {(static_cast<float>(x) + 0.5f) / 150.0f, (static_cast<float>(y) + 0.5f) / 70.0f}, 3);
        (alpha < 0.5f ? opaque : transparent) = false;
      }
      const Opacity wanted = transparent ? Opacity::transparent : opaque ? Opacity::opaque : Opacity::mixed;
      ASSERT_EQ(classes.of_row(y, x0, x1), wanted) << y << ": " << x0 << " to " << x1;
      ++seen[static_cast<size_t>(wanted)];
    }
    for (const int count : seen) EXPECT_GT(count, 500);
  }
}

} // namespace
} // namespace kindling
