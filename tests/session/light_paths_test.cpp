// Light paths give the same bits however the samples are divided, and refuse what they cannot do.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/check_settings.h"
#include "tests/integrator/test_scenes.h"
#include "tests/session/same_bits.h"
#include "tests/session/test_accumulation.h"

#include <functional>

namespace kindling::test {
namespace {

constexpr V2i kSize(40, 30);

std::unique_ptr<const World> glass_world() {
  Material glass = diffuse_material(Rgb(1.0f));
  glass.roughness_factor = 0.1f;
  glass.specular_factor = 1.0f;
  glass.transmission_factor = glass.thickness_factor = 1.0f;
  return make_world(
      make_scene({diffuse_material(Rgb(0.7f)), glass, emissive_material(Rgb(30.0f))},
                 {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 32, 1),
                  quad(V3f(-0.5f, 5, -0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 2)}),
      accel::Kind::kdtree);
}

Camera glass_camera() {
  SceneCamera camera;
  camera.yfov_rad = 0.6f;
  return {camera, look_at(V3f(0, 4, 7), V3f(0, 0.3f, 0)), kSize};
}

RenderSettings glass_settings() {
  RenderSettings settings = small_render(kSize, 9);
  settings.integrator.light_paths = 0.4f;
  return settings;
}

RenderOutcome rendered(const World& world, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, glass_camera(), settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << outcome.error().message;
  return std::move(outcome).value();
}

TEST(LightPathRender, KeepsItsBitsWithAnyThreadsTilesAndPartsOfTheSamples) {
  const auto world = glass_world();
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

TEST(LightPathRender, CutsKeepTheirLight) {
  const auto world = glass_world();
  const Film whole = rendered(*world, glass_settings()).film;
  const PixelRect crop{V2i(11, 6), V2i(33, 29)};
  expect_same_bits(whole.cut(crop), whole, "a cut");
}

TEST_F(AccumulationFolder, LightPathsAreStored) {
  const auto world = glass_world();
  RenderState state{rendered(*world, glass_settings()).film, Coverage({V2i(0), kSize}), {}, {}};
  for (size_t block = 0; block < state.coverage.block_count(); ++block) EXPECT_TRUE(state.coverage.add(block, {0, 9}));
  ASSERT_TRUE(write_accumulation(path_, identity_of(kSize, {V2i(0), kSize}), state, false));
  const Result<Accumulation> read = read_accumulation(path_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  expect_same_bits(read.value().state.film, state.film, "a file");
}

TEST(LightPathRender, RefusesOtherLightSums) {
  const auto refusal = [](const std::function<void(RenderSettings&)>& change, const Camera& camera = glass_camera()) {
    RenderSettings settings = glass_settings();
    change(settings);
    const Result<void> checked = check_settings(settings, camera);
    return checked.ok() ? std::string() : checked.error().message;
  };
  EXPECT_EQ(refusal([](RenderSettings&) {}), "");
  const auto expect_refused = [&](const char* words, const std::function<void(RenderSettings&)>& change) {
    EXPECT_NE(refusal(change).find(words), std::string::npos) << words << ": " << refusal(change);
  };
  expect_refused("--light-paths: not on the device 'host'", [](auto& s) { s.device = DeviceKind::host; });
  expect_refused("with --integrator whitted", [](auto& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_refused("with --caustics off", [](auto& s) { s.integrator.caustics = Caustics::off; });
  expect_refused("with --clamp-direct", [](auto& s) { s.integrator.clamp_indirect = 1.0f; });
  expect_refused("with --outliers trim", [](auto& s) { s.outliers = Outliers::trim; });
  expect_refused("with --light-groups", [](auto& s) { s.integrator.light_groups = LightGrouping::kind; });
  expect_refused("with --aov indirect", [](auto& s) { s.aovs.insert(Aov::indirect); });
  expect_refused("with --aov glossy_direct", [](auto& s) { s.aovs.insert(Aov::glossy_direct); });
  expect_refused("in parts of the image", [](auto& s) { s.region = PixelRect{V2i(0), V2i(8, 30)}; });
  expect_refused("a fraction from 0 to 1", [](auto& s) { s.integrator.light_paths = 1.5f; });
  const Camera moving({}, look_at(V3f(0, 4, 7), V3f(0.0f)), kSize, CameraMotion{.shutter_open = true});
  EXPECT_NE(refusal([](RenderSettings&) {}, moving).find("with motion blur"), std::string::npos);
}

} // namespace
} // namespace kindling::test
