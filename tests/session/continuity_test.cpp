// A render that is interrupted and resumed many times equals the uninterrupted one, bit for bit.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/split_renders.h"

#include <algorithm>

namespace kindling::test {
namespace {

class Continuity : public testing::TestWithParam<SplitCase> {};

// Each run is cancelled after some blocks; the next resumes from a state saved some blocks earlier,
// as after a crash.
TEST_P(Continuity, TwentyInterruptions) {
  const SplitScene scene(GetParam());
  const RenderOutcome undisturbed = scene.render(scene.settings());
  const Film& whole = undisturbed.film;
  if (GetParam().kind == SplitKind::guided) {
    EXPECT_GT(undisturbed.statistics.guiding.patches + undisturbed.statistics.guiding.light_regions, 0);
  }
  const int interruptions = GetParam().kind == SplitKind::guided ? 6 : 20;
  std::mt19937 random(3);
  std::optional<RenderState> saved;
  const auto resume = [&](int cancel_after) {
    RenderSettings settings = scene.settings();
    vary_work(settings, random);
    CancelToken token;
    const int keep_until = cancel_after - static_cast<int>(random() % 3); // saves
    int saves = 0;
    RenderContinuity continuity{.resume_from = saved, .save_every_s = {}, .save = [&](const RenderState& state) {
                                  if (++saves <= keep_until) saved = state;
                                  if (saves == cancel_after) token.cancel();
                                }};
    if (cancel_after < 1000) continuity.save_every_s = 0.0; // after every block in hand
    return scene.render(settings, std::move(continuity), &token);
  };
  for (int i = 0; i < interruptions; ++i) {
    const RenderOutcome outcome = resume(1 + static_cast<int>(random() % 12));
    EXPECT_TRUE(outcome.interrupted) << "nothing left to interrupt at " << i;
  }
  const RenderOutcome last = resume(1000000);
  EXPECT_FALSE(last.interrupted);
  EXPECT_GE(last.work.runs, 2U);
  expect_same_bits(last.film, whole, "interruptions");
  ASSERT_TRUE(saved);
  const SampleRange all{0, scene.settings().samples_per_pixel};
  for (size_t b = 0; b < saved->coverage.block_count(); ++b) EXPECT_TRUE(saved->coverage.complete(b, all)) << b;
  EXPECT_EQ(saved->adaptive.empty(), !scene.settings().adaptive.enabled());
}

TEST_P(Continuity, MoreSamplesLater) {
  const SplitScene scene(GetParam());
  RenderSettings settings = scene.settings();
  settings.planned_samples = settings.planned(); // stays
  const uint32_t fewer = settings.samples_per_pixel, more = fewer * 2 + 3;
  settings.samples_per_pixel = more;
  const Film whole = scene.render(settings).film;
  settings.samples_per_pixel = fewer;
  std::optional<RenderState> saved;
  RenderContinuity continuity{.save = [&](const RenderState& state) { saved = state; }};
  EXPECT_EQ(scene.render(settings, continuity).statistics.saves, 1);
  settings.samples_per_pixel = more;
  settings.tile_size_px = 8;
  const RenderOutcome outcome = scene.render(settings, {.resume_from = std::move(saved)});
  EXPECT_EQ(outcome.statistics.samples_per_pixel, more);
  expect_same_bits(outcome.film, whole, "more samples later");
}

TEST_P(Continuity, Regions) {
  const SplitScene scene(GetParam());
  RenderSettings settings = scene.settings();
  settings.crop = PixelRect{V2i(5, 3), V2i(41, 27)};
  const Film whole = scene.render(settings).film;
  std::mt19937 random(4);
  for (const int count : {1, 3, 8})
    for (const PixelRect& region : make_regions(*settings.crop, count)) {
      settings.region = region;
      vary_work(settings, random);
      const Film part = scene.render(settings).film;
      EXPECT_EQ(part.crop(), region);
      // Light paths of other regions are missing until all are added up.
      if (!scene.has_light_paths()) expect_same_bits(part, whole, std::to_string(count) + " regions");
    }
}

INSTANTIATE_TEST_SUITE_P(Cases, Continuity, testing::ValuesIn(all_split_cases()), split_case_name);

// --- work, saves, progress -----------------------------------------------------------------------

const SplitCase kPath{SplitKind::path, accel::Kind::kdtree};

TEST(RenderContinuity, WorkAddsUpOverRuns) {
  const SplitScene scene(kPath);
  const RenderSettings settings = scene.settings();
  const RenderOutcome whole = scene.render(settings);
  EXPECT_EQ(whole.work.runs, 1U);
  EXPECT_EQ(whole.work.render_s, whole.statistics.render_s);
  EXPECT_EQ(whole.work.thread_s, 2.0 * whole.statistics.render_s);
  std::optional<RenderState> saved;
  CancelToken token;
  const RenderOutcome first = scene.render(settings,
                                           {.save_every_s = 0.0,
                                            .save =
                                                [&](const RenderState& state) {
                                                  saved = state;
                                                  token.cancel();
                                                }},
                                           &token);
  EXPECT_TRUE(first.interrupted);
  EXPECT_EQ(first.work.runs, 1U);
  const RenderOutcome second = scene.render(settings, {.resume_from = saved});
  EXPECT_EQ(second.work.runs, 2U);
  EXPECT_EQ(first.statistics.rays.total() + second.statistics.rays.total(), whole.statistics.rays.total());
  EXPECT_EQ(second.work.rays.total(), whole.statistics.rays.total());
  EXPECT_EQ(second.work.rays.paths, whole.statistics.rays.paths);
  EXPECT_EQ(second.work.render_s, saved->work.render_s + second.statistics.render_s);
}

TEST(RenderContinuity, FinishedRenderIsNotSavedAgain) {
  const SplitScene scene(kPath);
  const RenderSettings settings = scene.settings();
  std::optional<RenderState> saved;
  int saves = 0;
  const auto save = [&](const RenderState& state) {
    saved = state;
    ++saves;
  };
  const Film whole = scene.render(settings, {.save = save}).film;
  EXPECT_EQ(saves, 1); // at the end
  const RenderOutcome again = scene.render(settings, {.resume_from = saved, .save_every_s = 0.0, .save = save});
  EXPECT_EQ(saves, 1);
  EXPECT_FALSE(again.interrupted);
  EXPECT_EQ(again.statistics.passes, 0);
  EXPECT_EQ(again.statistics.samples_per_pixel, settings.samples_per_pixel);
  EXPECT_EQ(again.statistics.rays.total(), 0U);
  expect_same_bits(again.film, whole, "no more work");
}

// The time of all runs counts; blocks with fewer samples catch up even so.
TEST(RenderContinuity, TimeLimitCountsAllRuns) {
  const SplitScene scene(kPath);
  RenderSettings settings = scene.settings();
  settings.planned_samples = settings.samples_per_pixel;
  settings.samples_per_pixel = 1U << 20;
  std::optional<RenderState> saved;
  CancelToken token;
  int saves = 0;
  (void)scene.render(settings,
                     {.save_every_s = 0.0,
                      .save =
                          [&](const RenderState& state) {
                            saved = state;
                            if (++saves == 40) token.cancel();
                          }},
                     &token);
  ASSERT_TRUE(saved);
  uint32_t min_done = ~0U, max_done = 0;
  for (size_t b = 0; b < saved->coverage.block_count(); ++b) {
    const uint32_t done = saved->coverage.done(b, {0, settings.samples_per_pixel});
    min_done = std::min(min_done, done);
    max_done = std::max(max_done, done);
  }
  EXPECT_LT(min_done, max_done);
  saved->work.render_s = 100.0;
  settings.time_limit_s = 50.0;
  const RenderOutcome outcome = scene.render(settings, {.resume_from = saved});
  EXPECT_FALSE(outcome.interrupted);
  EXPECT_EQ(outcome.statistics.samples_per_pixel, max_done);
  settings.samples_per_pixel = max_done;
  expect_same_bits(outcome.film, scene.render(settings).film, "all blocks equal");
}

// This includes the time while the guide is trained again.
TEST(RenderContinuity, ProgressStartsAtResumedSamples) {
  class Listener final : public ProgressListener {
   public:
    void on_progress(const ProgressSnapshot& snapshot) override { snapshots.push_back(snapshot); }
    void on_warning(std::string_view) override {}
    void on_info(std::string_view) override {}
    std::vector<ProgressSnapshot> snapshots;
  };
  const SplitScene scene({SplitKind::guided, accel::Kind::kdtree});
  RenderSettings settings = scene.settings();
  settings.planned_samples = settings.planned();
  const uint32_t before = settings.samples_per_pixel;
  std::optional<RenderState> saved;
  EXPECT_FALSE(scene.render(settings, {.save = [&](const RenderState& state) { saved = state; }}).interrupted);
  settings.samples_per_pixel = before + 3;
  Listener listener;
  const Result<RenderOutcome> outcome =
      render(scene.world(), scene.camera(), settings, nullptr, &listener, {.resume_from = std::move(saved)});
  ASSERT_TRUE(outcome.ok());
  EXPECT_GT(outcome.value().statistics.guiding.paths, 0U);
  ASSERT_GT(listener.snapshots.size(), 1U);
  for (const ProgressSnapshot& snapshot : listener.snapshots) {
    EXPECT_GE(snapshot.samples_per_pixel, before);
    EXPECT_GE(snapshot.done / snapshot.total, static_cast<double>(before) / settings.samples_per_pixel);
  }
}

TEST(RenderContinuity, SavesInIntervals) {
  const SplitScene scene(kPath);
  RenderSettings settings = scene.settings();
  settings.samples_per_pixel = 1U << 20;
  settings.time_limit_s = 0.25;
  int saves = 0;
  const RenderOutcome outcome = scene.render(settings, {.save_every_s = 0.05, .save = [&](const RenderState& state) {
                                                          ++saves;
                                                          EXPECT_GT(state.work.render_s, 0.0);
                                                          EXPECT_EQ(state.work.runs, 1U);
                                                        }});
  EXPECT_GE(saves, 2); // the machine may be slow
  EXPECT_LE(saves, outcome.statistics.render_s / 0.05 + 2);
  EXPECT_EQ(outcome.statistics.saves, saves);
  EXPECT_GE(outcome.statistics.save_s, 0.0);
}

TEST(RenderContinuity, RefusesStateThatDoesNotFit) {
  const SplitScene scene(kPath);
  const RenderSettings settings = scene.settings();
  std::optional<RenderState> saved;
  (void)scene.render(settings, {.save = [&](const RenderState& state) { saved = state; }});
  ASSERT_TRUE(saved);
  const auto refused = [&](auto change) {
    RenderSettings other = settings;
    change(other);
    const Result<RenderOutcome> outcome =
        render(scene.world(), scene.camera(), other, nullptr, nullptr, {.resume_from = saved});
    return !outcome.ok() && outcome.error().kind == ErrorKind::usage && !outcome.error().message.empty();
  };
  EXPECT_FALSE(refused([](RenderSettings&) {}));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.crop = PixelRect{V2i(0, 0), V2i(8, 8)}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.region = PixelRect{V2i(0, 0), V2i(8, 8)}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.aovs = AovSet{}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.outliers = Outliers::keep; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.adaptive.noise_threshold = 0.1; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.samples_per_pixel -= 1; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.samples = SampleRange{2, 5}; }));
}

TEST(RenderContinuity, RefusesImpossibleParts) {
  const SplitScene scene(kPath);
  const auto refused = [&](auto change) {
    RenderSettings settings = scene.settings();
    settings.crop = PixelRect{V2i(5, 3), V2i(41, 27)};
    change(settings);
    const Result<RenderOutcome> outcome = render(scene.world(), scene.camera(), settings, nullptr, nullptr);
    return !outcome.ok() && outcome.error().kind == ErrorKind::usage && !outcome.error().message.empty();
  };
  EXPECT_FALSE(refused([](RenderSettings& s) { s.samples = SampleRange{2, 5}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.samples = SampleRange{5, 5}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.samples = SampleRange{2, s.samples_per_pixel + 1}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) {
    s.samples = SampleRange{2, 5};
    s.adaptive.noise_threshold = 0.1;
  }));
  EXPECT_FALSE(refused([](RenderSettings& s) { s.region = PixelRect{V2i(5, 8), V2i(16, 27)}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.region = PixelRect{V2i(5, 8), V2i(17, 27)}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.region = PixelRect{V2i(0, 8), V2i(16, 27)}; }));
  EXPECT_TRUE(refused([](RenderSettings& s) { s.region = PixelRect{V2i(8, 8), V2i(8, 16)}; }));
}

} // namespace
} // namespace kindling::test
