// Light paths give the same bits however the samples are divided, and refuse what they cannot do.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/check_settings.h"
#include "renderer/session/prepare/choose_light_paths.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/parts_of_light.h"
#include "tests/session/same_bits.h"
#include "tests/session/split_film.h"
#include "tests/session/test_accumulation.h"

#include <functional>
#include <span>

namespace kindling::test {
namespace {

constexpr V2i kSize(40, 30);

RenderSettings glass_settings() {
  RenderSettings settings = small_render(kSize, 9);
  settings.integrator.light_paths = 0.4f;
  return settings;
}

RenderOutcome rendered(const World& world, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, glass_camera(kSize), settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << outcome.error().message;
  return std::move(outcome).value();
}

TEST(LightPathRender, KeepsItsBitsWithAnyThreadsTilesAndPartsOfTheSamples) {
  const auto world = glass_world(accel::Kind::kdtree);
  const Film whole = rendered(*world, glass_settings()).film;
  for (const int threads : {1, 3}) {
    RenderSettings settings = glass_settings();
    settings.threads = threads;
    settings.tile_size_px = 8 * threads;
    settings.integrator.batch_size = 64;
    expect_same_bits(rendered(*world, settings).film, whole, std::to_string(threads) + " threads");
  }
  Film sum(kSize, {V2i(0), kSize}, glass_settings().aovs);
  sum.enable_splats();
  for (const SampleRange& samples : {SampleRange{5, 9}, SampleRange{0, 1}, SampleRange{1, 5}}) {
    RenderSettings settings = glass_settings();
    settings.samples = samples;
    sum.add(rendered(*world, settings).film);
  }
  expect_same_bits(sum, whole, "parts of the samples");
}

// Returns the number of light paths whose light a film has.
uint64_t splat_paths(const Film& film) {
  const auto plane = plane_bytes_of(film, "splats");
  uint64_t paths = 0;
  for (const SplatSum& splat :
       std::span(reinterpret_cast<const SplatSum*>(plane.data()), plane.size() / sizeof(SplatSum)))
    paths += splat.paths;
  return paths;
}

// A part of the image has the light that its paths bring to all pixels.
TEST(LightPathRender, PartsOfTheImageAddUp) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = glass_settings();
  settings.crop = PixelRect{V2i(3, 2), V2i(38, 27)};
  const Film whole = rendered(*world, settings).film;
  Film sum(kSize, whole.crop(), whole.aovs());
  sum.enable_splats();
  for (const PixelRect& region : make_regions(*settings.crop, 3)) {
    settings.region = region;
    const Film part = rendered(*world, settings).film;
    EXPECT_EQ(part.crop(), region);
    EXPECT_EQ(part.splat_area(), *settings.crop);
    sum.add(part);
  }
  expect_same_bits(sum, whole, "parts of the image");
}

// The pixels of a crop have the light of all light paths, also of those that begin outside of it.
TEST(LightPathRender, CropsHaveThePixelsOfTheWholeImage) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = glass_settings();
  divide_light(settings);
  const Film whole = rendered(*world, settings).film;
  for (const PixelRect& crop :
       {PixelRect{V2i(3, 2), V2i(38, 27)}, PixelRect{V2i(0, 13), V2i(40, 21)}, PixelRect{V2i(16, 16), V2i(17, 17)}}) {
    const std::string name = "a crop from " + std::to_string(crop.min.x) + "," + std::to_string(crop.min.y);
    settings.crop = crop;
    settings.threads = crop.min.x == 0 ? 1 : 3;
    settings.integrator.batch_size = crop.min.x == 3 ? 64 : 256;
    const RenderOutcome outcome = rendered(*world, settings);
    expect_same_bits(outcome.film, whole, name);
    EXPECT_EQ(splat_paths(outcome.film), splat_paths(whole)) << name;
    EXPECT_GT(outcome.statistics.rays.outside, 0U);
    EXPECT_LT(outcome.statistics.rays.outside, outcome.statistics.rays.total());
    settings.device = DeviceKind::host;
    settings.integrator.light_groups = LightGrouping::off;
    settings.aovs = glass_settings().aovs;
    const RenderOutcome on_device = rendered(*world, settings);
    EXPECT_EQ(on_device.film.resolve(Aov::beauty), outcome.film.resolve(Aov::beauty)) << name;
    EXPECT_EQ(on_device.statistics.rays.outside, outcome.statistics.rays.outside) << name;
    settings.device = DeviceKind::cpu;
    divide_light(settings);
  }
}

// Sample rates differ from pixel to pixel; light paths go by levels.
TEST(LightPathRender, CropsWithSampleRatesHaveThePixelsOfTheWholeImage) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = glass_settings();
  settings.sample_rates = SampleRateKind::noise;
  settings.min_rates_gain = 0.0;
  settings.aovs.insert(Aov::samples);
  const Film whole = rendered(*world, settings).film;
  settings.crop = PixelRect{V2i(5, 3), V2i(30, 28)};
  expect_same_bits(rendered(*world, settings).film, whole, "a crop");
}

// Blocks stop by their own samples. The rays of other pixels' light paths must not count for that.
TEST(LightPathRender, CropsStopWhereTheWholeImageDoes) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = glass_settings();
  settings.samples_per_pixel = 64;
  settings.adaptive = {.noise_threshold = 0.1, .min_samples_per_pixel = 16};
  settings.aovs.insert(Aov::samples);
  const Film whole = rendered(*world, settings).film;
  settings.crop = PixelRect{V2i(8, 8), V2i(32, 24)};
  const Film crop = rendered(*world, settings).film;
  EXPECT_EQ(crop.resolve(Aov::samples), whole.cut(*settings.crop).resolve(Aov::samples));
  const std::vector<float> samples = whole.resolve(Aov::samples);
  EXPECT_NE(std::count(samples.begin(), samples.end(), samples[0]), static_cast<ptrdiff_t>(samples.size()));
}

TEST(LightPathRender, PartsOfTheLightSumToTheBeautyWhichIsUnchanged) {
  const auto world = glass_world(accel::Kind::kdtree);
  for (const float clamp : {kInfinity, 0.5f}) {
    RenderSettings settings = glass_settings();
    settings.integrator.clamp_indirect = clamp;
    const Film plain = rendered(*world, settings).film;
    divide_light(settings);
    const Film film = rendered(*world, settings).film;
    expect_sums_to_beauty(film, "light groups");
    expect_sums_to_beauty(film, "light passes");
    expect_sums_to_splats(film, "splat groups");
    expect_sums_to_splats(film, "splat passes");
    expect_same_plane(film, plain, "beauty");
    expect_same_plane(film, plain, "splats");
    EXPECT_EQ(film.resolve(Aov::beauty), plain.resolve(Aov::beauty));
  }
}

// The groups and passes of images with and without light paths have one mean.
TEST(LightPathRender, BringLightToTheGroupAndPassThatCameraPathsDo) {
  expect_same_parts([](RenderSettings& settings) { settings.integrator.light_paths = 1.0f; }, 0.0);
}

// Without a clamp a mirror doubles the light of a sun without a size, which light paths alone find.
TEST(LightPathRender, SplatsAreClampedLikeSamples) {
  const auto world = glass_world(accel::Kind::kdtree);
  const auto light_found = [&](float clamp) {
    RenderSettings settings = glass_settings();
    settings.guiding = Guiding::off;
    settings.integrator.clamp_indirect = clamp;
    settings.filter = PixelFilter({FilterKind::box});
    const Film film = rendered(*world, settings).film;
    const auto plane = plane_bytes_of(film, "splats");
    std::vector<double> sums;
    const std::span splats(reinterpret_cast<const SplatSum*>(plane.data()), plane.size() / sizeof(SplatSum));
    for (const SplatSum& splat : splats) sums.push_back(splat.rgb[0].value());
    return sums;
  };
  const std::vector<double> full = light_found(kInfinity), high = light_found(1e6f), low = light_found(0.5f),
                            none = light_found(0.0f);
  EXPECT_EQ(full, high);
  double all = 0.0, rest = 0.0;
  for (size_t i = 0; i < full.size(); ++i) {
    EXPECT_LE(low[i], full[i]);
    EXPECT_EQ(none[i], 0.0);
    all += full[i];
    rest += low[i];
  }
  EXPECT_LT(rest, 0.9 * all);
  EXPECT_GT(rest, 0.1 * all);
}

TEST(LightPathRender, CutsKeepTheirLight) {
  const auto world = glass_world(accel::Kind::kdtree);
  const Film whole = rendered(*world, glass_settings()).film;
  const PixelRect crop{V2i(11, 6), V2i(33, 29)};
  expect_same_bits(whole.cut(crop), whole, "a cut");
}

TEST_F(AccumulationFolder, LightPathsAreStored) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = glass_settings();
  divide_light(settings);
  RenderState state{rendered(*world, settings).film, Coverage({V2i(0), kSize}), {}, {}};
  for (size_t block = 0; block < state.coverage.block_count(); ++block) EXPECT_TRUE(state.coverage.add(block, {0, 9}));
  ASSERT_TRUE(write_accumulation(path_, identity_of(kSize, {V2i(0), kSize}), state, false));
  const Result<Accumulation> read = read_accumulation(path_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  expect_same_bits(read.value().state.film, state.film, "a file");
}

TEST_F(AccumulationFolder, LightOfOtherPartsIsStored) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = glass_settings();
  divide_light(settings);
  settings.region = PixelRect{V2i(8, 8), V2i(24, 16)};
  RenderState state{rendered(*world, settings).film, Coverage(*settings.region), {}, {}};
  state.work.light_paths = 0.125f;
  ASSERT_TRUE(write_accumulation(path_, identity_of(kSize, {V2i(0), kSize}), state, false));
  const Result<Accumulation> read = read_accumulation(path_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().state.film.splat_area(), (PixelRect{V2i(0), kSize}));
  EXPECT_EQ(read.value().state.work.light_paths, 0.125f);
  expect_same(read.value().state, state);
}

TEST(LightPathRender, RefusesOtherLightSums) {
  const auto refusal = [](const std::function<void(RenderSettings&)>& change) {
    RenderSettings settings = glass_settings();
    change(settings);
    const Result<void> checked = check_settings(settings, glass_camera(kSize));
    return checked.ok() ? std::string() : checked.error().message;
  };
  EXPECT_EQ(refusal([](RenderSettings&) {}), "");
  EXPECT_EQ(refusal([](RenderSettings& s) { s.device = DeviceKind::host; }), "");
  const auto expect_refused = [&](const char* words, const std::function<void(RenderSettings&)>& change) {
    EXPECT_NE(refusal(change).find(words), std::string::npos) << words << ": " << refusal(change);
  };
  expect_refused("with --integrator whitted", [](auto& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_refused("with --caustics off", [](auto& s) { s.integrator.caustics = Caustics::off; });
  expect_refused("with --outliers trim", [](auto& s) { s.outliers = Outliers::trim; });
  const auto world = glass_world(accel::Kind::kdtree);
  const std::shared_ptr<const ShadowCatchers> catchers =
      ShadowCatchers::make(*world, {{1, 0, 0, 0, 0}, {}}, {}, nullptr);
  expect_refused("with --shadow-catcher", [&](auto& s) {
    s.aovs.insert(Aov::shadow_catcher);
    s.catchers = catchers;
  });
  expect_refused("a fraction from 0 to 1", [](auto& s) { s.integrator.light_paths = 1.5f; });
}

} // namespace
} // namespace kindling::test
