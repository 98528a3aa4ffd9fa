// Refusals of renders with photons, and their passes. The split cases compare their bits.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/check_settings.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/parts_of_light.h"

#include <functional>

namespace kindling::test {
namespace {

constexpr V2i kPhotonSize(40, 30);

std::string refusal(const std::function<void(RenderSettings&)>& change,
                    const Camera& camera = glass_camera(kPhotonSize)) {
  RenderSettings settings = small_render(kPhotonSize, 9);
  settings.integrator.photons = 0.5f;
  change(settings);
  const Result<void> checked = check_settings(settings, camera);
  return checked.ok() ? std::string() : checked.error().message;
}

TEST(PhotonRender, RefusesOtherTracersAndPasses) {
  EXPECT_EQ(refusal([](RenderSettings&) {}), "");
  EXPECT_EQ(refusal([](auto& s) { s.integrator.clamp_indirect = 2.0f; }), "");
  EXPECT_EQ(refusal([](auto& s) { s.integrator.light_paths = 0.5f; }), "");
  EXPECT_EQ(refusal([](auto& s) { divide_light(s); }), "");
  EXPECT_EQ(refusal([](auto& s) { s.sample_rates = SampleRateKind::noise; }), "");
  EXPECT_EQ(refusal([](auto& s) { s.device = DeviceKind::host; }), "");
  EXPECT_EQ(refusal([](auto& s) { s.integrator.direct_samples = 4, s.integrator.reflection_samples = 2; }), "");
  const auto expect_refused = [](const char* words, const std::function<void(RenderSettings&)>& change) {
    EXPECT_NE(refusal(change).find(words), std::string::npos) << words << ": " << refusal(change);
  };
  expect_refused("with --integrator whitted; use path", [](auto& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_refused("with --caustics off", [](auto& s) { s.integrator.caustics = Caustics::off; });
  expect_refused("photons 1.5", [](auto& s) { s.integrator.photons = 1.5f; });
  expect_refused("photons nan", [](auto& s) { s.integrator.photons = std::numeric_limits<float>::quiet_NaN(); });
  const Camera moving({}, look_at(V3f(0, 4, 7), V3f(0.0f)), kPhotonSize, CameraMotion{.shutter_open = true});
  EXPECT_EQ(refusal([](RenderSettings&) {}, moving), "");
}

TEST(PhotonRender, PartsOfTheLightSumToTheBeautyWhichIsUnchanged) {
  const auto world = glass_world(accel::Kind::kdtree);
  for (const float clamp : {kInfinity, 0.5f})
    for (const float light_paths : {0.0f, 0.5f}) {
      RenderSettings settings = small_render(kPhotonSize, 9);
      settings.integrator.photons = 1.0f;
      settings.integrator.light_paths = light_paths;
      settings.integrator.clamp_indirect = clamp;
      const auto film_of = [&] {
        Result<RenderOutcome> outcome = render(*world, glass_camera(kPhotonSize), settings, nullptr, nullptr);
        EXPECT_TRUE(outcome.ok());
        return std::move(outcome).value().film;
      };
      const Film plain = film_of();
      divide_light(settings);
      const Film film = film_of();
      expect_sums_to_beauty(film, "light groups");
      expect_sums_to_beauty(film, "light passes");
      expect_same_plane(film, plain, "beauty");
    }
}

// Photons near the ends of surfaces are missing beyond them: at most a hundredth of the leaf's.
TEST(PhotonRender, BringLightToTheGroupAndPassThatCameraPathsDo) {
  expect_same_parts([](RenderSettings& settings) { settings.integrator.photons = 1.0f; }, 0.01);
}

// Passes are short, so that few maps are in memory.
TEST(PhotonRender, LimitsPasses) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = small_render(kPhotonSize, 128);
  const auto passes = [&] {
    const Result<RenderOutcome> outcome = render(*world, glass_camera(kPhotonSize), settings, nullptr, nullptr);
    EXPECT_TRUE(outcome.ok());
    return outcome.ok() ? outcome.value().statistics : RenderStatistics{};
  };
  EXPECT_EQ(passes().rays.photon, 0U);
  settings.integrator.photons = 1.0f;
  const RenderStatistics with = passes();
  EXPECT_GE(with.passes, 4); // of 32 samples: two maps, each for 16
  EXPECT_GT(with.rays.photon, 0U);
}

} // namespace
} // namespace kindling::test
