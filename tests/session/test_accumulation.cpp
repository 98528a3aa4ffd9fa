// Fills states and identities with random values, and writes them.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/test_accumulation.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>

#include <unistd.h>

namespace kindling::test {

namespace fs = std::filesystem;

void AccumulationFolder::SetUp() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  folder_ = fs::temp_directory_path() / ("kindling_accumulation_" + std::to_string(getpid()) + "_" + info->name());
  fs::create_directories(folder_);
  path_ = folder_ / "render.kacc";
}

void AccumulationFolder::TearDown() { fs::remove_all(folder_); }

size_t AccumulationFolder::files_in_folder() const {
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
}

AccumulationIdentity identity_of(const V2i& size_px, const PixelRect& crop) {
  AccumulationIdentity identity;
  identity.program = "Kindling 9.9 (test)";
  identity.image = R"({"seed":7,"tracer":"path"})";
  identity.scene_hash = 0xfedcba9876543210;
  identity.arguments = {"render", "scène.gltf", "--spp", "64", std::string("name\xff\0.exr", 10)};
  identity.folder = "/somewhere/else";
  identity.size_px = size_px;
  identity.crop = crop;
  identity.samples_per_pixel = 4000000000;
  identity.planned_samples = 64;
  identity.part = {16, 32};
  identity.metadata = R"({"scene":"a \"name\""})";
  return identity;
}

RenderState random_state(const V2i& size_px, const PixelRect& area, bool everything, uint32_t seed) {
  AovSet aovs;
  if (everything)
    for (const AovInfo& info : kAovs) aovs.insert(info.aov);
  if (everything)
    for (const Matte matte : {Matte::object, Matte::asset}) aovs.insert(matte);
  RenderState state{Film(size_px, area, aovs), Coverage(area), {}, {}};
  std::mt19937 random(seed);
  if (everything) {
    state.film.trim_outliers();
    state.film.enable_splats({V2i(0), size_px});
    state.adaptive.stop_at.resize(state.coverage.block_count());
    state.adaptive.rays.resize(state.coverage.block_count());
    state.adaptive.earlier.resize(static_cast<size_t>(area.pixel_count()));
    for (uint32_t& stop_at : state.adaptive.stop_at) stop_at = static_cast<uint32_t>(random());
    for (uint64_t& rays : state.adaptive.rays) rays = random() * uint64_t{random()};
    for (Film::Totals& totals : state.adaptive.earlier) totals = {{0.5 * random(), 1e-300, -1.0}, 0.1 * random()};
  }
  for (const Film::Plane& plane : state.film.planes())
    for (std::byte& byte : plane.bytes) byte = static_cast<std::byte>(random());
  // Most pixels have one combination of ids, some none or many. The same for each seed, so that
  // files have one size.
  for (int y = area.min.y; y < area.max.y && everything; ++y)
    for (int x = area.min.x; x < area.max.x; ++x)
      for (int i = 0; i < ((7 * x + 3 * y) % 8 == 0 ? (x + y) % 6 : 1); ++i)
        state.film.add_matte({x, y}, {.object = 1 + static_cast<uint32_t>(i), .asset = 7},
                             0.3f * static_cast<float>(x % 5) - 0.1f * static_cast<float>(y % 7));
  for (size_t i = 0; i < state.coverage.block_count(); ++i) {
    if (i % 7 != 3) state.coverage.add(i, {16, i % 5 == 0 ? 20U : 24U});
    if (i % 11 == 4) state.coverage.add(i, {28, 4294967295U});
    if (i % 13 == 5) state.coverage.set_stopped(i);
  }
  state.work = {0.1, 1e9 / 3.0, {}, 3};
  if (everything) {
    state.work.light_paths = 0.125f;
    state.work.direct_samples = 3;
    state.work.reflection_samples = 2;
    state.work.path_reuse = 4;
  }
  state.work.rays.camera = uint64_t{1} << 60;
  state.work.rays.whitted.cache_bypasses = 5;
  state.work.rays.add_non_finite(V2i(4, 5), 17);
  return state;
}

void expect_same(const RenderState& a, const RenderState& b) {
  EXPECT_EQ(a.film.size_px(), b.film.size_px());
  EXPECT_EQ(a.film.aovs().bits(), b.film.aovs().bits());
  const auto planes_a = a.film.planes(), planes_b = b.film.planes();
  ASSERT_EQ(planes_a.size(), planes_b.size());
  for (size_t p = 0; p < planes_a.size(); ++p)
    EXPECT_TRUE(std::ranges::equal(planes_a[p].bytes, planes_b[p].bytes)) << planes_a[p].name;
  const FlatMattes mattes_a = a.film.mattes().flat(), mattes_b = b.film.mattes().flat();
  EXPECT_EQ(mattes_a.counts, mattes_b.counts);
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(mattes_a.terms)), std::as_bytes(std::span(mattes_b.terms))));
  EXPECT_TRUE(a.coverage.area().min == b.coverage.area().min && a.coverage == b.coverage);
  EXPECT_EQ(a.adaptive.stop_at, b.adaptive.stop_at);
  EXPECT_EQ(a.adaptive.rays, b.adaptive.rays);
  ASSERT_EQ(a.adaptive.earlier.size(), b.adaptive.earlier.size());
  for (size_t i = 0; i < a.adaptive.earlier.size(); ++i)
    EXPECT_TRUE(a.adaptive.earlier[i].rgb == b.adaptive.earlier[i].rgb &&
                a.adaptive.earlier[i].weight == b.adaptive.earlier[i].weight);
  EXPECT_EQ(a.work.render_s, b.work.render_s);
  EXPECT_EQ(a.work.thread_s, b.work.thread_s);
  EXPECT_EQ(a.work.runs, b.work.runs);
  EXPECT_EQ(a.work.direct_samples, b.work.direct_samples);
  EXPECT_EQ(a.work.reflection_samples, b.work.reflection_samples);
  EXPECT_EQ(a.work.path_reuse, b.work.path_reuse);
  EXPECT_EQ(a.work.rays.camera, b.work.rays.camera);
  EXPECT_EQ(a.work.rays.whitted.cache_bypasses, b.work.rays.whitted.cache_bypasses);
  EXPECT_EQ(a.work.rays.non_finite, b.work.rays.non_finite);
  EXPECT_EQ(a.work.rays.first_non_finite, b.work.rays.first_non_finite);
}

void expect_same(const AccumulationIdentity& a, const AccumulationIdentity& b) {
  EXPECT_EQ(a.program, b.program);
  EXPECT_EQ(a.image, b.image);
  EXPECT_EQ(a.scene_hash, b.scene_hash);
  EXPECT_EQ(a.arguments, b.arguments);
  EXPECT_EQ(a.folder, b.folder);
  EXPECT_EQ(a.size_px, b.size_px);
  EXPECT_TRUE(a.crop.min == b.crop.min && a.crop.max == b.crop.max);
  EXPECT_EQ(a.samples_per_pixel, b.samples_per_pixel);
  EXPECT_EQ(a.planned_samples, b.planned_samples);
  EXPECT_EQ(a.part, b.part);
  EXPECT_EQ(a.metadata, b.metadata);
}

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
void set_contents(const fs::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

void write_small(const fs::path& path, uint32_t seed, bool keep_previous) {
  const Result<void> written = write_accumulation(path, identity_of(kSmall, kSmallArea),
                                                  random_state(kSmall, kSmallArea, true, seed), keep_previous);
  ASSERT_TRUE(written.ok()) << written.error().message;
}

void expect_small(const fs::path& path, uint32_t seed) {
  const Result<Accumulation> read = read_accumulation(path);
  ASSERT_TRUE(read.ok()) << read.error().message;
  expect_same(read.value().state, random_state(kSmall, kSmallArea, true, seed));
}

} // namespace kindling::test
