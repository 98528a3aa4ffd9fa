// Merging of accumulation files: any division gives the bits of one render; refusals.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/merge_accumulations.h"
#include "renderer/distributed/work_parts.h"
#include "tests/session/split_renders.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace kindling::test {
namespace {

namespace fs = std::filesystem;

class Merge : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "." + info->name();
    std::replace(name.begin(), name.end(), '/', '_');
    folder_ = fs::path(testing::TempDir()) / ("kindling_merge_" + name + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Returns the identity of a render with these settings and that part in its arguments.
  static AccumulationIdentity identity_of(const RenderSettings& settings, const WorkPart& part = {}) {
    AccumulationIdentity identity;
    identity.program = "Kindling test";
    identity.image = R"({"seed":)" + std::to_string(settings.seed) + "}";
    identity.scene_hash = 0x1234;
    identity.arguments = {"render", "scene.gltf"};
    if (part.samples) identity.arguments.insert(identity.arguments.end(), {"--part", part_number_text(*part.samples)});
    if (part.tiles) identity.arguments.insert(identity.arguments.end(), {"--tile-part", part_number_text(*part.tiles)});
    identity.folder = "/";
    identity.size_px = settings.size_px;
    identity.crop = settings.crop.value_or(PixelRect{V2i(0, 0), settings.size_px});
    identity.samples_per_pixel = settings.samples_per_pixel;
    identity.planned_samples = settings.planned();
    identity.part = settings.wanted_samples();
    return identity;
  }

  // Renders one part to NAME.kacc.
  fs::path render_part(const SplitScene& scene, RenderSettings settings, const std::string& name,
                       const WorkPart& part = {}) const {
    if (part.samples) settings.samples = part_samples(settings.samples_per_pixel, *part.samples).value();
    if (part.tiles)
      settings.region =
          tile_part_region(settings.crop.value_or(PixelRect{V2i(0, 0), settings.size_px}), *part.tiles).value();
    const fs::path file = folder_ / (name + ".kacc");
    (void)scene.render(settings, {.save = [&](const RenderState& state) {
                         const Result<void> written =
                             write_accumulation(file, identity_of(settings, part), state, false);
                         EXPECT_TRUE(written.ok()) << (written.ok() ? "" : written.error().message);
                       }});
    return file;
  }

  // Renders all parts of an image that is divided by samples and by pixels; 1 means undivided.
  std::vector<fs::path> render_parts(const SplitScene& scene, const RenderSettings& settings, uint32_t sample_parts,
                                     uint32_t tile_parts, std::mt19937& random) const {
    std::vector<fs::path> files;
    for (uint32_t k = 1; k <= sample_parts; ++k)
      for (uint32_t t = 1; t <= tile_parts; ++t) {
        WorkPart part;
        if (sample_parts > 1) part.samples = PartNumber{k, sample_parts};
        if (tile_parts > 1) part.tiles = PartNumber{t, tile_parts};
        RenderSettings own = settings;
        vary_work(own, random);
        files.push_back(render_part(scene, own,
                                    "part-" + std::to_string(sample_parts) + "-" + std::to_string(k) + "-" +
                                        std::to_string(tile_parts) + "-" + std::to_string(t),
                                    part));
      }
    return files;
  }

  static Accumulation merge(const std::vector<fs::path>& files) {
    const Result<MergePlan> plan = plan_merge(files, {});
    EXPECT_TRUE(plan.ok()) << (plan.ok() ? "" : plan.error().message);
    EXPECT_EQ(plan.value().gaps.lines, std::vector<std::string>{});
    Result<Accumulation> merged = merge_accumulations(plan.value(), nullptr, {});
    EXPECT_TRUE(merged.ok()) << (merged.ok() ? "" : merged.error().message);
    return std::move(merged).value();
  }

  static void expect_refused(const std::vector<fs::path>& files, ErrorKind kind,
                             const std::vector<std::string>& words) {
    const Result<MergePlan> plan = plan_merge(files, {});
    ASSERT_FALSE(plan.ok());
    EXPECT_EQ(plan.error().kind, kind) << plan.error().message;
    for (const std::string& word : words)
      EXPECT_NE(plan.error().message.find(word), std::string::npos) << plan.error().message << "\nlacks " << word;
  }

  fs::path folder_;
};

// --- the sum -------------------------------------------------------------------------------------

class MergeOf : public Merge, public testing::WithParamInterface<SplitCase> {};

TEST_P(MergeOf, AnyPartsInAnyOrderMatchTheWhole) {
  const SplitScene scene(GetParam());
  RenderSettings settings = scene.settings();
  settings.planned_samples = settings.planned();
  settings.crop = PixelRect{V2i(5, 3), V2i(41, 27)};
  std::optional<RenderState> saved;
  const Film whole = scene.render(settings, {.save = [&](const RenderState& state) { saved = state; }}).film;
  std::mt19937 random(7);
  const bool adaptive = settings.adaptive.enabled();
  const bool slow = GetParam().kind == SplitKind::guided; // it trains for every part
  std::vector<std::pair<uint32_t, uint32_t>> divisions{{1, 1}, {3, 1}, {1, 3}, {8, 1}, {3, 2}};
  if (slow) divisions = {{3, 1}, {1, 2}};
  if (adaptive) divisions = {{1, 1}, {1, 3}, {1, 8}};
  for (const auto& [sample_parts, tile_parts] : divisions) {
    std::vector<fs::path> files = render_parts(scene, settings, sample_parts, tile_parts, random);
    std::shuffle(files.begin(), files.end(), random);
    const Accumulation merged = merge(files);
    const std::string what = std::to_string(sample_parts) + " x " + std::to_string(tile_parts) + " parts";
    ASSERT_TRUE(saved);
    EXPECT_TRUE(merged.state.film.crop() == saved->film.crop());
    expect_same_bits(merged.state.film.cut(*settings.crop), whole, what);
    EXPECT_EQ(merged.state.film.planes().size(), saved->film.planes().size());
    for (size_t i = 0; i < merged.state.film.planes().size(); ++i) // every sum, not just the images
      EXPECT_TRUE(std::ranges::equal(merged.state.film.planes()[i].bytes, saved->film.planes()[i].bytes))
          << merged.state.film.planes()[i].name << " differs with " << what;
    EXPECT_EQ(merged.state.coverage, saved->coverage) << what;
    EXPECT_EQ(merged.state.adaptive.stop_at, saved->adaptive.stop_at);
    EXPECT_EQ(merged.state.adaptive.rays, saved->adaptive.rays);
    const bool by_rates = GetParam().kind == SplitKind::rates || GetParam().kind == SplitKind::photons_by_rates;
    if (by_rates && files.size() > 1) // every part traces the pilot
      EXPECT_GT(merged.state.work.rays.total(), saved->work.rays.total());
    else
      EXPECT_EQ(merged.state.work.rays.total(), saved->work.rays.total());
    EXPECT_EQ(merged.state.work.runs, files.size());
    EXPECT_EQ(merged.identity.arguments, (std::vector<std::string>{"render", "scene.gltf"}));
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, MergeOf, testing::ValuesIn(all_split_cases()), split_case_name);

const SplitCase kPath{SplitKind::path, accel::Kind::kdtree};

RenderSettings quick_settings(const SplitScene& scene) {
  RenderSettings settings = scene.settings();
  settings.samples_per_pixel = 6;
  settings.aovs = {};
  settings.outliers = Outliers::keep;
  settings.integrator.max_bounces = 1;
  return settings;
}

TEST_F(Merge, MergesOfMergesMatchTheWhole) {
  const SplitScene scene(kPath);
  const RenderSettings settings = quick_settings(scene);
  std::mt19937 random(8);
  const std::vector<fs::path> parts = render_parts(scene, settings, 3, 2, random);
  const auto save = [&](const char* name, const std::vector<fs::path>& files) {
    const Result<MergePlan> plan = plan_merge(files, {});
    EXPECT_TRUE(plan.ok());
    const Result<Accumulation> merged = merge_accumulations(plan.value(), nullptr, {});
    EXPECT_TRUE(merged.ok());
    const fs::path file = folder_ / name;
    EXPECT_TRUE(write_accumulation(file, merged.value().identity, merged.value().state, false).ok());
    return file;
  };
  const fs::path odd = save("odd.kacc", {parts[5], parts[1], parts[3]});
  const fs::path even = save("even.kacc", {parts[0], parts[4]});
  expect_same_bits(merge({even, odd, parts[2]}).state.film, scene.render(settings).film, "merges of merges");
}

// Adds further samples to a finished image, as parts.
TEST_F(Merge, FurtherSamplesOfTheSamePlanAreAdded) {
  const SplitScene scene(kPath);
  RenderSettings settings = quick_settings(scene);
  settings.planned_samples = 6;
  const fs::path first = render_part(scene, settings, "first");
  settings.samples_per_pixel = 12;
  const fs::path second = render_part(scene, settings, "second", {PartNumber{2, 2}, {}});
  const Accumulation merged = merge({first, second});
  EXPECT_EQ(merged.identity.samples_per_pixel, 12U);
  expect_same_bits(merged.state.film, scene.render(settings).film, "further samples");
}

// A merge with a gap can be resumed.
TEST_F(Merge, MergedStateCanBeResumed) {
  const SplitScene scene(kPath);
  RenderSettings settings = quick_settings(scene);
  settings.planned_samples = 6;
  std::mt19937 random(9);
  std::vector<fs::path> parts = render_parts(scene, settings, 2, 2, random);
  parts.erase(parts.begin() + 1); // a gap
  const Result<MergePlan> plan = plan_merge(parts, {});
  ASSERT_TRUE(plan.ok());
  Result<Accumulation> merged = merge_accumulations(plan.value(), nullptr, {});
  ASSERT_TRUE(merged.ok());
  settings.samples_per_pixel = 9;
  const Film whole = scene.render(settings).film;
  const RenderOutcome outcome = scene.render(settings, {.resume_from = std::move(merged).value().state});
  expect_same_bits(outcome.film, whole, "a resumed merge");
}

// --- files left out ------------------------------------------------------------------------------

TEST_F(Merge, DuplicatesCountOnce) {
  const SplitScene scene(kPath);
  const RenderSettings settings = quick_settings(scene);
  const fs::path a = render_part(scene, settings, "a", {PartNumber{1, 2}, {}});
  const fs::path b = render_part(scene, settings, "b", {PartNumber{2, 2}, {}});
  const fs::path again = render_part(scene, settings, "again", {PartNumber{1, 2}, {}}); // rendered twice
  const fs::path link = folder_ / "link.kacc";
  fs::create_symlink(b, link);
  const std::vector<fs::path> files{again, a, b, link, a};
  const Result<MergePlan> plan = plan_merge(files, {});
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  EXPECT_EQ(plan.value().parts, (std::vector<fs::path>{again, b}));
  ASSERT_EQ(plan.value().duplicates.size(), 1U);
  EXPECT_EQ(plan.value().duplicates[0].file, a);
  EXPECT_EQ(plan.value().left_out.size(), 2U); // the link and the repeated file
  size_t done = 0;
  const Result<Accumulation> merged =
      merge_accumulations(plan.value(), nullptr, [&](size_t files_done) { EXPECT_EQ(files_done, ++done); });
  ASSERT_TRUE(merged.ok()) << merged.error().message;
  EXPECT_EQ(done, 3U);
  EXPECT_EQ(merged.value().state.work.runs, 2U);
  expect_same_bits(merged.value().state.film, scene.render(settings).film, "duplicates");
}

TEST_F(Merge, RefusesDuplicatesWithDifferentSums) {
  const SplitScene scene(kPath);
  RenderSettings settings = quick_settings(scene);
  const fs::path a = render_part(scene, settings, "a");
  settings.seed = 1; // stands for a faulty machine
  Result<Accumulation> wrong = read_accumulation(render_part(scene, settings, "wrong"));
  ASSERT_TRUE(wrong.ok());
  settings.seed = 0;
  const fs::path b = folder_ / "b.kacc";
  ASSERT_TRUE(write_accumulation(b, identity_of(settings), wrong.value().state, false).ok());
  const std::vector<fs::path> files{a, b};
  const Result<MergePlan> plan = plan_merge(files, {});
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  const Result<Accumulation> merged = merge_accumulations(plan.value(), nullptr, {});
  ASSERT_FALSE(merged.ok());
  EXPECT_EQ(merged.error().kind, ErrorKind::input_output);
  for (const fs::path& file : files)
    EXPECT_NE(merged.error().message.find(file.string()), std::string::npos) << merged.error().message;
}

TEST_F(Merge, LeavesOutOtherFilesOfAWildcard) {
  const SplitScene scene(kPath);
  const RenderSettings settings = quick_settings(scene);
  const fs::path a = render_part(scene, settings, "a", {PartNumber{1, 2}, {}});
  const fs::path b = render_part(scene, settings, "b", {PartNumber{2, 2}, {}});
  const fs::path out = render_part(scene, settings, "out"); // of the last merge
  const fs::path previous = folder_ / "a.kacc.previous";
  fs::copy_file(a, previous);
  const fs::path lock = folder_ / "a.kacc.lock";
  std::ofstream(lock) << "";
  const fs::path unfinished = folder_ / ".kindling-12-0.tmp";
  std::ofstream(unfinished) << "half";
  const std::vector<fs::path> outputs{out};
  const std::vector<fs::path> files{unfinished, lock, a, previous, b, out};
  Result<MergePlan> plan = plan_merge(files, outputs);
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  EXPECT_EQ(plan.value().parts, (std::vector<fs::path>{a, b}));
  EXPECT_EQ(plan.value().left_out.size(), 4U);
  // Alone, the output of an earlier merge is a part ...
  const std::vector<fs::path> alone{out};
  plan = plan_merge(alone, outputs);
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  EXPECT_EQ(plan.value().parts, alone);
  // ... and it is an overlap beside a file that has some but not all of its samples.
  const std::vector<fs::path> some{a, out};
  EXPECT_FALSE(plan_merge(some, outputs).ok());
  // A previous generation is a part if the current one is not given.
  const std::vector<fs::path> old{previous, b};
  EXPECT_EQ(merge(old).state.work.runs, 2U);
}

// --- refused files -------------------------------------------------------------------------------

TEST_F(Merge, RefusesMissingAndForeignFiles) {
  expect_refused({}, ErrorKind::usage, {"no parts"});
  expect_refused({folder_ / "none.kacc"}, ErrorKind::input_output, {"none.kacc"});
  std::ofstream(folder_ / "text.kacc") << "not an accumulation";
  expect_refused({folder_ / "text.kacc"}, ErrorKind::input_output, {"text.kacc"});
}

TEST_F(Merge, RefusesOverlaps) {
  const SplitScene scene(kPath);
  const RenderSettings settings = quick_settings(scene);
  const fs::path half = render_part(scene, settings, "half", {PartNumber{1, 2}, {}});
  const fs::path second = render_part(scene, settings, "second", {PartNumber{2, 3}, {}});
  const fs::path third = render_part(scene, settings, "third", {PartNumber{3, 3}, {}});
  expect_refused({half, third, second}, ErrorKind::usage,
                 {"half.kacc", "second.kacc", "overlap", "samples 2-2 of pixel"});
  const fs::path tile = render_part(scene, settings, "tile", {{}, PartNumber{2, 4}});
  expect_refused({third, tile}, ErrorKind::usage, {"tile.kacc", "third.kacc", "samples 4-5 of pixel (0, 16)"});
}

TEST_F(Merge, RefusesOtherImages) {
  const SplitScene scene(kPath);
  RenderSettings settings = quick_settings(scene);
  const fs::path a = render_part(scene, settings, "a", {PartNumber{1, 2}, {}});
  RenderSettings other = settings;
  other.seed = 9;
  expect_refused({a, render_part(scene, other, "seed", {PartNumber{2, 2}, {}})}, ErrorKind::usage,
                 {"seed.kacc", "a.kacc", "seed: 0 and 9"});
  other = settings;
  other.samples_per_pixel = 8;
  expect_refused({a, render_part(scene, other, "samples", {PartNumber{2, 2}, {}})}, ErrorKind::usage,
                 {"planned samples per pixel: 6 and 8"});
  other = settings;
  other.crop = PixelRect{V2i(0, 0), V2i(40, 24)};
  expect_refused({a, render_part(scene, other, "crop", {PartNumber{2, 2}, {}})}, ErrorKind::usage,
                 {"crop: 0,0,43,29 and 0,0,40,24"});
  const auto rewrite = [&](const char* name, auto change) {
    Result<Accumulation> read = read_accumulation(a);
    EXPECT_TRUE(read.ok());
    change(read.value().identity);
    const fs::path file = folder_ / name;
    EXPECT_TRUE(write_accumulation(file, read.value().identity, read.value().state, false).ok());
    return file;
  };
  expect_refused({a, rewrite("scene.kacc", [](AccumulationIdentity& i) { i.scene_hash = 1; })}, ErrorKind::usage,
                 {"scene.kacc", "scene hash: 0000000000001234 and 0000000000000001"});
  expect_refused({a, rewrite("version.kacc", [](AccumulationIdentity& i) { i.program = "Kindling 2"; })},
                 ErrorKind::usage, {"version.kacc", "program: Kindling test and Kindling 2"});
}

TEST_F(Merge, DetectsDamageAnywhere) {
  const SplitScene scene(kPath);
  const RenderSettings settings = quick_settings(scene);
  const fs::path a = render_part(scene, settings, "a", {PartNumber{1, 2}, {}});
  const fs::path b = render_part(scene, settings, "b", {PartNumber{2, 2}, {}});
  std::string bytes(fs::file_size(b), '\0');
  std::ifstream(b, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const std::vector<fs::path> files{a, b};
  for (size_t i = 1; i < 24; ++i) {
    std::string changed = bytes;
    changed[bytes.size() * i / 24] ^= 4;
    std::ofstream(b, std::ios::binary).write(changed.data(), static_cast<std::streamsize>(changed.size()));
    const Result<MergePlan> plan = plan_merge(files, {});
    const Error error = plan.ok() ? merge_accumulations(plan.value(), nullptr, {}).error() : plan.error();
    EXPECT_EQ(error.kind, ErrorKind::input_output) << error.message;
    EXPECT_NE(error.message.find("b.kacc"), std::string::npos) << error.message;
  }
}

// Parts for which a pilot has chosen, and others for which none has.
TEST_F(Merge, RefusesOtherChoicesOfPilots) {
  const SplitScene scene({SplitKind::light_paths, accel::Kind::kdtree});
  using Choice = std::pair<bool RenderSettings::*, const char*>;
  for (const auto& [open, words] : {Choice{&RenderSettings::chooses_light_paths, "other light paths"},
                                    Choice{&RenderSettings::chooses_reflection_samples, "reflection samples"},
                                    Choice{&RenderSettings::chooses_photons, "number of photons"}}) {
    RenderSettings settings = quick_settings(scene);
    settings.planned_samples = 1024;
    settings.chooses_light_paths = false;
    settings.*open = true;
    const fs::path a = render_part(scene, settings, "a", {PartNumber{1, 2}, {}});
    settings.*open = false;
    const fs::path b = render_part(scene, settings, "b", {PartNumber{2, 2}, {}});
    const Result<MergePlan> plan = plan_merge(std::vector{a, b}, {});
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    const Result<Accumulation> merged = merge_accumulations(plan.value(), nullptr, {});
    ASSERT_FALSE(merged.ok());
    EXPECT_NE(merged.error().message.find(words), std::string::npos) << merged.error().message;
  }
}

TEST_F(Merge, GapsAreListed) {
  const SplitScene scene(kPath);
  const RenderSettings settings = quick_settings(scene);
  std::mt19937 random(10);
  const std::vector<fs::path> parts = render_parts(scene, settings, 3, 1, random);
  const std::vector<fs::path> files{parts[2], parts[0]};
  const Result<MergePlan> plan = plan_merge(files, {});
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan.value().gaps.lines, std::vector<std::string>{"part 2/3: samples 2-3 of all pixels"});
  const Result<Accumulation> merged = merge_accumulations(plan.value(), nullptr, {});
  ASSERT_TRUE(merged.ok());
  EXPECT_EQ(merged.value().state.film.total_samples(), 4U * 43 * 29);
  // A single tile: its pixels are those of the whole image, all others are empty.
  const std::vector<fs::path> tile{render_part(scene, settings, "tile", {{}, PartNumber{2, 4}})};
  const Result<MergePlan> tile_plan = plan_merge(tile, {});
  ASSERT_TRUE(tile_plan.ok());
  EXPECT_EQ(tile_plan.value().gaps.lines.size(), 3U);
  const Result<Accumulation> one = merge_accumulations(tile_plan.value(), nullptr, {});
  ASSERT_TRUE(one.ok());
  const PixelRect region = tile_part_region({V2i(0, 0), settings.size_px}, {2, 4}).value();
  expect_same_bits(one.value().state.film.cut(region), scene.render(settings).film, "a tile alone");
  for (const float value : one.value().state.film.cut({V2i(24, 0), V2i(43, 8)}).resolve_rgba()) EXPECT_EQ(value, 0.0f);
}

} // namespace
} // namespace kindling::test
