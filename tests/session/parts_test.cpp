// Parts of samples and image, added up in any order, equal the undivided render bit for bit.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/split_renders.h"

#include <algorithm>

namespace kindling::test {
namespace {

class Parts : public testing::TestWithParam<SplitCase> {};

RenderState empty_state(const Film& whole) {
  RenderState state{Film(whole.size_px(), whole.crop(), whole.aovs()), Coverage(whole.crop()), {}, {}};
  state.film.split_by_light_groups(whole.light_groups());
  if (whole.trims_outliers()) state.film.trim_outliers();
  if (whole.has_splats()) state.film.enable_splats();
  return state;
}

void merge(RenderState& sum, const RenderState& part) {
  sum.film.add(part.film);
  sum.work.light_paths = part.work.light_paths;
  for (size_t b = 0; b < part.coverage.block_count(); ++b)
    for (const SampleRange& span : part.coverage[b].spans)
      EXPECT_TRUE(sum.coverage.add(sum.coverage.index_of(part.coverage.block(b).min), span));
}

TEST_P(Parts, AddUpInAnyOrder) {
  const SplitScene scene(GetParam());
  const RenderSettings whole_settings = scene.settings();
  const bool divides_samples = !whole_settings.adaptive.enabled();
  const Film whole = scene.render(whole_settings).film;
  const uint32_t spp = whole_settings.samples_per_pixel;
  std::mt19937 random(5);
  for (const uint32_t count : {1U, 3U, 8U}) {
    std::vector<RenderState> parts;
    for (uint32_t k = 0; k < count; ++k)
      for (const PixelRect& region : make_regions(whole.crop(), divides_samples ? 2 : static_cast<int>(count))) {
        if (!divides_samples && k > 0) continue;
        RenderSettings settings = whole_settings;
        if (divides_samples) settings.samples = SampleRange{spp * k / count, spp * (k + 1) / count};
        settings.region = region;
        vary_work(settings, random);
        (void)scene.render(settings, {.save = [&](const RenderState& state) { parts.push_back(state); }});
      }
    std::shuffle(parts.begin(), parts.end(), random);
    RenderState sum = empty_state(whole);
    for (const RenderState& part : parts) merge(sum, part);
    expect_same_bits(sum.film, whole, std::to_string(count) + " parts");
    for (size_t b = 0; b < sum.coverage.block_count() && divides_samples; ++b)
      EXPECT_TRUE(sum.coverage.complete(b, {0, spp}));
  }
}

// Gaps in samples and in the image are found and filled.
class Gaps : public Parts {};

TEST_P(Gaps, MissingSamplesAreRenderedLater) {
  const SplitScene scene(GetParam());
  const RenderSettings settings = scene.settings();
  const Film whole = scene.render(settings).film;
  RenderState sum = empty_state(whole);
  const std::vector<PixelRect> regions = make_regions(whole.crop(), 3);
  for (const auto& [samples, region] :
       {std::pair(SampleRange{6, 8}, regions[0]), {{2, 3}, regions[0]}, {{0, 5}, regions[2]}}) {
    RenderSettings part = settings;
    part.samples = samples;
    part.region = region;
    (void)scene.render(part, {.save = [&](const RenderState& state) { merge(sum, state); }});
  }
  uint64_t missing = 0;
  for (size_t b = 0; b < sum.coverage.block_count(); ++b) {
    uint32_t has = 0;
    for (const SampleRange& span : sum.coverage[b].spans) has += span.count();
    missing += (settings.samples_per_pixel - has) * static_cast<uint64_t>(sum.coverage.block(b).pixel_count());
  }
  const RenderOutcome outcome = scene.render(settings, {.resume_from = std::move(sum)});
  EXPECT_EQ(outcome.statistics.rays.paths, missing); // and no others
  expect_same_bits(outcome.film, whole, "gaps filled");
}

INSTANTIATE_TEST_SUITE_P(Cases, Parts, testing::ValuesIn(all_split_cases()), split_case_name);

// Those whose samples can be divided, and are as many for each pixel.
std::vector<SplitCase> cases_with_gaps() {
  std::vector<SplitCase> cases = all_split_cases();
  std::erase_if(cases, [](const SplitCase& c) {
    return c.kind == SplitKind::adaptive || c.kind == SplitKind::rates || c.kind == SplitKind::photons_by_rates;
  });
  return cases;
}
INSTANTIATE_TEST_SUITE_P(Cases, Gaps, testing::ValuesIn(cases_with_gaps()), split_case_name);

} // namespace
} // namespace kindling::test
