// Renders with a time limit: pixels of whole samples, guides that can be trained again.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/train_guide.h"
#include "tests/integrator/test_scenes.h"

#include <cstring>
#include <map>

namespace kindling::test {
namespace {

const V2i kLitRoomSize(75, 53); // not a multiple of anything

// A white room lit by a lamp that shines at the ceiling, which is therefore worth a guide.
std::unique_ptr<const World> lit_room() {
  Material lamp = emissive_material(Rgb(30.0f), Rgb(0.5f));
  lamp.double_sided = false;
  return make_world(make_scene({diffuse_material(Rgb(0.6f)), lamp},
                               {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0),
                                quad(V3f(-2, 2, -2), V3f(4, 0, 0), V3f(0, 0, 4), 0),
                                quad(V3f(-2, 0, -2), V3f(4, 0, 0), V3f(0, 2, 0), 0),
                                quad(V3f(0.6f, 1.9f, 0.4f), V3f(0.5f, 0, 0), V3f(0, 0, -0.5f), 1)}),
                    accel::Kind::embree);
}

Camera lit_room_camera() {
  return {SceneCamera{}, look_at(V3f(-1.7f, 0.9f, 1.7f), V3f(0.3f, 0.6f, -0.3f)), kLitRoomSize};
}

RenderSettings timed_render(double time_limit_s, Guiding guiding) {
  RenderSettings settings = small_render(kLitRoomSize, 1U << 20);
  settings.guiding = guiding;
  settings.time_limit_s = time_limit_s;
  settings.aovs.insert(Aov::samples);
  return settings;
}

RenderOutcome render_lit_room(const World& world, const RenderSettings& settings, RenderContinuity continuity = {}) {
  Result<RenderOutcome> outcome = render(world, lit_room_camera(), settings, nullptr, nullptr, std::move(continuity));
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  return std::move(outcome).value();
}

// Each pixel of `film` is that of a render without a limit of as many samples as the pixel has.
// Returns the numbers of samples.
std::vector<uint32_t> expect_whole_samples(const World& world, const Film& film, RenderSettings settings) {
  const std::vector<float> samples = film.resolve(Aov::samples), rgba = film.resolve_rgba();
  std::map<uint32_t, std::vector<size_t>> pixels;
  for (size_t i = 0; i < samples.size(); ++i) pixels[static_cast<uint32_t>(samples[i])].push_back(i);
  settings.planned_samples = settings.planned();
  settings.time_limit_s.reset();
  std::vector<uint32_t> counts;
  for (const auto& [count, of_count] : pixels) {
    EXPECT_GT(count, 0U);
    counts.push_back(count);
    settings.samples_per_pixel = count;
    const std::vector<float> whole = render_lit_room(world, settings).film.resolve_rgba();
    for (const size_t i : of_count)
      if (std::memcmp(&rgba[4 * i], &whole[4 * i], 4 * sizeof(float)) != 0) {
        ADD_FAILURE() << "pixel " << i << " with " << count << " samples";
        break;
      }
  }
  return counts;
}

TEST(TimeLimit, EndsBetweenBlocksOfWholeSamples) {
  const auto world = lit_room();
  const RenderSettings settings = timed_render(0.2, Guiding::off);
  const RenderOutcome outcome = render_lit_room(*world, settings);
  EXPECT_FALSE(outcome.interrupted);
  EXPECT_GE(outcome.statistics.render_s, 0.2);
  const std::vector<uint32_t> counts = expect_whole_samples(*world, outcome.film, settings);
  ASSERT_FALSE(counts.empty());
  EXPECT_EQ(outcome.statistics.samples_per_pixel, counts.front());
  EXPECT_LE(counts.size(), 4U); // passes are short at the end
}

TEST(TimeLimit, IsOverAtOnceWithOneSample) {
  const auto world = lit_room();
  const RenderSettings settings = timed_render(1e-9, Guiding::automatic);
  const RenderOutcome outcome = render_lit_room(*world, settings);
  EXPECT_EQ(outcome.statistics.guiding.max_paths, 0U);
  EXPECT_GE(outcome.statistics.samples_per_pixel, 1U);
  EXPECT_LE(outcome.statistics.passes, 2);
}

TEST(TimeLimit, TrainsAGuideThatAnotherRenderCanTrainAgain) {
  const auto world = lit_room();
  RenderSettings settings;
  std::optional<RenderState> saved;
  const auto render_for = [&](double limit_s) {
    settings = timed_render(limit_s, Guiding::on);
    return render_lit_room(*world, settings, {.save = [&](const RenderState& state) { saved = state; }});
  };
  RenderOutcome outcome = render_for(1.5);
  // A busy machine has time for too few paths.
  for (double limit_s = 6.0; limit_s < 100.0 && outcome.statistics.guiding.patches == 0; limit_s *= 4.0)
    outcome = render_for(limit_s);
  ASSERT_TRUE(outcome.work.training_paths);
  const uint64_t paths = *outcome.work.training_paths;
  EXPECT_EQ(paths, outcome.statistics.guiding.max_paths);
  EXPECT_LE(paths, training_paths(settings));
  EXPECT_GT(outcome.statistics.guiding.patches, 0) << "no guide, so nothing is tested";
  settings.training_paths = paths;
  expect_whole_samples(*world, outcome.film, settings);

  // A resumed render trains the same guide, whatever its own limit.
  ASSERT_TRUE(saved);
  settings.training_paths.reset();
  settings.time_limit_s = 1e-3;
  settings.planned_samples = settings.planned();
  settings.samples_per_pixel = outcome.statistics.samples_per_pixel + 8;
  const RenderOutcome resumed = render_lit_room(*world, settings, {.resume_from = std::move(saved)});
  EXPECT_EQ(resumed.statistics.guiding.max_paths, paths);
}

TEST(TimeLimit, TrainingTakesATenthOfIt) {
  RenderSettings settings = timed_render(8.0, Guiding::automatic);
  EXPECT_DOUBLE_EQ(max_training_s(settings).value_or(0.0), 0.8);
  settings.training_paths = 4096;
  EXPECT_FALSE(max_training_s(settings));
  EXPECT_EQ(training_paths(settings), 4096U);
  settings.training_paths.reset();
  settings.time_limit_s.reset();
  EXPECT_FALSE(max_training_s(settings));
}

TEST(TimeLimit, NoPathsTrainNoGuide) {
  const auto world = lit_room();
  RenderSettings settings = timed_render(0.01, Guiding::on);
  settings.training_paths = 0;
  const RenderOutcome outcome = render_lit_room(*world, settings);
  EXPECT_EQ(outcome.statistics.guiding.patches, 0);
  EXPECT_FALSE(outcome.work.training_paths);
}

} // namespace
} // namespace kindling::test
