// The same image of a moving scene, bit for bit, however it is cut into work.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/motion_scenes.h"
#include "tests/session/different_pixels.h"

#include <cstring>

namespace kindling::test {
namespace {

const V2i kSize(43, 29); // not a multiple of anything

// A turning ball, a second one of the same mesh that stands still, a lamp that swings, a bending strip, and a moving veil.
std::unique_ptr<const World> moving_world(accel::Kind kind) {
  Scene scene = ball_lamp_and_veil(0.3f);
  Node copy = scene.nodes[0];
  copy.local.translation = V3f(-2.2f, 0, 0.3f);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(copy);
  animate_turn(scene, 0, V3f(0, 0.6f, 0.8f), 90.0f);
  animate(scene, 2, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 1, 0.3f, 0});
  animate(scene, 3, AnimatedProperty::translation, {0, 1}, {0, 0, 0, -0.5f, 0, 0});
  Node bent;
  bent.mesh = static_cast<int>(scene.meshes.size());
  scene.meshes.push_back({.primitives = {jointed_strip(8, 1)}});
  const auto strip = static_cast<int>(scene.nodes.size());
  scene.scenes[0].nodes.push_back(strip);
  scene.nodes.push_back(bent);
  add_bending_skin(scene, strip, V3f(0.6f, 0, 0.8f), 80.0f);
  return make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, kind,
                          std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
}

Film render_film(const World& world, const RenderSettings& settings) {
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize,
                      CameraMotion{.shutter_open = world.has_motion()});
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value().film;
}

class MovingDeterminism : public testing::TestWithParam<accel::Kind> {};

TEST_P(MovingDeterminism, ThreadsTilesBatchesAndCrops) {
  const auto world = moving_world(GetParam());
  RenderSettings settings = small_render(kSize, 7);
  settings.integrator.roulette_start_bounce = 2;
  for (const AovInfo& info : kAovs) settings.aovs.insert(info.aov);
  settings.threads = 1;
  const Film reference = render_film(*world, settings);
  struct Variation {
    int threads;
    int tile_size_px;
    uint32_t batch_size;
    PixelRect crop;
  };
  const PixelRect all{V2i(0, 0), kSize}, part{V2i(13, 9), V2i(37, 26)};
  for (const Variation& v : {Variation{3, 8, 64, all}, Variation{2, 64, 512, all}, Variation{2, 8, 128, part}}) {
    settings.threads = v.threads;
    settings.tile_size_px = v.tile_size_px;
    settings.integrator.batch_size = v.batch_size;
    settings.crop = v.crop;
    const Film film = render_film(*world, settings);
    for (const AovInfo& info : kAovs) {
      const std::vector<float> found = film.resolve(info.aov), whole = reference.resolve(info.aov);
      const auto channels = static_cast<size_t>(info.channels), row = static_cast<size_t>(v.crop.width()) * channels;
      for (int y = v.crop.min.y; y < v.crop.max.y; ++y)
        ASSERT_EQ(std::memcmp(&found[static_cast<size_t>(y - v.crop.min.y) * row],
                              &whole[static_cast<size_t>(y * kSize.x + v.crop.min.x) * channels], row * sizeof(float)),
                  0)
            << info.name << " differs in row " << y << " with " << v.threads << " threads, tiles of " << v.tile_size_px
            << ", batches of " << v.batch_size;
    }
  }
}

TEST_P(MovingDeterminism, ReplayGivesTheSameSample) {
  const auto world = moving_world(GetParam());
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize, CameraMotion{.shutter_open = true});
  RenderSettings settings = small_render(kSize, 1);
  settings.aovs = AovSet{};
  const std::vector<float> beauty = render_film(*world, settings).resolve(Aov::beauty);
  for (const V2i& pixel : {V2i(21, 14), V2i(12, 13), V2i(30, 18)}) {
    const Result<ReplayedSample> replayed = replay_sample(*world, camera, settings, pixel, 0);
    ASSERT_TRUE(replayed.ok());
    const float* expected = &beauty[static_cast<size_t>(pixel.y * kSize.x + pixel.x) * 3];
    for (int c = 0; c < 3; ++c) EXPECT_EQ(replayed.value().radiance[c], expected[c]);
  }
}

INSTANTIATE_TEST_SUITE_P(Accelerators, MovingDeterminism, testing::Values(accel::Kind::embree, accel::Kind::kdtree),
                         [](const auto& param) { return std::string(accel::kind_name(param.param)); });

// The accelerators see the same scene at the same time: pictures differ by rounding only.
TEST(MovingAccelerators, AgreeOnThePicture) {
  RenderSettings settings = small_render(kSize, 8);
  const std::vector<float> oracle = render_film(*moving_world(accel::Kind::brute_force), settings).resolve_rgba();
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree}) {
    const std::vector<float> picture = render_film(*moving_world(kind), settings).resolve_rgba();
    // A path whose hit moves by rounding may take another branch at an edge: rare.
    EXPECT_LE(different_pixels(picture, oracle), oracle.size() / 4 / 50) << accel::kind_name(kind);
  }
}

} // namespace
} // namespace kindling::test
