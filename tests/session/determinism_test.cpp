// Images have the same bits for any threads, tiles, batches, crops and division into passes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/record_rays.h"
#include "tests/session/different_pixels.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <set>
#include <thread>

namespace kindling::test {
namespace {

const V2i kSize(75, 53); // not a multiple of anything

Camera test_camera() { return {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize}; }

Film render_film(const World& world, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, test_camera(), settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value().film;
}

class Determinism : public testing::TestWithParam<accel::Kind> {};

TEST_P(Determinism, SameBitsForThreadsTilesAndBatches) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = small_render(kSize, 7);
  settings.integrator.roulette_start_bounce = 2;
  add_aovs_of_camera(settings);
  add_mattes(settings);
  settings.threads = 1;
  const Film reference = render_film(*world, settings);
  struct Variation {
    int threads;
    int tile_size_px;
    uint32_t batch_size;
    Schedule schedule = Schedule::tiles;
  };
  for (const Variation& v : {Variation{2, 32, 256}, Variation{7, 32, 256}, Variation{3, 8, 64}, Variation{2, 64, 512},
                             Variation{5, 16, 256, Schedule::regions}}) {
    settings.schedule = v.schedule;
    settings.threads = v.threads;
    settings.tile_size_px = v.tile_size_px;
    settings.integrator.batch_size = v.batch_size;
    const Film film = render_film(*world, settings);
    expect_same_bits(film, reference,
                     std::to_string(v.threads) + " threads, tiles of " + std::to_string(v.tile_size_px) +
                         ", batches of " + std::to_string(v.batch_size));
  }
}

TEST_P(Determinism, CropShowsTheSamePixels) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = small_render(kSize, 5);
  const Film whole = render_film(*world, settings);
  settings.crop = PixelRect{V2i(13, 9), V2i(50, 41)};
  expect_same_bits(render_film(*world, settings), whole, "crop");
}

// Options that trade bias for less noise, also with crops.
TEST_P(Determinism, SameBitsWithClampsAndTrimming) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = small_render(kSize, 23);
  settings.outliers = Outliers::trim;
  settings.threads = 1;
  const std::vector<float> plain = render_film(*world, small_render(kSize, 23)).resolve_rgba();
  for (const Caustics caustics : {Caustics::regularized, Caustics::off}) {
    settings.integrator.caustics = caustics;
    settings.crop.reset();
    const Film whole = render_film(*world, settings);
    EXPECT_FALSE(same_bits(whole.resolve_rgba(), plain)); // the options have an effect
    RenderSettings other = settings;
    other.threads = 3;
    other.tile_size_px = 8;
    other.integrator.batch_size = 64;
    expect_same_bits(render_film(*world, other), whole, "threads, tiles and batches");
    other.crop = PixelRect{V2i(13, 9), V2i(50, 41)};
    expect_same_bits(render_film(*world, other), whole, "crop");
  }
}

// Some pixels stop at 32 samples, others later or never. The sampler is one whose points do not
// depend on the largest count of samples, so that renders of several counts can be compared.
RenderSettings adaptive_render() {
  RenderSettings settings = small_render(kSize, 100);
  settings.sampler = SamplerKind::sobol;
  settings.adaptive = {.noise_threshold = 0.06, .min_samples_per_pixel = 20};
  settings.aovs.insert(Aov::samples);
  return settings;
}

TEST_P(Determinism, SameBitsWithAdaptiveSampling) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = adaptive_render();
  settings.threads = 1;
  const Film reference = render_film(*world, settings);
  const std::vector<float> counts = reference.resolve(Aov::samples);
  for (const float expected : {32.0f, 64.0f, 100.0f}) // all kinds of blocks occur
    EXPECT_GT(std::count(counts.begin(), counts.end(), expected), 40) << expected;

  settings.threads = 3;
  expect_same_bits(render_film(*world, settings), reference, "number of threads");
  settings.tile_size_px = 8;
  expect_same_bits(render_film(*world, settings), reference, "tile size");
  settings.integrator.batch_size = 64;
  expect_same_bits(render_film(*world, settings), reference, "batch size");
  settings.crop = PixelRect{V2i(13, 9), V2i(50, 41)};
  expect_same_bits(render_film(*world, settings), reference, "crop");
}

// The samples of an adaptive render are the first ones of a fixed one, pixel by pixel.
TEST_P(Determinism, AdaptiveSamplesEqualFixedRender) {
  const auto world = mixed_world(GetParam());
  const Film adaptive = render_film(*world, adaptive_render());
  const std::vector<float> counts = adaptive.resolve(Aov::samples);
  const std::vector<float> beauty = adaptive.resolve(Aov::beauty);
  for (const uint32_t count : {32U, 64U, 100U}) {
    RenderSettings fixed_settings = small_render(kSize, count);
    fixed_settings.sampler = SamplerKind::sobol;
    const std::vector<float> fixed = render_film(*world, fixed_settings).resolve(Aov::beauty);
    for (size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == static_cast<float>(count)) {
        ASSERT_EQ(std::memcmp(&beauty[i * 3], &fixed[i * 3], 3 * sizeof(float)), 0) << "pixel " << i;
      }
    }
  }
}

// An accelerator's answers may depend on the group of rays, so stopped pixels stay in it.
TEST(AdaptiveSampling, CameraRaysOfABlockStayTogether) {
  RecordingAccelerator* recorder = nullptr;
  WorldOptions options;
  options.wrap_accelerator = [&](std::unique_ptr<accel::Accelerator> inner) {
    auto recording = std::make_unique<RecordingAccelerator>(std::move(inner));
    recorder = recording.get();
    return recording;
  };
  Scene scene = mixed_scene();
  PosedScene posed = pose_scene(scene, {}).value();
  const std::unique_ptr<const World> world =
      build_world(std::move(scene), std::move(posed), options, nullptr, nullptr).value();
  size_t groups = 0;
  recorder->listen([&](RecordingAccelerator::Call call, std::span<const accel::Ray> rays) {
    if (call != RecordingAccelerator::Call::coherent) return;
    ++groups;
    // Whole blocks, and those that the right edge, the lower edge or both cut.
    ASSERT_TRUE(rays.size() == 64 || rays.size() == 3 * 8 || rays.size() == 8 * 5 || rays.size() == 3 * 5)
        << rays.size();
  });
  RenderSettings settings = adaptive_render();
  settings.threads = 1;
  const std::vector<float> counts = render_film(*world, settings).resolve(Aov::samples);
  EXPECT_LT(*std::min_element(counts.begin(), counts.end()), 100.0f);
  EXPECT_GT(groups, 10U * 7U * 32U);
}

TEST_P(Determinism, SeedsDiffer) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = small_render(kSize, 2);
  const std::vector<float> first = render_film(*world, settings).resolve_rgba();
  settings.seed = 1;
  EXPECT_FALSE(same_bits(first, render_film(*world, settings).resolve_rgba()));
}

TEST_P(Determinism, ReplayReproducesSample) {
  const auto world = mixed_world(GetParam());
  RenderSettings settings = small_render(kSize, 1);
  settings.aovs = AovSet{};
  const std::vector<float> beauty = render_film(*world, settings).resolve(Aov::beauty);
  for (const V2i& pixel : {V2i(37, 26), V2i(20, 30), V2i(70, 5)}) {
    const Result<ReplayedSample> replayed = replay_sample(*world, test_camera(), settings, pixel, 0);
    ASSERT_TRUE(replayed.ok());
    const float* expected =
        beauty.data() +
        (static_cast<size_t>(pixel.y) * static_cast<size_t>(kSize.x) + static_cast<size_t>(pixel.x)) * 3;
    for (int c = 0; c < 3; ++c) EXPECT_EQ(replayed.value().radiance[c], expected[c]);
    ASSERT_GE(replayed.value().trace.size(), 2U);
    EXPECT_EQ(replayed.value().trace.front().event, "camera");
  }
}

INSTANTIATE_TEST_SUITE_P(Accelerators, Determinism, testing::Values(accel::Kind::embree, accel::Kind::kdtree),
                         [](const auto& param) { return std::string(accel::kind_name(param.param)); });

// Images of two accelerators differ by rounding only.
TEST(Accelerators, RenderSameImage) {
  RenderSettings settings = small_render(kSize, 8);
  const std::vector<float> oracle = render_film(*mixed_world(accel::Kind::brute_force), settings).resolve_rgba();
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree}) {
    const std::vector<float> image = render_film(*mixed_world(kind), settings).resolve_rgba();
    // A path whose hit moves by rounding may take another branch at an edge: rare.
    EXPECT_LE(different_pixels(image, oracle), oracle.size() / 4 / 100) << accel::kind_name(kind);
  }
}

// --- the loop around it --------------------------------------------------------------------------

TEST(RenderSession, RefusesImpossibleSettings) {
  const auto world = mixed_world(accel::Kind::embree);
  const auto refused = [&](auto change) {
    RenderSettings settings = small_render(kSize, 1);
    change(settings);
    const Result<RenderOutcome> outcome = render(*world, test_camera(), settings, nullptr, nullptr);
    return !outcome.ok() && outcome.error().kind == ErrorKind::usage && !outcome.error().message.empty();
  };
  EXPECT_TRUE(refused([](RenderSettings& s) { s.size_px = V2i(0, 5); }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.samples_per_pixel = 0; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.adaptive.noise_threshold = -0.1; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.adaptive.noise_threshold = std::nan(""); }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.adaptive = {0.1, 15}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.tile_size_px = 12; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.integrator.batch_size = 100; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.crop = PixelRect{V2i(5, 5), V2i(100, 20)}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.integrator.max_bounces = -1; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.integrator.max_diffuse_bounces = 100000; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.integrator.roulette_start_bounce = -1; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.integrator.environment_filter = -0.1f; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.integrator.environment_filter = 65.0f; }));
  EXPECT_FALSE(refused([](RenderSettings&) {}));
}

class CancelAfterSamples final : public ProgressListener {
 public:
  CancelAfterSamples(CancelToken& token, double samples_per_pixel)
      : token_(token), samples_per_pixel_(samples_per_pixel) {}
  void on_progress(const ProgressSnapshot& snapshot) override {
    if (snapshot.samples_per_pixel >= samples_per_pixel_) token_.cancel();
  }
  void on_warning(std::string_view) override {}
  void on_info(std::string_view) override {}

 private:
  CancelToken& token_;
  double samples_per_pixel_;
};

TEST(RenderSession, CancelledRenderHasEqualCounts) {
  const auto world = mixed_world(accel::Kind::embree);
  RenderSettings settings = small_render(kSize, 1U << 20);
  settings.sampler = SamplerKind::sobol; // the same points whatever the largest count
  CancelToken token;
  CancelAfterSamples listener(token, 0.0);
  const Result<RenderOutcome> outcome = render(*world, test_camera(), settings, &token, &listener);
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome.value().interrupted);
  const uint32_t finished = outcome.value().statistics.samples_per_pixel;
  ASSERT_GE(finished, 1U);
  settings.planned_samples = settings.planned(); // the width of the environment filter stays
  settings.samples_per_pixel = finished;
  EXPECT_TRUE(same_bits(outcome.value().film.resolve_rgba(), render_film(*world, settings).resolve_rgba()));
}

TEST(RenderSession, CancelledAdaptiveRenderHasEqualCounts) {
  const auto world = mixed_world(accel::Kind::embree);
  RenderSettings settings = adaptive_render();
  settings.samples_per_pixel = 1U << 20;
  CancelToken token;
  CancelAfterSamples listener(token, 40.0);
  const Result<RenderOutcome> outcome = render(*world, test_camera(), settings, &token, &listener);
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome.value().interrupted);
  settings.planned_samples = settings.planned(); // the width of the environment filter stays
  settings.samples_per_pixel = outcome.value().statistics.samples_per_pixel;
  ASSERT_GE(settings.samples_per_pixel, 40U);
  const Film whole = render_film(*world, settings);
  for (const Aov aov : {Aov::beauty, Aov::samples})
    EXPECT_TRUE(same_bits(outcome.value().film.resolve(aov), whole.resolve(aov)));
}

// A time limit can end a render at any count; each pixel is that of the render of its count,
// stopped blocks included.
TEST(RenderSession, TimeLimitedAdaptiveRenderHasWholeSamples) {
  const auto world = mixed_world(accel::Kind::embree);
  RenderSettings settings = adaptive_render();
  settings.samples_per_pixel = 1U << 20;
  settings.adaptive.noise_threshold = 1e-4; // reached only without noise
  settings.time_limit_s = 0.05;
  const Result<RenderOutcome> outcome = render(*world, test_camera(), settings, nullptr, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_FALSE(outcome.value().interrupted);
  const std::vector<float> samples = outcome.value().film.resolve(Aov::samples);
  const std::vector<float> beauty = outcome.value().film.resolve(Aov::beauty);
  settings.planned_samples = settings.planned();
  settings.time_limit_s.reset();
  for (const float count : std::set<float>(samples.begin(), samples.end())) {
    RenderSettings fixed = settings;
    fixed.samples_per_pixel = static_cast<uint32_t>(count);
    fixed.adaptive = {};
    const std::vector<float> whole = render_film(*world, fixed).resolve(Aov::beauty);
    for (size_t i = 0; i < samples.size(); ++i)
      if (samples[i] == count) {
        ASSERT_EQ(std::memcmp(&beauty[3 * i], &whole[3 * i], 3 * sizeof(float)), 0)
            << "pixel " << i << " with " << count << " samples";
      }
  }
}

// Slow passes become short and end at counts without decisions.
class SlowListener final : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot& snapshot) override {
    const bool pass_ends = snapshot.samples_per_pixel == std::floor(snapshot.samples_per_pixel);
    if (pass_ends) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  void on_warning(std::string_view) override {}
  void on_info(std::string_view) override {}
};

TEST(RenderSession, AdaptiveSamplingDoesNotDependOnPasses) {
  const auto world = mixed_world(accel::Kind::embree);
  const RenderSettings settings = adaptive_render();
  SlowListener listener;
  const Result<RenderOutcome> slow = render(*world, test_camera(), settings, nullptr, &listener);
  const Result<RenderOutcome> quick = render(*world, test_camera(), settings, nullptr, nullptr);
  ASSERT_TRUE(slow.ok() && quick.ok());
  for (const Aov aov : {Aov::beauty, Aov::samples})
    EXPECT_TRUE(same_bits(slow.value().film.resolve(aov), quick.value().film.resolve(aov)));
}

TEST(RenderSession, TimeLimitEndsTheRender) {
  const auto world = mixed_world(accel::Kind::embree);
  RenderSettings settings = small_render(kSize, 1U << 24);
  settings.time_limit_s = 0.3;
  const Result<RenderOutcome> outcome = render(*world, test_camera(), settings, nullptr, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_FALSE(outcome.value().interrupted);
  EXPECT_GE(outcome.value().statistics.render_s, 0.3);
  EXPECT_LT(outcome.value().statistics.samples_per_pixel, settings.samples_per_pixel);
}

} // namespace
} // namespace kindling::test
