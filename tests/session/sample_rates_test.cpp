// Renders whose pixels have different numbers of samples: bits, cost and error.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/check_settings.h"
#include "renderer/session/prepare/prepare_paths.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <cmath>
#include <functional>
#include <numeric>
#include <string_view>

namespace kindling::test {
namespace {

constexpr V2i kImageSize(64, 48);

// An environment without noise, in the left quarter behind a veil that every other sample passes.
std::unique_ptr<const World> partly_noisy_world(accel::Kind kind) {
  Material veil = diffuse_material(Rgb(0.0f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor[3] = 0.5f;
  return make_world(make_scene({veil}, {quad(V3f(-4, -3, 0), V3f(2.73f, 0, 0), V3f(0, 6, 0), 0)}), kind,
                    std::make_shared<Environment>(Rgb(0.3f)));
}

Camera front() { return {SceneCamera{}, look_at(V3f(0, 0, 4.5f), V3f(0.0f)), kImageSize}; }

// The cost by which rates are planned: rays of bounces and shadows, and 0.15 for each camera ray.
double cost_of(const RenderOutcome& outcome) {
  const RayCounters& rays = outcome.statistics.rays;
  return static_cast<double>(rays.bounce + rays.shadow) + 0.15 * static_cast<double>(rays.camera);
}

RenderSettings rates_settings(uint32_t levels) {
  RenderSettings settings = small_render(kImageSize, levels);
  settings.sample_rates = SampleRateKind::noise;
  settings.aovs.insert(Aov::samples);
  return settings;
}

RenderOutcome render_rates(const World& world, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, front(), settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  return std::move(outcome).value();
}

TEST(SampleRatesRender, NoisyPixelsHaveMoreSamplesForTheSameCost) {
  const auto world = partly_noisy_world(accel::Kind::kdtree);
  RenderSettings settings = rates_settings(64);
  const RenderOutcome noise = render_rates(*world, settings);
  settings.sample_rates = SampleRateKind::even;
  const RenderOutcome even = render_rates(*world, settings);
  const std::vector<float> samples = noise.film.resolve(Aov::samples);
  const auto samples_at = [&](int x, int y) { return samples[static_cast<size_t>(y * kImageSize.x + x)]; };
  EXPECT_GE(samples_at(4, 20), 64.0f); // the veil
  EXPECT_EQ(samples_at(60, 20), 8.0f); // the environment
  // A power of two that is too large or too small by half a step, as a quarter of the image has it.
  EXPECT_NEAR(std::log2(cost_of(noise) / cost_of(even)), 0.0, 0.55);
  EXPECT_EQ(noise.film.total_samples(), noise.statistics.rays.paths); // the pilot is part of the image
  EXPECT_EQ(noise.statistics.samples_per_pixel, 64U);
  EXPECT_GT(noise.statistics.first_pass_s, 0.0);
}

// With independent samples the error is in proportion to 1 / samples. A quarter of the pixels are
// noisy and cost 1.15 a sample, the others 0.15 and have 8 samples. With n samples of the noisy
// ones, error times cost is 64 / n (1.15 n + 3 * 0.15 * 8) / (64 (1.15 + 3 * 0.15)): 0.74 to 0.75
// for 128 and for 64.
TEST(SampleRatesRender, LeaveLessError) {
  const auto world = partly_noisy_world(accel::Kind::embree);
  std::array<double, 2> error{}, cost{};
  for (uint32_t seed = 1; seed <= 4; ++seed)
    for (const SampleRateKind kind : {SampleRateKind::even, SampleRateKind::noise}) {
      RenderSettings settings = rates_settings(64);
      settings.seed = seed;
      settings.sampler = SamplerKind::independent;
      settings.sample_rates = kind;
      const RenderOutcome outcome = render_rates(*world, settings);
      const std::vector<float> beauty = outcome.film.resolve(Aov::beauty);
      const auto i = static_cast<size_t>(kind);
      for (int y = 0; y < kImageSize.y; ++y)
        for (int x = 0; x < kImageSize.x / 4 - 6; ++x) {
          const double difference = static_cast<double>(beauty[static_cast<size_t>((y * kImageSize.x + x) * 3)]) - 0.15;
          error[i] += difference * difference;
        }
      cost[i] += cost_of(outcome);
    }
  constexpr double kExpected = 0.747;
  // The standard error of a ratio of two sums of 1,920 squares is 2 / sqrt(1920) of it; five of
  // them.
  EXPECT_NEAR(error[1] / error[0] * cost[1] / cost[0], kExpected, (5.0 * 2.0 / 43.8 + 0.05) * kExpected);
}

TEST(SampleRatesRender, DevicesHaveTheBitsOfTheCpu) {
  const auto world = partly_noisy_world(accel::Kind::kdtree);
  RenderSettings settings = rates_settings(24);
  settings.aovs.insert(Aov::variance);
  const RenderOutcome cpu = render_rates(*world, settings);
  settings.device = DeviceKind::host;
  const RenderOutcome host = render_rates(*world, settings);
  expect_same_bits(host.film, cpu.film, "the host device");
  EXPECT_EQ(host.statistics.rays.total(), cpu.statistics.rays.total());
  Film sum(kImageSize, cpu.film.crop(), settings.aovs);
  settings.samples = SampleRange{3, 11};
  sum.add(render_rates(*world, settings).film);
  settings.device = DeviceKind::cpu;
  for (const SampleRange& levels : {SampleRange{11, 24}, SampleRange{0, 3}}) {
    settings.samples = levels;
    sum.add(render_rates(*world, settings).film);
  }
  expect_same_bits(sum, cpu.film, "parts of both");
}

TEST(SampleRatesRender, AFewSamplesAreEven) {
  const auto world = partly_noisy_world(accel::Kind::kdtree);
  RenderSettings settings = rates_settings(SampleRates::kPilotLevels);
  const Film noise = render_rates(*world, settings).film;
  settings.sample_rates = SampleRateKind::even;
  expect_same_bits(noise, render_rates(*world, settings).film, "no levels after the pilot");
}

TEST(SampleRatesRender, WithoutNoiseAllPixelsAreEqual) {
  const auto world = make_world(make_scene({}, {}), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.3f)));
  for (const float samples : render_rates(*world, rates_settings(16)).film.resolve(Aov::samples))
    EXPECT_EQ(samples, 16.0f);
}

RenderSettings automatic_settings() {
  RenderSettings settings = small_render(V2i(256, 256), 16);
  settings.sample_rates = SampleRateKind::automatic;
  settings.aovs.insert(Aov::samples);
  return settings;
}

TEST(SampleRatesRender, AutomaticFollowsThePilot) {
  const auto world = partly_noisy_world(accel::Kind::kdtree);
  const Camera camera{SceneCamera{}, look_at(V3f(0, 0, 4.5f), V3f(0.0f)), V2i(256, 256)};
  RenderSettings settings = automatic_settings();
  const Result<RenderOutcome> chosen = render(*world, camera, settings, nullptr, nullptr);
  ASSERT_TRUE(chosen.ok());
  const RateChoice& choice = chosen.value().statistics.sample_rates;
  EXPECT_GT(choice.rule.scale, 0.0);
  EXPECT_LT(choice.predicted, 1.0 / kMinRatesGain);
  EXPECT_GT(choice.paths, 0U);
  EXPECT_EQ(chosen.value().work.rate_rule, choice.rule);
  settings.sample_rates = SampleRateKind::noise;
  expect_same_bits(render(*world, camera, settings, nullptr, nullptr).value().film, chosen.value().film, "noise");
  const auto plain = make_world(make_scene({}, {}), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.3f)));
  settings.sample_rates = SampleRateKind::automatic;
  const RenderOutcome none = render(*plain, camera, settings, nullptr, nullptr).value();
  EXPECT_EQ(none.work.rate_rule->scale, 0.0);
  settings.sample_rates = SampleRateKind::even;
  expect_same_bits(none.film, render(*plain, camera, settings, nullptr, nullptr).value().film, "even");
}

TEST(SampleRatesRender, AutomaticIsEvenWhereRatesDoNotWork) {
  const auto world = partly_noisy_world(accel::Kind::kdtree);
  const auto expect_even = [&](const char* what, const std::function<void(RenderSettings&)>& change) {
    RenderSettings settings = automatic_settings();
    change(settings);
    const Camera camera{SceneCamera{}, look_at(V3f(0, 0, 4.5f), V3f(0.0f)), settings.size_px};
    const PreparedPaths prepared = prepare_paths(*world, camera, settings, nullptr, {}, nullptr);
    EXPECT_EQ(prepared.sample_rates.paths, 0U) << what;
    EXPECT_EQ(settings.sample_rates, SampleRateKind::even) << what;
  };
  expect_even("few pixels", [](auto& s) { s.size_px = V2i(255, 256); });
  expect_even("few samples", [](auto& s) {
    s.size_px = V2i(512, 512);
    s.samples_per_pixel = 15;
  });
  expect_even("noise threshold", [](auto& s) { s.adaptive.noise_threshold = 0.1; });
  expect_even("time limit", [](auto& s) { s.time_limit_s = 60.0; });
  expect_even("shadow catchers", [](auto& s) { s.aovs.insert(Aov::shadow_catcher); });
  expect_even("path reuse", [](auto& s) { s.integrator.path_reuse = 4; });
  expect_even("light paths", [](auto& s) { s.integrator.light_paths = 0.5f; });
  expect_even("photons", [](auto& s) { s.integrator.photons = 0.5f; });
  expect_even("whitted", [](auto& s) { s.integrator.kind = IntegratorKind::whitted; });
}

TEST(SampleRatesRender, AddsToLightPaths) {
  Material glass = diffuse_material(Rgb(1.0f));
  glass.roughness_factor = 0.0f;
  glass.transmission_factor = glass.thickness_factor = 1.0f;
  const auto world =
      make_world(make_scene({diffuse_material(Rgb(0.7f)), glass, emissive_material(Rgb(30.0f))},
                            {quad(V3f(-4, -1, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0.0f), 0.8f, 32, 1),
                             quad(V3f(-0.5f, 3, -0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 2)}),
                 accel::Kind::kdtree);
  RenderSettings settings = rates_settings(16);
  settings.integrator.light_paths = 0.5f;
  const Film whole = render_rates(*world, settings).film;
  Film sum(kImageSize, whole.crop(), whole.aovs());
  sum.enable_splats();
  for (const SampleRange& levels : {SampleRange{7, 16}, SampleRange{0, 2}, SampleRange{2, 7}}) {
    settings.samples = levels;
    settings.threads = static_cast<int>(levels.end % 3) + 1;
    sum.add(render_rates(*world, settings).film);
  }
  expect_same_bits(sum, whole, "parts of the levels");
}

TEST(SampleRatesRender, StopsInThePilot) {
  const auto world = partly_noisy_world(accel::Kind::kdtree);
  CancelToken token;
  token.cancel_now();
  Result<RenderOutcome> outcome = render(*world, front(), rates_settings(64), &token, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome.value().interrupted);
  EXPECT_EQ(outcome.value().film.total_samples(), 0U);
}

// Stops once every pixel has a sample. The second sample of the pilot may have begun.
TEST(SampleRatesRender, HasAnImageOnceEveryPixelHasASample) {
  struct Listener : ProgressListener {
    CancelToken token;
    void on_progress(const ProgressSnapshot& snapshot) override {
      if (snapshot.samples_per_pixel >= 1.0) token.cancel_now();
    }
    void on_warning(std::string_view /*message*/) override {}
    void on_info(std::string_view /*message*/) override {}
  } listener;
  const auto world = partly_noisy_world(accel::Kind::kdtree);
  RenderSettings settings = rates_settings(64);
  settings.threads = 2;
  const Result<RenderOutcome> outcome = render(*world, front(), settings, &listener.token, &listener);
  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome.value().interrupted);
  EXPECT_GT(outcome.value().statistics.first_pass_s, 0.0);
  for (const float samples : outcome.value().film.resolve(Aov::samples)) {
    EXPECT_GE(samples, 1.0f);
    EXPECT_LE(samples, 4.0f);
  }
}

TEST(SampleRatesRender, RefusesOtherKindsOfSampling) {
  const auto refusal = [](const std::function<void(RenderSettings&)>& change) {
    RenderSettings settings = rates_settings(64);
    change(settings);
    const Result<void> checked = check_settings(settings, front());
    return checked.ok() ? std::string() : checked.error().message;
  };
  EXPECT_EQ(refusal([](RenderSettings&) {}), "");
  const auto expect_refused = [&](const char* words, const std::function<void(RenderSettings&)>& change) {
    EXPECT_NE(refusal(change).find(words), std::string::npos) << words << ": " << refusal(change);
  };
  expect_refused("--sample-rates noise: not with --integrator whitted; use path",
                 [](auto& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_refused("with --noise-threshold", [](auto& s) { s.adaptive.noise_threshold = 0.1; });
  expect_refused("with a time limit; use --spp", [](auto& s) { s.time_limit_s = 3.0; });
}

} // namespace
} // namespace kindling::test
