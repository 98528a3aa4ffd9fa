// Trained guides: independent of the division of work, unbiased, dropped if useless.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/train_guide.h"
#include "tests/integrator/test_scenes.h"

#include <cstring>
#include <memory>
#include <utility>
#include <vector>

namespace kindling::test {
namespace {

const V2i kRoomSize(75, 53); // not a multiple of anything

// A white room lit by a lamp that shines at the ceiling from just below it: the room is lit by the
// ceiling.
std::unique_ptr<const World> room() {
  Material lamp = emissive_material(Rgb(30.0f), Rgb(0.5f));
  lamp.double_sided = false;
  return make_world(
      make_scene(
          {diffuse_material(Rgb(0.6f)), lamp},
          {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0), quad(V3f(-2, 2, -2), V3f(4, 0, 0), V3f(0, 0, 4), 0),
           quad(V3f(-2, 0, -2), V3f(4, 0, 0), V3f(0, 2, 0), 0), quad(V3f(2, 0, 2), V3f(-4, 0, 0), V3f(0, 2, 0), 0),
           quad(V3f(-2, 0, 2), V3f(0, 0, -4), V3f(0, 2, 0), 0), quad(V3f(2, 0, -2), V3f(0, 0, 4), V3f(0, 2, 0), 0),
           quad(V3f(0.6f, 1.9f, 0.4f), V3f(0.5f, 0, 0), V3f(0, 0, -0.5f), 1)}),
      accel::Kind::embree);
}

Camera room_camera() { return {SceneCamera{}, look_at(V3f(-1.7f, 0.9f, 1.7f), V3f(0.3f, 0.6f, -0.3f)), kRoomSize}; }

RenderSettings room_render(uint32_t spp, Guiding guiding) {
  RenderSettings settings = small_render(kRoomSize, spp);
  settings.integrator.roulette_start_bounce = 2;
  settings.guiding = guiding;
  return settings;
}

Film render_room(const World& world, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, room_camera(), settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  EXPECT_GT(outcome.value().statistics.guiding.patches, 0);
  return std::move(outcome).value().film;
}

TEST(TrainGuide, SameBitsForThreadsTilesBatchesAndCrops) {
  const auto world = room();
  RenderSettings settings = room_render(32, Guiding::on);
  settings.threads = 1;
  const std::vector<float> reference = render_room(*world, settings).resolve_rgba();
  const auto differs = [&](const RenderSettings& other) {
    const std::vector<float> image = render_room(*world, other).resolve_rgba();
    return image.size() != reference.size() ||
           std::memcmp(image.data(), reference.data(), image.size() * sizeof(float)) != 0;
  };
  for (const int threads : {2, 7}) {
    settings.threads = threads;
    EXPECT_FALSE(differs(settings)) << threads << " threads";
  }
  settings.tile_size_px = 8;
  EXPECT_FALSE(differs(settings)) << "tiles";
  settings.integrator.batch_size = 64;
  EXPECT_FALSE(differs(settings)) << "batches";
  settings.crop = PixelRect{V2i(13, 9), V2i(50, 41)};
  const std::vector<float> crop = render_room(*world, settings).resolve_rgba();
  const auto width = static_cast<size_t>(settings.crop->width());
  for (int y = 9; y < 41; ++y)
    ASSERT_EQ(std::memcmp(crop.data() + static_cast<size_t>(y - 9) * width * 4,
                          reference.data() + (static_cast<size_t>(y) * static_cast<size_t>(kRoomSize.x) + 13) * 4,
                          width * 4 * sizeof(float)),
              0)
        << "row " << y;
  const Result<ReplayedSample> replayed = replay_sample(*world, room_camera(), settings, V2i(20, 20), 3);
  ASSERT_TRUE(replayed.ok());
  // The guide that the render hands out gives the same sample.
  std::vector<LearnedPaths> guides;
  RenderContinuity continuity;
  continuity.after_training = [&](const LearnedPaths& learned) { guides.push_back(learned); };
  ASSERT_TRUE(render(*world, room_camera(), settings, nullptr, nullptr, std::move(continuity)).ok());
  ASSERT_EQ(guides.size(), 1U);
  ASSERT_TRUE(guides[0].guide);
  const Result<ReplayedSample> again = replay_sample(*world, room_camera(), settings, guides[0], V2i(20, 20), 3);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value().radiance, replayed.value().radiance);
  settings = room_render(32, Guiding::off);
  const Result<ReplayedSample> unguided = replay_sample(*world, room_camera(), settings, V2i(20, 20), 3);
  ASSERT_TRUE(unguided.ok());
  EXPECT_NE(replayed.value().radiance, unguided.value().radiance);
}

// Returns the mean over the pixels of variance over squared luminance, which guiding reduces.
double relative_variance(const Film& film) {
  const std::vector<float> beauty = film.resolve(Aov::beauty);
  const std::vector<float> variance = film.resolve(Aov::variance);
  const double floor = 0.01 * std::pow(mean_of(film).luminance, 2.0);
  double sum = 0.0;
  for (size_t i = 0; i < variance.size(); ++i) {
    const double mean = static_cast<double>(luminance(Rgb(beauty[i * 3], beauty[i * 3 + 1], beauty[i * 3 + 2])));
    sum += static_cast<double>(variance[i]) / (mean * mean + floor);
  }
  return sum / static_cast<double>(variance.size());
}

// Expects the mean of a render without a guide, and less than `largest` of its relative variance.
void expect_less_noise(const World& world, uint32_t spp, Guiding guiding, double largest) {
  RenderSettings settings = room_render(spp, Guiding::off);
  const Film plain = render(world, room_camera(), settings, nullptr, nullptr).value().film;
  settings.guiding = guiding;
  settings.seed = 1;
  const Film guided = render_room(world, settings);
  const Mean without = mean_of(plain), with = mean_of(guided);
  EXPECT_NEAR(with.luminance, without.luminance, 4.5 * std::hypot(with.standard_error, without.standard_error));
  EXPECT_LT(relative_variance(guided), largest * relative_variance(plain));
}

TEST(TrainGuide, ReducesNoiseAndKeepsMean) { expect_less_noise(*room(), 64, Guiding::on, 0.8); }

// The same room without a lamp, with a window in one wall, under a sky and beside a large yard.
std::unique_ptr<const World> room_with_window() {
  return make_world(
      make_scene(
          {diffuse_material(Rgb(0.6f))},
          {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0), quad(V3f(-2, 2, -2), V3f(4, 0, 0), V3f(0, 0, 4), 0),
           quad(V3f(-2, 0, -2), V3f(4, 0, 0), V3f(0, 2, 0), 0), quad(V3f(2, 0, 2), V3f(-4, 0, 0), V3f(0, 2, 0), 0),
           quad(V3f(-2, 0, 2), V3f(0, 0, -4), V3f(0, 2, 0), 0), quad(V3f(2, 0, -2), V3f(0, 0, 4), V3f(0, 0.8f, 0), 0),
           quad(V3f(2, 1.6f, -2), V3f(0, 0, 4), V3f(0, 0.4f, 0), 0),
           quad(V3f(2, 0.8f, -2), V3f(0, 0, 1.5f), V3f(0, 0.8f, 0), 0),
           quad(V3f(2, 0.8f, 1), V3f(0, 0, 1), V3f(0, 0.8f, 0), 0),
           quad(V3f(-20, -0.1f, 20), V3f(40, 0, 0), V3f(0, 0, -40), 0)}),
      accel::Kind::embree, std::make_shared<Environment>(Rgb(1.0f)));
}

TEST(TrainGuide, AimsAtWindows) { expect_less_noise(*room_with_window(), 128, Guiding::automatic, 0.5); }

// In the open there is nothing to aim at.
std::unique_ptr<const World> sphere_in_the_open() {
  return make_world(make_scene({diffuse_material(Rgb(0.6f))}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                                               sphere(V3f(0, 1, 0), 1.0f, 32, 0)}),
                    accel::Kind::embree, std::make_shared<Environment>(Rgb(1.0f)));
}

TEST(TrainGuide, AutoStopsAfterTheProbe) {
  const auto world = sphere_in_the_open();
  RenderSettings settings = room_render(32, Guiding::automatic);
  const Result<RenderOutcome> outcome = render(*world, room_camera(), settings, nullptr, nullptr);
  ASSERT_TRUE(outcome.ok());
  const GuidingStatistics& guiding = outcome.value().statistics.guiding;
  EXPECT_EQ(guiding.patches, 0);
  EXPECT_GT(guiding.paths, 0U);
  EXPECT_LT(guiding.paths, training_paths(settings) / 4);
  settings.guiding = Guiding::off;
  EXPECT_EQ(training_paths(settings), 0U);
  const Result<RenderOutcome> plain = render(*world, room_camera(), settings, nullptr, nullptr);
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain.value().statistics.guiding.paths, 0U);
  EXPECT_EQ(plain.value().film.resolve_rgba(), outcome.value().film.resolve_rgba());
}

// A probe of few paths promises a little for some seeds. Twice the paths show that it is nothing,
// or promise it again; then the training goes to its end.
TEST(TrainGuide, AutoTracesASecondProbeIfTheFirstIsUnclear) {
  const auto world = sphere_in_the_open();
  int one_probe = 0, two_probes = 0, whole = 0;
  for (uint32_t seed = 0; seed < 12; ++seed) {
    RenderSettings settings = room_render(32, Guiding::automatic);
    settings.seed = seed;
    const Result<RenderOutcome> outcome = render(*world, room_camera(), settings, nullptr, nullptr);
    ASSERT_TRUE(outcome.ok());
    const GuidingStatistics& guiding = outcome.value().statistics.guiding;
    EXPECT_EQ(guiding.patches, 0);
    const double part = static_cast<double>(guiding.paths) / static_cast<double>(training_paths(settings));
    ++(part < 0.15 ? one_probe : part < 0.3 ? two_probes : whole); // about 1/8, 2/8 and all, less cut-off blocks
  }
  EXPECT_GT(one_probe, 0);
  EXPECT_GT(two_probes, 0);
  EXPECT_GT(whole, 0);
}

} // namespace
} // namespace kindling::test
