// Renders that are long enough for a pilot, of which few samples are taken.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace kindling::test {

inline constexpr V2i kPilotSize(40, 30);

inline RenderSettings long_render(uint32_t samples) {
  RenderSettings settings = small_render(kPilotSize, samples);
  settings.planned_samples = 1024;
  return settings;
}

// A number that a pilot chooses: the setting that leaves it open, the pilot's report with the
// number, what is stored for later runs, the setting that has the number, and the number where
// nothing is chosen.
struct ChosenNumber {
  bool RenderSettings::*open;
  const SampleChoice& (*report)(const RenderStatistics&);
  int (*count)(const RenderStatistics&);
  std::optional<int> RenderWork::*stored;
  int IntegratorSettings::*setting;
  int min = 1;
};

inline RenderSettings long_render_to_choose(const ChosenNumber& number, uint32_t samples) {
  RenderSettings settings = long_render(samples);
  settings.*number.open = true;
  return settings;
}

inline RenderOutcome render_open(const World& world, const RenderSettings& settings, RenderContinuity continuity = {},
                                 const CancelToken* cancel = nullptr) {
  Result<RenderOutcome> outcome =
      render(world, glass_camera(settings.size_px), settings, cancel, nullptr, std::move(continuity));
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  return std::move(outcome).value();
}

class PilotMessages final : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override { warnings.emplace_back(message); }
  void on_info(std::string_view message) override { notes.emplace_back(message); }
  std::vector<std::string> warnings, notes;
};

// Expects that the pilot of glass_world() is left out with settings that `change` has made, and
// that a note with these words gives the reason.
template <typename Choice>
void expect_no_choice(RenderSettings settings, bool RenderSettings::*open, Choice RenderStatistics::*report,
                      std::type_identity_t<uint64_t Choice::*> paths, const char* words,
                      void (*change)(RenderSettings&)) {
  const auto world = glass_world(accel::Kind::kdtree);
  change(settings);
  PilotMessages messages;
  const Result<RenderOutcome> outcome = render(*world, glass_camera(kPilotSize), settings, nullptr, &messages);
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  const Choice& choice = outcome.value().statistics.*report;
  EXPECT_EQ(choice.fraction, 0.0f) << words;
  EXPECT_EQ(choice.*paths, 0U) << words;
  EXPECT_NE(choice.why_none.find(words), std::string::npos) << choice.why_none;
  ASSERT_EQ(messages.notes.size(), 1U) << words;
  EXPECT_NE(messages.notes[0].find(words), std::string::npos) << messages.notes[0];
  settings.*open = false;
  expect_same_bits(outcome.value().film, render_open(*world, settings).film, words);
}

// Returns the variance of all components over their squared mean plus `floor`, summed; by eight
// seeds.
inline double relative_noise(const World& world, RenderSettings settings, double floor) {
  constexpr uint32_t kSeeds = 8;
  std::vector<double> sums, squares;
  for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed) {
    const std::vector<float> image = render_open(world, settings).film.resolve(Aov::beauty);
    sums.resize(image.size());
    squares.resize(image.size());
    for (size_t i = 0; i < image.size(); ++i) {
      sums[i] += static_cast<double>(image[i]);
      squares[i] += static_cast<double>(image[i]) * static_cast<double>(image[i]);
    }
  }
  double relative = 0.0;
  for (size_t i = 0; i < sums.size(); ++i) {
    const double mean = sums[i] / kSeeds;
    relative += (squares[i] / kSeeds - mean * mean) / (mean * mean + floor);
  }
  return relative;
}

// Expects that the render of 5 samples that chose the number is the one that is given it.
inline void expect_same_when_given(const World& world, const ChosenNumber& number, const RenderOutcome& chosen) {
  const int count = number.count(chosen.statistics);
  EXPECT_EQ(chosen.work.*number.stored, count);
  RenderSettings fixed = long_render(5);
  fixed.integrator.*number.setting = count;
  const RenderOutcome given = render_open(world, fixed);
  expect_same_bits(chosen.film, given.film, "the chosen number");
  EXPECT_EQ(number.report(given.statistics).paths, 0U);
  EXPECT_EQ(number.count(given.statistics), count);
}

// Expects that a replay has the number that the pilot of its image chooses.
inline void expect_replayed(const World& world, const ChosenNumber& number) {
  const RenderSettings settings = long_render_to_choose(number, 1);
  const Result<ReplayedSample> sample = replay_sample(world, glass_camera(kPilotSize), settings, V2i(20, 16), 0);
  ASSERT_TRUE(sample.ok());
  const std::vector<float> image = render_open(world, settings).film.resolve(Aov::beauty);
  for (int channel = 0; channel < 3; ++channel)
    EXPECT_EQ(image[static_cast<size_t>((16 * kPilotSize.x + 20) * 3 + channel)], sample.value().radiance[channel]);
}

// Expects a choice of more than the minimum that neither threads, parts, crops nor devices change.
inline void expect_same_choice_everywhere(const World& world, const ChosenNumber& number) {
  const RenderSettings base = long_render_to_choose(number, 5);
  const RenderStatistics expected = render_open(world, base).statistics;
  ASSERT_GT(number.count(expected), number.min);
  const auto expect_same_choice = [&](const char* what, void (*change)(RenderSettings&)) {
    RenderSettings settings = base;
    change(settings);
    const RenderStatistics statistics = render_open(world, settings).statistics;
    EXPECT_EQ(number.count(statistics), number.count(expected)) << what;
    EXPECT_EQ(number.report(statistics).predicted, number.report(expected).predicted) << what;
    EXPECT_EQ(number.report(statistics).rays.total(), number.report(expected).rays.total()) << what;
  };
  expect_same_choice("threads", [](RenderSettings& s) { s.threads = 3, s.tile_size_px = 8; });
  expect_same_choice("a part", [](RenderSettings& s) {
    s.region = PixelRect{V2i(8, 8), V2i(24, 16)};
    s.samples = SampleRange{2, 3};
  });
  expect_same_choice("a crop", [](RenderSettings& s) { s.crop = PixelRect{V2i(5, 3), V2i(9, 11)}; });
  expect_same_choice("a device", [](RenderSettings& s) { s.device = DeviceKind::host; });
}

// Expects that a render which is continued has the stored choice, more than the minimum.
inline void expect_stored_choice(const World& world, const ChosenNumber& number) {
  const Film whole = render_open(world, long_render_to_choose(number, 9)).film;
  std::optional<RenderState> saved;
  (void)render_open(world, long_render_to_choose(number, 4),
                    {.save = [&](const RenderState& state) { saved = state; }});
  ASSERT_TRUE(saved);
  ASSERT_GT((saved->work.*number.stored).value_or(number.min), number.min);
  RenderSettings longer = long_render_to_choose(number, 9);
  longer.time_limit_s = 1000.0; // another pilot would choose
  const RenderOutcome outcome = render_open(world, longer, {.resume_from = saved});
  EXPECT_EQ(number.report(outcome.statistics).paths, 0U);
  EXPECT_EQ(number.count(outcome.statistics), *(saved->work.*number.stored));
  expect_same_bits(outcome.film, whole, "a resumed render");
}

} // namespace kindling::test
