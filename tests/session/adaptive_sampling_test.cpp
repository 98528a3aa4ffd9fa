// Adaptive sampling stops blocks by the documented rule and keeps the mean of the image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/load_gltf.h"
#include "renderer/session/adaptive_sampling.h"
#include "tests/integrator/test_scenes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <random>

namespace kindling::test {
namespace {

// Two blocks of the grid; the second is cut by the image's edge.
const V2i kImage(20, 16);
const PixelRect kArea{V2i(8, 8), V2i(20, 16)};
const PixelRect kLeft{V2i(8, 8), V2i(16, 16)};
const PixelRect kRight{V2i(16, 8), V2i(20, 16)};

void add_gray(Film& film, const PixelRect& block, float value) {
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) film.add({x, y}, {Rgb(value), 1.0f, 1.0f});
}

// Adds one sample of the reference cost and decides.
uint32_t decide(AdaptiveSampling& sampling, const PixelRect& block, uint32_t done, const Film& film) {
  sampling.count_rays(block, static_cast<uint64_t>(block.pixel_count() * AdaptiveSampling::kReferenceRays));
  return sampling.decide(block, done, film);
}

TEST(AdaptiveSampling, DecidesAtPowersOfTwo) {
  for (const auto& [minimum, first] : {std::pair(16U, 8U), {17U, 16U}, {32U, 16U}, {33U, 32U}, {100U, 64U}}) {
    AdaptiveState state;
    const AdaptiveSampling sampling(kArea, {0.1, minimum}, state);
    EXPECT_EQ(sampling.first_decision(), first);
    EXPECT_GE(2 * sampling.first_decision(), minimum);
  }
  // At 8 samples the first half for the first decision is stored.
  AdaptiveState state;
  const AdaptiveSampling sampling(kArea, {0.1, 32}, state);
  for (const auto& [done, until] :
       {std::pair(0U, 8U), {1U, 7U}, {8U, 8U}, {15U, 1U}, {16U, 16U}, {17U, 15U}, {40U, 24U}})
    EXPECT_EQ(sampling.samples_to_decision(done), until) << done;
}

TEST(AdaptiveSampling, WholeBlocksCoverTheCrop) {
  const PixelRect area = AdaptiveSampling::whole_blocks({V2i(9, 15), V2i(17, 16)}, kImage);
  EXPECT_EQ(area.min, kArea.min);
  EXPECT_EQ(area.max, kArea.max);
}

TEST(AdaptiveSampling, StopsAtTwiceTheDecisionsSamples) {
  Film film(kImage, kArea, AovSet{});
  AdaptiveState state;
  AdaptiveSampling sampling(kArea, {0.1, 32}, state);
  for (uint32_t n = 1; n <= 64; ++n) {
    if (sampling.wants_samples(kLeft, n - 1)) {
      add_gray(film, kLeft, n <= 16 ? 1.0f : 1000.0f * static_cast<float>(n)); // after the decision
      EXPECT_EQ(decide(sampling, kLeft, n, film), n == 32 ? 64U : 0U) << n;
    }
    add_gray(film, kRight, static_cast<float>(n)); // halves differ at all counts
    EXPECT_EQ(decide(sampling, kRight, n, film), 0U) << n;
    EXPECT_EQ(sampling.wants_samples(kLeft, n), n < 32);
    EXPECT_TRUE(sampling.wants_samples(kRight, n));
  }
}

// Half of the pixels are 1 -+ d in the halves of their samples, the others 1: the mean squared
// error of 2^k samples is d^2 / 2, that predicted for twice as many is half of it; a block that
// ends with n samples must be below T sqrt(n / 64).
TEST(AdaptiveSampling, ThresholdGrowsWithSamples) {
  constexpr double kDifference = 0.25;
  for (const uint32_t minimum : {32U, 64U, 128U}) {
    const double relative = std::sqrt(kDifference * kDifference / 4.0) / (1.0 + AdaptiveSampling::kNoiseFloor);
    const double threshold = relative / std::sqrt(minimum / AdaptiveSampling::kReferenceSamples);
    for (const double factor : {0.999, 1.001}) {
      Film film(kImage, kArea, AovSet{});
      AdaptiveState state;
      AdaptiveSampling sampling(kArea, {threshold * factor, minimum}, state);
      const uint32_t decision = minimum / 2;
      for (uint32_t n = 1; n <= decision; ++n) {
        const float d = static_cast<float>(n <= decision / 2 ? kDifference : -kDifference);
        for (int y = kRight.min.y; y < kRight.max.y; ++y)
          add_gray(film, {V2i(16, y), V2i(20, y + 1)}, y % 2 == 0 ? 1.0f : 1.0f + d);
        decide(sampling, kRight, n, film);
      }
      EXPECT_EQ(sampling.wants_samples(kRight, minimum), factor < 1.0) << minimum;
    }
  }
}

// One sample in two thousand finds all the light, so many blocks look finished while they are
// black. Compares deciding at 32 samples with deciding at 16 and stopping at 32, which the decision
// has not seen.
TEST(AdaptiveSampling, PredictingReducesBias) {
  constexpr int kBlocks = 4000;
  constexpr uint32_t kMaxSamples = 128;
  const PixelRect block{V2i(0, 0), V2i(8, 8)};
  std::mt19937 random(1);
  std::geometric_distribution<int> misses(1.0 / 2000.0);
  double ahead_sum = 0.0;
  double at_once_sum = 0.0;
  for (int i = 0; i < kBlocks; ++i) {
    AdaptiveState state;
    AdaptiveSampling sampling(block, {0.2, 32}, state);
    Film film(block.max, block, AovSet{});
    std::vector<double> sums{0.0}; // of the block after n samples
    bool at_32_black = true;
    int next = misses(random);
    std::optional<double> ahead;
    for (uint32_t n = 1; n <= kMaxSamples; ++n) {
      double found = 0.0;
      for (int p = 0; p < 64; ++p) {
        const bool light = next-- == 0;
        if (light) next = misses(random);
        found += light ? 2000.0 : 0.0;
        if (!ahead) film.add({p % 8, p / 8}, {Rgb(light ? 2000.0f : 0.0f), 1.0f, 1.0f});
      }
      sums.push_back(sums.back() + found / 64.0);
      at_32_black = at_32_black && (n > 32 || found == 0.0);
      if (!ahead) decide(sampling, block, n, film);
      if (!ahead && (!sampling.wants_samples(block, n) || n == kMaxSamples)) ahead = sums[n] / n;
    }
    ahead_sum += *ahead;
    at_once_sum += at_32_black ? 0.0 : sums[kMaxSamples] / kMaxSamples;
  }
  const double ahead_bias = ahead_sum / kBlocks - 1.0;
  const double at_once_bias = at_once_sum / kBlocks - 1.0;
  // The standard error of either is about 1 / sqrt(4000 * 4) = 0.008.
  EXPECT_LT(at_once_bias, -0.2); // there is a bias to reduce
  EXPECT_GT(ahead_bias, at_once_bias + 0.03);
}

// --- renders -------------------------------------------------------------------------------------

struct View {
  std::unique_ptr<const World> world;
  Camera camera;
};

// A matt sphere on a floor under a small bright lamp and a dim sky.
View lamp_view(const V2i& size_px) {
  Scene scene = make_scene({diffuse_material(Rgb(0.7f, 0.5f, 0.3f)), emissive_material(Rgb(20.0f))},
                           {sphere(V3f(0.0f), 1.0f, 32, 0), quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                            quad(V3f(-0.5f, 3, -0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 1)});
  return {make_world(std::move(scene), accel::Kind::embree, std::make_shared<Environment>(Rgb(0.1f, 0.2f, 0.3f))),
          Camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), size_px)};
}

View shipped_view(const char* name, const V2i& size_px) {
  Result<Scene> loaded = load_gltf(std::string(KINDLING_SOURCE_DIR "/scenes/") + name, {}, nullptr);
  EXPECT_TRUE(loaded.ok());
  Scene scene = std::move(loaded).value();
  const PosedScene posed = pose_scene(scene, {}).value();
  const PosedCamera& posed_camera = posed.cameras.at(0);
  const Camera camera(scene.cameras.at(static_cast<size_t>(posed_camera.camera)), posed_camera.camera_to_world,
                      size_px);
  return {make_world(std::move(scene), accel::Kind::embree), camera};
}

RenderOutcome render_view(const View& view, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(*view.world, view.camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value();
}

// Mean luminance of the image and the variance of that mean.
std::pair<double, double> image_mean(const Film& film) {
  const std::vector<float> rgb = film.resolve(Aov::beauty);
  const std::vector<float> variances = film.resolve(Aov::variance);
  double sum = 0.0;
  double variance = 0.0;
  for (size_t i = 0; i < variances.size(); ++i) {
    sum += luminance(Rgb(rgb[i * 3], rgb[i * 3 + 1], rgb[i * 3 + 2]));
    variance += variances[i];
  }
  const double n = static_cast<double>(variances.size());
  return {sum / n, variance / (n * n)};
}

TEST(AdaptiveRender, MeanEqualsFixedRender) {
  const V2i size(64, 48);
  for (const View& view : {lamp_view(size), shipped_view("cornell_box.glb", size)}) {
    RenderSettings settings = small_render(size, 2048);
    settings.adaptive = {0.08, 32};
    const RenderOutcome adaptive = render_view(view, settings);
    EXPECT_GT(adaptive.statistics.converged_share, 0.99);
    settings.adaptive = {};
    settings.samples_per_pixel = 128;
    settings.seed = 1;
    const auto [mean, variance] = image_mean(adaptive.film);
    const auto [fixed_mean, fixed_variance] = image_mean(render_view(view, settings).film);
    // Two independent means; four standard errors are exceeded once in 16,000 times.
    EXPECT_NEAR(mean, fixed_mean, 4.0 * std::sqrt(variance + fixed_variance));
  }
}

TEST(AdaptiveRender, SamplesStayWithinBounds) {
  const V2i size(40, 27);
  const View view = lamp_view(size);
  RenderSettings settings = small_render(size, 200);
  settings.adaptive = {0.012, 48};
  const RenderOutcome outcome = render_view(view, settings);
  const std::vector<float> counts = outcome.film.resolve(Aov::samples);
  size_t converged = 0;
  for (const float count : counts) {
    EXPECT_TRUE(count == 64.0f || count == 128.0f || count == 200.0f) << count;
    converged += count < 200.0f ? 1 : 0;
  }
  EXPECT_EQ(outcome.statistics.converged_share, static_cast<double>(converged) / static_cast<double>(counts.size()));
  EXPECT_GT(converged, 0U);
  EXPECT_LT(converged, counts.size());
  EXPECT_EQ(outcome.statistics.rays.paths, outcome.film.total_samples());
}

// A debug view is noisy at edges alone.
TEST(AdaptiveRender, BlocksWithEdgesTakeMoreSamples) {
  const V2i size(64, 64);
  const View view = shipped_view("cornell_box.glb", size);
  RenderSettings settings = small_render(size, 1024);
  settings.integrator.kind = IntegratorKind::albedo;
  settings.adaptive = {0.002, 16};
  const Film film = render_view(view, settings).film;
  const std::vector<float> counts = film.resolve(Aov::samples);
  const std::vector<float> variances = film.resolve(Aov::variance);
  double smooth = 0.0;
  double edge = 0.0;
  size_t edges = 0;
  for (size_t block = 0; block < 64; ++block) {
    const size_t corner = block / 8 * 8 * 64 + block % 8 * 8;
    bool has_edge = false;
    for (size_t i = 0; i < 64; ++i) {
      const size_t pixel = corner + i / 8 * 64 + i % 8;
      EXPECT_EQ(counts[pixel], counts[corner]);
      has_edge |= variances[pixel] > 1e-9f; // rounding errors are far below
    }
    (has_edge ? edge : smooth) += counts[corner];
    edges += has_edge ? 1 : 0;
  }
  ASSERT_GT(edges, 10U);
  ASSERT_LT(edges, 60U);
  EXPECT_EQ(smooth / static_cast<double>(64 - edges), 16.0);
  EXPECT_GT(edge / static_cast<double>(edges), 64.0);
}

TEST(AdaptiveRender, EndsWhenAllPixelsConverge) {
  const V2i size(16, 16);
  RenderSettings settings = small_render(size, 1U << 20);
  settings.integrator.kind = IntegratorKind::albedo;
  settings.adaptive = {0.3, 16};
  const RenderOutcome outcome = render_view(lamp_view(size), settings);
  EXPECT_EQ(outcome.statistics.converged_share, 1.0);
  EXPECT_LT(outcome.statistics.samples_per_pixel, 4096U);
  EXPECT_FALSE(outcome.interrupted);
}

} // namespace
} // namespace kindling::test
