// Images of a moving scene have the same bits for any division of the work.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/different_pixels.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

namespace kindling::test {
namespace {

const V2i kMovingSize(43, 29); // not a multiple of anything

Film render_moving(const World& world, const RenderSettings& settings) {
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kMovingSize,
                      CameraMotion{.shutter_open = world.has_motion});
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value().film;
}

class MovingDeterminism : public testing::TestWithParam<accel::Kind> {};

TEST_P(MovingDeterminism, SameBitsForThreadsTilesBatchesAndCrops) {
  const auto world = moving_world(GetParam());
  RenderSettings settings = small_render(kMovingSize, 7);
  settings.integrator.roulette_start_bounce = 2;
  add_aovs_of_camera(settings);
  add_mattes(settings);
  settings.threads = 1;
  const Film reference = render_moving(*world, settings);
  struct Variation {
    int threads;
    int tile_size_px;
    uint32_t batch_size;
    PixelRect crop;
  };
  const PixelRect all{V2i(0, 0), kMovingSize}, part{V2i(13, 9), V2i(37, 26)};
  for (const Variation& v : {Variation{3, 8, 64, all}, Variation{2, 64, 512, all}, Variation{2, 8, 128, part}}) {
    settings.threads = v.threads;
    settings.tile_size_px = v.tile_size_px;
    settings.integrator.batch_size = v.batch_size;
    settings.crop = v.crop;
    expect_same_bits(render_moving(*world, settings), reference,
                     std::to_string(v.threads) + " threads, tiles of " + std::to_string(v.tile_size_px) +
                         ", batches of " + std::to_string(v.batch_size));
  }
}

TEST_P(MovingDeterminism, ReplayReproducesSample) {
  const auto world = moving_world(GetParam());
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kMovingSize,
                      CameraMotion{.shutter_open = true});
  RenderSettings settings = small_render(kMovingSize, 1);
  settings.aovs = AovSet{};
  const std::vector<float> beauty = render_moving(*world, settings).resolve(Aov::beauty);
  for (const V2i& pixel : {V2i(21, 14), V2i(12, 13), V2i(30, 18)}) {
    const Result<ReplayedSample> replayed = replay_sample(*world, camera, settings, pixel, 0);
    ASSERT_TRUE(replayed.ok());
    const float* expected = &beauty[static_cast<size_t>(pixel.y * kMovingSize.x + pixel.x) * 3];
    for (int c = 0; c < 3; ++c) EXPECT_EQ(replayed.value().radiance[c], expected[c]);
  }
}

INSTANTIATE_TEST_SUITE_P(Accelerators, MovingDeterminism, testing::Values(accel::Kind::embree, accel::Kind::kdtree),
                         [](const auto& param) { return std::string(accel::kind_name(param.param)); });

// Images of two accelerators differ by rounding only.
TEST(MovingAccelerators, RenderSameImage) {
  RenderSettings settings = small_render(kMovingSize, 8);
  const std::vector<float> oracle = render_moving(*moving_world(accel::Kind::brute_force), settings).resolve_rgba();
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree}) {
    const std::vector<float> image = render_moving(*moving_world(kind), settings).resolve_rgba();
    // A path whose hit moves by rounding may take another branch at an edge: rare.
    EXPECT_LE(different_pixels(image, oracle), oracle.size() / 4 / 50) << accel::kind_name(kind);
  }
}

} // namespace
} // namespace kindling::test
