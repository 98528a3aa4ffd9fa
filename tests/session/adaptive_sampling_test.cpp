// Adaptive sampling: when a pixel stops, and that stopping leaves the mean where it was.
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

const PixelRect kTwoPixels{V2i(3, 5), V2i(5, 6)};

Film noise_film(const PixelRect& crop) {
  Film film(V2i(16, 16), crop, AovSet{});
  film.track_noise();
  return film;
}

void add_grey(Film& film, const V2i& pixel, float value) { film.add(pixel, {Rgb(value), 1.0f, 1.0f}); }

TEST(AdaptiveSampling, DecidesAtPowersOfTwo) {
  for (const auto& [minimum, first] : {std::pair(16U, 8U), {17U, 16U}, {32U, 16U}, {33U, 32U}, {100U, 64U}}) {
    const AdaptiveSampling sampling(kTwoPixels, {0.1, minimum});
    EXPECT_EQ(sampling.first_decision(), first);
    EXPECT_GE(2 * sampling.first_decision(), minimum);
  }
  const AdaptiveSampling sampling(kTwoPixels, {0.1, 32});
  for (const auto& [done, until] : {std::pair(0U, 16U), {1U, 15U}, {15U, 1U}, {16U, 16U}, {17U, 15U}, {40U, 24U}})
    EXPECT_EQ(sampling.samples_to_decision(done), until) << done;
}

TEST(AdaptiveSampling, StopsAtTwiceTheSamplesThatForesawIt) {
  Film film = noise_film(kTwoPixels);
  AdaptiveSampling sampling(kTwoPixels, {0.1, 32});
  for (uint32_t n = 1; n <= 64; ++n) {
    add_grey(film, {3, 5}, n <= 16 ? 1.0f : 1000.0f * static_cast<float>(n)); // too late to be seen
    add_grey(film, {4, 5}, n % 2 == 0 ? 0.0f : 2.0f);
    const uint32_t stopped = sampling.decide(kTwoPixels, n, film);
    const PixelBlock left = sampling.remaining(kTwoPixels, n);
    EXPECT_EQ(stopped, n == 32 ? 1U : 0U) << n;
    EXPECT_EQ(left.pixel_count(), n < 32 ? 2 : 1) << n;
    EXPECT_EQ(left.skips({3, 5}), n >= 32);
    EXPECT_FALSE(left.skips({4, 5}));
  }
}

// Ones with +-d: s^2 = d^2 n / (n - 1); the error foreseen at 2n is s / sqrt(2n) / 1.1.
TEST(AdaptiveSampling, TheThresholdIsTheErrorAtTheEnd) {
  const double error = 0.5 * std::sqrt(16.0 / 15.0) / std::sqrt(32.0) / (1.0 + Film::kNoiseFloor);
  for (const double factor : {0.99, 1.01}) {
    Film film = noise_film(kTwoPixels);
    AdaptiveSampling sampling(kTwoPixels, {error * factor, 32});
    for (int n = 0; n < 16; ++n)
      for (int x = 3; x < 5; ++x) add_grey(film, {x, 5}, n % 2 == 0 ? 0.5f : 1.5f);
    sampling.decide(kTwoPixels, 16, film);
    EXPECT_EQ(sampling.remaining(kTwoPixels, 32).pixel_count(), factor > 1.0 ? 0 : 2);
  }
}

// One sample in fifty finds all the light, so that most pixels seem done while they are black. Stopping where the error is
// judged, at 32, leaves those black that found nothing by then, 52 % of them; deciding at 16 stops 72 % of them, but after 16 more
// samples that the decision knows nothing of, worth half of their light.
TEST(AdaptiveSampling, DecidingAheadLosesLessOfWhatIsRare) {
  constexpr int kPixels = 20000;
  constexpr double kThreshold = 0.15;
  constexpr uint32_t kMostSamples = 256;
  const PixelRect pixel{V2i(0, 0), V2i(1, 1)};
  std::mt19937 random(1);
  std::bernoulli_distribution found(0.02);
  double ahead_sum = 0.0;
  double at_once_sum = 0.0;
  for (int i = 0; i < kPixels; ++i) {
    Film film = noise_film(pixel);
    AdaptiveSampling sampling(pixel, {kThreshold, 32});
    std::optional<double> ahead;
    std::optional<double> at_once;
    for (uint32_t n = 1; n <= kMostSamples && !(ahead && at_once); ++n) {
      add_grey(film, {0, 0}, found(random) ? 50.0f : 0.0f);
      const double mean = film.resolve(Aov::beauty)[0];
      sampling.decide(pixel, n, film);
      if (!ahead && (sampling.remaining(pixel, n).pixel_count() == 0 || n == kMostSamples)) ahead = mean;
      const bool judged = n >= 32 && std::has_single_bit(n) && film.relative_error({0, 0}, n) < kThreshold;
      if (!at_once && (judged || n == kMostSamples)) at_once = mean;
    }
    ahead_sum += *ahead;
    at_once_sum += *at_once;
  }
  const double ahead_bias = ahead_sum / kPixels - 1.0;
  const double at_once_bias = at_once_sum / kPixels - 1.0;
  // One standard error of either is below 0.01.
  EXPECT_LT(at_once_bias, -0.4); // something to lose
  EXPECT_GT(ahead_bias, 0.8 * at_once_bias);
}

// --- renders ------------------------------------------------------------------------------------------------------

struct View {
  std::unique_ptr<const World> world;
  Camera camera;
};

// A matt ball on a floor under a small bright lamp and a dim sky.
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

// Mean luminance of the picture and the variance of that mean.
std::pair<double, double> picture_mean(const Film& film) {
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

TEST(AdaptiveRender, MeanIsThatOfAFixedRender) {
  const V2i size(64, 48);
  for (const View& view : {lamp_view(size), shipped_view("cornell_box.glb", size)}) {
    RenderSettings settings = small_render(size, 2048);
    settings.adaptive = {0.08, 32};
    const RenderOutcome adaptive = render_view(view, settings);
    EXPECT_GT(adaptive.statistics.converged_share, 0.99);
    settings.adaptive = {};
    settings.samples_per_pixel = 128;
    settings.seed = 1;
    const auto [mean, variance] = picture_mean(adaptive.film);
    const auto [fixed_mean, fixed_variance] = picture_mean(render_view(view, settings).film);
    // Two independent means; four standard errors are exceeded once in 16,000 times.
    EXPECT_NEAR(mean, fixed_mean, 4.0 * std::sqrt(variance + fixed_variance));
  }
}

TEST(AdaptiveRender, SamplesStayWithinTheirBounds) {
  const V2i size(40, 27);
  const View view = lamp_view(size);
  RenderSettings settings = small_render(size, 200);
  settings.adaptive = {0.05, 48};
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

// A debug view has noise at the edges of what it shows, and none elsewhere.
TEST(AdaptiveRender, EdgesTakeMoreSamplesThanWhatLiesBetween) {
  const V2i size(64, 64);
  const View view = shipped_view("cornell_box.glb", size);
  RenderSettings settings = small_render(size, 1024);
  settings.integrator.kind = IntegratorKind::albedo;
  settings.adaptive = {0.02, 16};
  const Film film = render_view(view, settings).film;
  const std::vector<float> counts = film.resolve(Aov::samples);
  const std::vector<float> variances = film.resolve(Aov::variance);
  double smooth = 0.0;
  double edge = 0.0;
  size_t edges = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    const bool is_edge = variances[i] > 1e-9f; // what rounding leaves is far below
    (is_edge ? edge : smooth) += counts[i];
    edges += is_edge ? 1 : 0;
  }
  ASSERT_GT(edges, 100U);
  ASSERT_LT(edges, counts.size() / 2);
  EXPECT_EQ(smooth / static_cast<double>(counts.size() - edges), 16.0);
  EXPECT_GT(edge / static_cast<double>(edges), 64.0);
}

TEST(AdaptiveRender, EndsWhenAllPixelsHaveConverged) {
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
