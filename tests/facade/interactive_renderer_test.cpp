// A Renderer in a viewer: images of passes, decisions that hold, picked surfaces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace kindling {
namespace {

Renderer load(const WorldSettings& world = {}) {
  Result<Renderer> loaded = Renderer::load(std::string(KINDLING_SCENES) + "/cornell_box.glb", world);
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.error().message);
  return std::move(loaded).value();
}

ImageSettings small_image() {
  ImageSettings image;
  image.size_px = V2i(48, 32);
  image.spp = 4;
  return image;
}

RenderedImage render(Renderer& renderer, const ImageSettings& image, const RunOptions& run = {}) {
  Result<RenderedImage> rendered = renderer.render(image, run);
  EXPECT_TRUE(rendered.ok()) << (rendered.ok() ? "" : rendered.error().message);
  return std::move(rendered).value();
}

std::vector<uint32_t> bits_of(const std::vector<float>& values) {
  std::vector<uint32_t> bits(values.size());
  std::memcpy(bits.data(), values.data(), values.size() * sizeof(float));
  return bits;
}

// The film after a pass is that of a render of so many samples.
TEST(InteractiveRenderer, FilmAfterAPassIsAnImage) {
  Renderer renderer = load();
  ImageSettings image = small_image();
  image.spp = image.planned_spp = 32;
  std::vector<std::pair<uint32_t, std::vector<float>>> passes;
  (void)render(renderer, image, {.threads = 2, .on_pass = [&](const Film& film) {
                                   passes.emplace_back(film.total_samples() / (48 * 32), film.resolve_rgba());
                                 }});
  ASSERT_GE(passes.size(), 3U);
  for (const auto& [spp, rgba] : passes) {
    image.spp = spp;
    EXPECT_EQ(bits_of(render(renderer, image).film.resolve_rgba()), bits_of(rgba)) << spp;
  }
}

TEST(InteractiveRenderer, DecisionsThatHoldAreSettings) {
  Renderer renderer = load();
  ImageSettings image = small_image();
  (void)render(renderer, image);
  const DecidedSettings decided = renderer.decided();
  EXPECT_NE(decided.backfaces, Backfaces::automatic);
  image.orbit = V3f(160.0f, 40.0f, 3.0f);
  const RenderedImage held = render(renderer, image, {.keep_decisions = true});
  EXPECT_EQ(renderer.decided().backfaces, decided.backfaces);
  image.backfaces = decided.backfaces;
  WorldSettings world;
  world.studio = decided.studio;
  Renderer other = load(world);
  EXPECT_EQ(bits_of(render(other, image).linear_rgb()), bits_of(held.linear_rgb()));
}

// A replay takes the guide of the image, and trains none.
TEST(InteractiveRenderer, ReplaysTakeTheGuideOfTheImage) {
  Renderer renderer = load();
  ImageSettings image = small_image();
  image.guiding = Guiding::on;
  image.training_paths = 1U << 17;
  const double training_s = render(renderer, image).statistics.guiding.training_s;
  double fastest_s = training_s;
  for (uint32_t sample = 0; sample < 4; ++sample) {
    const auto start = std::chrono::steady_clock::now();
    const Result<ReplayedPath> path = renderer.replay(V2f(0.5f, 0.8f), sample);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    ASSERT_TRUE(path.ok());
    EXPECT_GT(path.value().replayed.trace.size(), 1U);
    fastest_s = std::min(fastest_s, took.count());
  }
  EXPECT_LT(fastest_s, 0.2 * training_s);
}

TEST(InteractiveRenderer, PicksTheSurfaceOfAPixel) {
  Renderer renderer = load();
  EXPECT_FALSE(renderer.pick(V2f(0.5f))) << "before the first image";
  ImageSettings image = small_image();
  image.aovs = AovSet{};
  image.aovs.insert(Aov::depth);
  image.spp = 1;
  const RenderedImage rendered = render(renderer, image);
  const std::vector<float> depths = rendered.film.resolve(Aov::depth);
  size_t picked = 0;
  for (int y = 0; y < 32; y += 5)
    for (int x = 0; x < 48; x += 5) {
      const std::optional<PickedSurface> surface =
          renderer.pick(V2f((static_cast<float>(x) + 0.5f) / 48.0f, (static_cast<float>(y) + 0.5f) / 32.0f));
      if (!surface) continue;
      ++picked;
      const float depth = depths[static_cast<size_t>(y) * 48 + static_cast<size_t>(x)];
      if (depth > 0.0f) {
        EXPECT_NEAR(surface->depth_m, depth, 0.25f * depth) << x << " " << y;
      }
    }
  EXPECT_GT(picked, 0U);
}

} // namespace
} // namespace kindling
