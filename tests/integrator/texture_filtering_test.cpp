// Texture filtering in images: no aliasing with few samples, no blur with many, unbiased coverage.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/sample_cone.h"
#include "renderer/texture/texture_memory.h"
#include "tests/integrator/test_scenes.h"

#include "renderer/base/hash.h"

#include <cstring>

namespace kindling::test {
namespace {

constexpr int kTexels = 1024; // a side of the image that covers the plane

enum class Pattern { checkers, noise };

// A black and white image of one channel, or white with a black and white alpha channel.
std::shared_ptr<const Image> black_and_white(Pattern pattern, bool as_alpha = false) {
  const int channels = as_alpha ? 2 : 1;
  auto image = std::make_shared<Image>(Image{kTexels, kTexels, channels, PixelType::u8, {}});
  image->pixels.resize(image->byte_count(), std::byte{255});
  for (int y = 0; y < kTexels; ++y)
    for (int x = 0; x < kTexels; ++x) {
      const bool white = pattern == Pattern::checkers ? ((x + y) & 1) != 0
                                                      : (hash_u32(static_cast<uint32_t>(y * kTexels + x)) & 1U) != 0;
      const auto texel = static_cast<size_t>(y * kTexels + x);
      image->pixels[texel * static_cast<size_t>(channels) + (as_alpha ? 1 : 0)] = white ? std::byte{255} : std::byte{0};
    }
  return image;
}

// An unlit textured square in y = 0 around the origin, with a side of 1 m times `repeats`.
Scene plane(std::shared_ptr<const Image> image, TextureFilter filter, float repeats = 1.0f) {
  Material material;
  material.unlit = true;
  material.double_sided = true;
  material.base_color_texture.texture = 0;
  material.base_color_texture.scale = V2f(repeats);
  const float side = repeats;
  Scene scene = make_scene({material}, {quad(V3f(-0.5f, 0, 0.5f) * side, V3f(side, 0, 0), V3f(0, 0, -side), 0)});
  scene.textures.push_back({.image = std::move(image), .filter = filter});
  return scene;
}

// Sees the plane from above, with `texels` of its texels along a pixel.
Camera from_above(int texels, int size_px) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 0.5f * static_cast<float>(texels * size_px) / kTexels;
  return {camera, kindling::look_at(V3f(0, 3, 0), V3f(0.0f), V3f(0, 0, -1)), V2i(size_px)};
}

std::vector<float> red_of(const World& world, const Camera& camera, RenderSettings settings) {
  settings.size_px = camera.size_px();
  const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  const std::vector<float> beauty = outcome.value().film.resolve(Aov::beauty);
  std::vector<float> red;
  for (size_t i = 0; i < beauty.size(); i += 3) red.push_back(beauty[i]);
  return red;
}

struct Spread {
  double mean, variance;
};
Spread spread_of(std::span<const float> values) {
  double sum = 0, squares = 0;
  for (const float v : values) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double mean = sum / static_cast<double>(values.size());
  return {mean, squares / static_cast<double>(values.size()) - mean * mean};
}

// Each pixel has 32 x 32 texels: their mean has the variance 1/4 / 1024, a single texel 1/4.
TEST(TextureFiltering, OneSampleDoesNotAlias) {
  const auto noise = make_world(plane(black_and_white(Pattern::noise), TextureFilter::linear), accel::Kind::embree);
  const Spread found = spread_of(red_of(*noise, from_above(32, 30), small_render(V2i(30), 1)));
  EXPECT_NEAR(found.mean, 0.5, 0.01);
  EXPECT_LT(found.variance, 2.0 * 0.25 / 1024);
  EXPECT_GT(found.variance, 0.1 * 0.25 / 1024); // no filter wider than a pixel
  const auto checkers =
      make_world(plane(black_and_white(Pattern::checkers), TextureFilter::nearest), accel::Kind::embree);
  for (const float red : red_of(*checkers, from_above(32, 30), small_render(V2i(30), 1))) EXPECT_NEAR(red, 0.5f, 0.01f);
}

// A floor of noise up to the horizon: pixels that cover many texels are nearly gray at one sample.
TEST(TextureFiltering, FloorToTheHorizonAtOneSample) {
  constexpr float kRepeats = 64.0f;
  const auto world =
      make_world(plane(black_and_white(Pattern::noise), TextureFilter::linear, kRepeats), accel::Kind::embree);
  const V2i size(64, 64);
  const Camera camera(SceneCamera{}, look_at(V3f(0.01f, 0.02f, 0.03f), V3f(0.01f, 0.02f, -1)), size);
  const std::vector<float> red = red_of(*world, camera, small_render(size, 1));
  int checked = 0;
  for (int y = size.y / 2 + 1; y < size.y; ++y) {
    const auto at = [&](float row) {
      const CameraRay ray = camera.generate_ray(V2f(32, row), V2f(0.5f), 0.0f);
      return ray.origin.z - ray.direction.z * (ray.origin.y / ray.direction.y);
    };
    const float depth = std::abs(at(static_cast<float>(y)) - at(static_cast<float>(y + 1)));
    const float width = std::abs(at(static_cast<float>(y) + 0.5f) - 0.03f) * 2.0f * std::tan(0.4f) / 64.0f;
    const double texels = static_cast<double>(depth) * width * kTexels * kTexels;
    if (texels < 16.0 || at(static_cast<float>(y)) < -kRepeats * 0.4f) continue;
    ++checked;
    const Spread row = spread_of(std::span(red).subspan(static_cast<size_t>(y * size.x), static_cast<size_t>(size.x)));
    // 64 pixels estimate a variance to 1/6. Limit: four such errors above twice the variance of a
    // mean of all texels.
    EXPECT_LT(row.variance, 2.0 * 0.25 / texels * (1.0 + 4.0 / 6.0)) << "row " << y << ", " << texels << " texels";
  }
  EXPECT_GT(checked, 8);
}

// With one texel per pixel, a box filter and nearest lookup, every pixel is its texel for any
// number of samples, except for single samples that rounding moves over the edge.
TEST(TextureFiltering, TexelForPixelIsExact) {
  const auto image = black_and_white(Pattern::noise);
  const auto world = make_world(plane(image, TextureFilter::nearest), accel::Kind::embree);
  for (const uint32_t spp : {1U, 4U, 256U}) {
    RenderSettings settings = small_render(V2i(32), spp);
    settings.filter = PixelFilter({.kind = FilterKind::box});
    const std::vector<float> red = red_of(*world, from_above(1, 32), settings);
    int different = 0;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) {
        const int texel = (kTexels / 2 + 15 - y) * kTexels + x + kTexels / 2 - 16; // v grows upwards
        const float white = image->pixels[static_cast<size_t>(texel)] != std::byte{0} ? 1.0f : 0.0f;
        different += std::abs(red[static_cast<size_t>(y * 32 + x)] - white) > (spp < 256 ? 0.0f : 1.5f / 256);
      }
    EXPECT_EQ(different, 0) << spp << " samples";
  }
}

// With 4 x 4 texels per pixel and 256 samples, a pixel is the mean of its own texels, within the
// noise of stratified samples. Footprints are half a texel wide, so nothing may leak in from
// neighboring pixels, whose means differ by 0.18.
TEST(TextureFiltering, ManySamplesDoNotBlur) {
  const auto image = black_and_white(Pattern::noise);
  const auto world = make_world(plane(image, TextureFilter::nearest), accel::Kind::embree);
  RenderSettings settings = small_render(V2i(32), 256);
  settings.filter = PixelFilter({.kind = FilterKind::box});
  const std::vector<float> red = red_of(*world, from_above(4, 32), settings);
  double squares = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      double sum = 0;
      for (int v = 0; v < 4; ++v)
        for (int u = 0; u < 4; ++u) {
          const int texel = (4 * (15 - y) + kTexels / 2 + v) * kTexels + 4 * (x - 16) + kTexels / 2 + u;
          sum += image->pixels[static_cast<size_t>(texel)] != std::byte{0} ? 1.0 / 16 : 0.0;
        }
      squares += square(static_cast<float>(red[static_cast<size_t>(y * 32 + x)] - sum));
    }
  // A (0, 8, 2)-net has 16 points in each of the 16 squares: the mean is exact except for rounding.
  EXPECT_LT(std::sqrt(squares / 1024), 1e-3);
}

// Rays are tested against alpha at the finest level; the surfaces hit must not be attenuated by
// alpha once more.
TEST(TextureFiltering, CoverageIsCountedOnce) {
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    Scene scene = plane(black_and_white(Pattern::noise, true), TextureFilter::linear);
    scene.materials[0].alpha_mode = mode;
    const auto world = make_world(std::move(scene), accel::Kind::embree);
    RenderSettings settings = small_render(V2i(32), 4);
    const Spread found = spread_of(red_of(*world, from_above(32, 32), settings));
    // 4096 samples with a variance of at most 1/4: four standard errors.
    EXPECT_NEAR(found.mean, 0.5, 4.0 * 0.5 / 64) << static_cast<int>(mode);
  }
}

// A normal map of slopes to both sides, seen from so far away that they merge: the normal is that
// of the plane, and the roughness represents the slopes.
TEST(TextureFiltering, MergedNormalsBecomeRoughness) {
  constexpr float kSlope = 0.25f;
  auto image = std::make_shared<Image>(Image{64, 64, 3, PixelType::u16, {}});
  image->pixels.resize(image->byte_count());
  const float length = std::sqrt(1.0f + kSlope * kSlope);
  for (int i = 0; i < 64 * 64; ++i) {
    const float x = ((i + i / 64) & 1) != 0 ? kSlope : -kSlope;
    for (size_t c = 0; c < 3; ++c) {
      const float v = 0.5f + 0.5f * (c == 0 ? x : c == 1 ? 0.0f : 1.0f) / length;
      const auto word = static_cast<uint16_t>(v * 65535.0f + 0.5f);
      std::memcpy(&image->pixels[(static_cast<size_t>(i) * 3 + c) * 2], &word, 2);
    }
  }
  Material material;
  material.metallic_factor = 1.0f;
  material.roughness_factor = 0.2f;
  material.normal_texture.texture = 0;
  Primitive floor = quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0);
  floor.normals.assign(4, V3f(0, 1, 0));
  floor.tangents.assign(4, V4f(1, 0, 0, 1));
  Scene scene = make_scene({material}, {floor});
  scene.textures.push_back({.image = image, .filter = TextureFilter::nearest});
  const auto world = make_world(std::move(scene), accel::Kind::embree);
  const accel::Ray ray{.origin = V3f(0.3f, 5, 0.2f), .direction = V3f(0, -1, 0), .t_max = kInfinity};
  const accel::Hit hit = world->accelerator().intersect(ray);
  ASSERT_TRUE(hit.is_hit());
  SurfacePoint near, far;
  world->surface_at(ray, hit, near);
  EXPECT_NEAR(std::abs(near.shading_normal.x), kSlope / length, 1e-3f);
  EXPECT_EQ(near.bsdf.roughness, 0.2f);
  world->surface_at(ray, hit, far, {.width_m = 0.5f});
  EXPECT_NEAR(far.shading_normal.x, 0.0f, 1e-3f);
  // One axis has the variance of the slopes, the other none: an isotropic lobe has the mean of
  // both, up to terms of fourth order and rounding.
  const float alpha2 = square(square(0.2f)) + kSlope * kSlope;
  EXPECT_NEAR(square(square(far.bsdf.roughness)), alpha2, 0.15f * alpha2);
}

// A textured scene has the same bits for any threads, tiles and batches.
TEST(TextureFiltering, SameBitsForAnyThreadsTilesAndBatches) {
  Scene scene = sphere_lamp_and_veil(0.3f);
  scene.textures.push_back({.image = black_and_white(Pattern::noise)});
  for (const size_t material : {1u, 3u}) {
    scene.materials[material].base_color_texture.texture = 0;
    scene.materials[material].base_color_texture.scale = V2f(3.0f);
  }
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  const V2i size(45, 37);
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), size);
  RenderSettings settings = small_render(size, 5);
  settings.threads = 1;
  const std::vector<float> reference = red_of(*world, camera, settings);
  settings.threads = 3;
  settings.tile_size_px = 8;
  settings.integrator.batch_size = 64;
  const std::vector<float> other = red_of(*world, camera, settings);
  EXPECT_EQ(std::memcmp(reference.data(), other.data(), reference.size() * sizeof(float)), 0);
}

// Textures of colors, alpha and emission that are paged from disk through a small cache give the
// same bits.
TEST(TextureFiltering, SameBitsFromDisk) {
  const auto render_with = [](uint64_t max_bytes) {
    TextureMemory memory(max_bytes);
    Scene scene = sphere_lamp_and_veil(0.3f);
    for (const bool as_alpha : {false, true}) {
      SceneTexture texture;
      texture.image = memory.keep(Image(*black_and_white(Pattern::noise, as_alpha))).value();
      scene.textures.push_back(texture);
    }
    scene.materials[1].base_color_texture.texture = 0;
    scene.materials[2].emissive_texture.texture = 0;
    scene.materials[3].base_color_texture.texture = 1;
    PosedScene posed = pose_scene(scene, {}).value();
    WorldOptions options;
    options.texture_memory = &memory;
    const auto world = build_world(std::move(scene), std::move(posed), options, nullptr, nullptr);
    EXPECT_TRUE(world.ok());
    EXPECT_EQ(world.value()->statistics().texture_bytes == 0, memory.exceeded());
    const V2i size(40, 30);
    const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), size);
    const std::vector<float> red = red_of(*world.value(), camera, small_render(size, 4));
    EXPECT_EQ(memory.failure(), "");
    return red;
  };
  const std::vector<float> in_memory = render_with(64 << 20), from_disk = render_with(512 << 10);
  EXPECT_EQ(std::memcmp(in_memory.data(), from_disk.data(), in_memory.size() * sizeof(float)), 0);
}

TEST(RayCone, PixelsTileTheFilm) {
  const V2i size(40, 30);
  const Camera camera(SceneCamera{}, look_at(V3f(1, 2, 3), V3f(0.0f)), size);
  // The pixels' solid angles add up to that of the film, a pyramid: 4 asin(sin(half_x)
  // sin(half_y)).
  double sum = 0;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const V2f at(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      const RayCone cone = camera.pixel_cone(camera.generate_ray(at, V2f(0.5f), 0.0f).direction);
      EXPECT_EQ(cone.width_m, 0.0f);
      sum += square(cone.spread);
    }
  const double half_y = 0.4, half_x = std::atan(std::tan(0.4) * 40.0 / 30.0);
  EXPECT_NEAR(sum, 4 * std::asin(std::sin(half_x) * std::sin(half_y)), 1e-3);
}

TEST(RayCone, SamplesShareThePixelDownToAnEighth) {
  const auto width_of = [](uint32_t spp) { return sample_width(Sampler(0, SamplerKind::sobol, spp)); };
  EXPECT_EQ(width_of(1), 1.0f);
  EXPECT_EQ(width_of(4), 0.5f);
  EXPECT_EQ(width_of(16), 0.25f);
  EXPECT_EQ(width_of(64), 0.125f);
  EXPECT_EQ(width_of(1U << 30), 0.125f);
}

TEST(RayCone, ScatteringWidens) {
  const RayCone arriving{.width_m = 0.1f, .spread = 0.01f};
  EXPECT_EQ(scattered_cone(arriving, 0.0f).spread, 0.01f); // a mirror
  const RayCone diffuse = scattered_cone(arriving, kInvPi);
  EXPECT_EQ(diffuse.width_m, 0.1f);
  EXPECT_NEAR(diffuse.spread, 0.25f, 1e-3f); // an eighth of the width of pi steradians
  EXPECT_LT(scattered_cone(arriving, 1e4f).spread, 0.011f);
}

} // namespace
} // namespace kindling::test
