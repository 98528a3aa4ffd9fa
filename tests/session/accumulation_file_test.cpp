// Accumulation files: what is written comes back, what is damaged is found, and a good file is there at every moment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kindling {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWriterVariable = "KINDLING_TEST_ACCUMULATION_WRITER";

class AccumulationFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("kindling_accumulation_" + std::to_string(getpid()) + "_" + info->name());
    fs::create_directories(folder_);
    path_ = folder_ / "render.kacc";
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] size_t files_in_folder() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_, path_;
};

AccumulationIdentity identity_of(const V2i& size_px, const PixelRect& crop) {
  AccumulationIdentity identity;
  identity.program = "Kindling 9.9 (test)";
  identity.picture = R"({"seed":7,"tracer":"path"})";
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

// Of random records: what a file must carry, whether or not a render could leave it.
RenderState random_state(const V2i& size_px, const PixelRect& area, bool everything, uint32_t seed) {
  AovSet aovs;
  if (everything)
    for (const AovInfo& info : kAovs) aovs.insert(info.aov);
  RenderState state{Film(size_px, area, aovs), Coverage(area), {}, {}};
  std::mt19937 random(seed);
  if (everything) {
    state.film.trim_outliers();
    state.adaptive.stop_at.resize(state.coverage.block_count());
    state.adaptive.rays.resize(state.coverage.block_count());
    state.adaptive.earlier.resize(static_cast<size_t>(area.pixel_count()));
    for (uint32_t& stop_at : state.adaptive.stop_at) stop_at = static_cast<uint32_t>(random());
    for (uint64_t& rays : state.adaptive.rays) rays = random() * uint64_t{random()};
    for (Film::Totals& totals : state.adaptive.earlier) totals = {{0.5 * random(), 1e-300, -1.0}, 0.1 * random()};
  }
  for (const Film::Plane& plane : state.film.planes())
    for (std::byte& byte : plane.bytes) byte = static_cast<std::byte>(random());
  for (size_t i = 0; i < state.coverage.block_count(); ++i) {
    if (i % 7 != 3) state.coverage.add(i, {16, i % 5 == 0 ? 20U : 24U});
    if (i % 11 == 4) state.coverage.add(i, {28, 4294967295U});
    if (i % 13 == 5) state.coverage.set_stopped(i);
  }
  state.work = {0.1, 1e9 / 3.0, {}, 3};
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
  EXPECT_EQ(a.work.rays.camera, b.work.rays.camera);
  EXPECT_EQ(a.work.rays.whitted.cache_bypasses, b.work.rays.whitted.cache_bypasses);
  EXPECT_EQ(a.work.rays.non_finite, b.work.rays.non_finite);
  EXPECT_EQ(a.work.rays.first_non_finite, b.work.rays.first_non_finite);
}

void expect_same(const AccumulationIdentity& a, const AccumulationIdentity& b) {
  EXPECT_EQ(a.program, b.program);
  EXPECT_EQ(a.picture, b.picture);
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

constexpr V2i kSmall(40, 24);
constexpr PixelRect kSmallArea{V2i(8, 0), V2i(40, 24)};

void write_small(const fs::path& path, uint32_t seed = 1, bool keep_previous = false) {
  const Result<void> written = write_accumulation(path, identity_of(kSmall, kSmallArea),
                                                  random_state(kSmall, kSmallArea, true, seed), keep_previous);
  ASSERT_TRUE(written.ok()) << written.error().message;
}

void expect_small(const fs::path& path, uint32_t seed) {
  const Result<Accumulation> read = read_accumulation(path);
  ASSERT_TRUE(read.ok()) << read.error().message;
  expect_same(read.value().state, random_state(kSmall, kSmallArea, true, seed));
}

TEST_F(AccumulationFile, ComesBack) {
  const V2i size(200, 130); // planes of several blocks
  const PixelRect area{V2i(3, 5), V2i(197, 130)};
  for (const bool everything : {false, true}) {
    const RenderState state = random_state(size, area, everything, 4);
    const AccumulationIdentity identity = identity_of(size, area);
    const Result<void> written = write_accumulation(path_, identity, state, false);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const Result<Accumulation> read = read_accumulation(path_);
    ASSERT_TRUE(read.ok()) << read.error().message;
    expect_same(read.value().state, state);
    expect_same(read.value().identity, identity);
    const Result<AccumulationSummary> summary = read_accumulation_summary(path_);
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    expect_same(summary.value().identity, identity);
    EXPECT_EQ(summary.value().coverage, state.coverage);
    EXPECT_EQ(summary.value().work.thread_s, state.work.thread_s);
  }
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(AccumulationFile, OfNoPixelsComesBack) {
  const PixelRect none{V2i(5, 5), V2i(5, 5)};
  ASSERT_TRUE(write_accumulation(path_, identity_of(kSmall, kSmallArea),
                                 RenderState{Film(kSmall, none, {}), Coverage(none), {}, {}}, false));
  const Result<Accumulation> read = read_accumulation(path_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().state.coverage.block_count(), 0U);
}

// A film with few samples of a smooth picture: the upper bytes of sums are alike.
TEST_F(AccumulationFile, IsSmallerThanTheFilm) {
  const V2i size(128, 128);
  const PixelRect area{V2i(0), size};
  RenderState state{Film(size, area, {}), Coverage(area), {}, {}};
  std::mt19937 random(3);
  for (int i = 0; i < 16 * 128 * 128; ++i) {
    const float y = static_cast<float>(random()) * 0x1p-32f;
    state.film.add({i % 128, i / 128 % 128}, {Rgb(y, 0.5f * y * y, 0.1f * y), 1.0f, 1.0f});
  }
  ASSERT_TRUE(write_accumulation(path_, identity_of(size, area), state, false).ok());
  EXPECT_LT(fs::file_size(path_), state.film.memory_bytes() / 2);
}

TEST_F(AccumulationFile, EachFlippedBitIsFound) {
  write_small(path_);
  const std::string good = contents(path_);
  std::mt19937 random(8);
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](size_t at, char byte) { file.seekp(static_cast<std::streamoff>(at)).put(byte).flush(); };
  for (int i = 0; i < 500; ++i) {
    // A third each: anywhere, the header, the end.
    const size_t span = i % 3 == 0 ? good.size() : 1000;
    const size_t at = i % 3 == 2 ? good.size() - 1 - random() % span : random() % span;
    put(at, static_cast<char>(good[at] ^ (1 << random() % 8)));
    const Result<Accumulation> read = read_accumulation(path_);
    ASSERT_FALSE(read.ok()) << at;
    EXPECT_EQ(read.error().kind, ErrorKind::input_output);
    EXPECT_TRUE(read.error().message.starts_with(path_.string() + ": ")) << read.error().message;
    EXPECT_EQ(read.error().message.find('\n'), std::string::npos);
    put(at, good[at]);
  }
  expect_small(path_, 1);
}

TEST_F(AccumulationFile, EachCutIsFound) {
  write_small(path_);
  const std::string good = contents(path_);
  std::mt19937 random(9);
  std::vector<size_t> sizes{
      0, 1, 7, 8, 12, 16, 19, 20, 21, good.size() - 1, good.size() - 23, good.size() - 24, good.size() - 25};
  for (int i = 0; i < 200; ++i) sizes.push_back(random() % good.size());
  for (const size_t size : sizes) {
    set_contents(path_, std::string_view(good).substr(0, size));
    const Result<Accumulation> read = read_accumulation(path_);
    ASSERT_FALSE(read.ok()) << size;
    // The places of the blocks are checked there too.
    EXPECT_FALSE(read_accumulation_summary(path_).ok()) << size;
  }
  set_contents(path_, good + "x");
  EXPECT_FALSE(read_accumulation(path_).ok());
}

TEST_F(AccumulationFile, ErrorsNameThePlace) {
  write_small(path_);
  const std::string good = contents(path_);
  const auto message_of = [&](const std::string& bytes) {
    set_contents(path_, bytes);
    const Result<Accumulation> read = read_accumulation(path_);
    EXPECT_FALSE(read.ok());
    return read.ok() ? "" : read.error().message.substr(path_.string().size() + 2);
  };
  EXPECT_EQ(message_of("KND"), "is not an accumulation file: it is too short");
  EXPECT_EQ(message_of("KNDLRAYS" + good.substr(8)), "is not an accumulation file: it does not begin with KNDLACCU");
  std::string bad = good;
  bad[8] = 2;
  EXPECT_EQ(message_of(bad), "is an accumulation file of version 2; this program reads version 1");
  bad = good;
  bad[30] ^= 1;
  EXPECT_NE(message_of(bad).find("its header (bytes 0 to "), std::string::npos) << message_of(bad);
  bad = good;
  bad[bad.size() - 1000] ^= 1;
  EXPECT_NE(message_of(bad).find("(of plane 'earlier', at byte "), std::string::npos) << message_of(bad);
  EXPECT_NE(message_of(good.substr(0, good.size() / 2)).find("is cut off: it ends at byte "), std::string::npos);
  EXPECT_NE(message_of(good.substr(0, good.size() - 24)).find("is cut off: it ends at byte "), std::string::npos);
}

TEST_F(AccumulationFile, WhatIsNoFileIsRefused) {
  EXPECT_FALSE(read_accumulation(folder_ / "none.kacc").ok());
  EXPECT_FALSE(read_accumulation(folder_).ok());
  EXPECT_FALSE(read_accumulation("/dev/zero").ok());
  EXPECT_FALSE(write_accumulation(folder_ / "none" / "a.kacc", identity_of(kSmall, kSmallArea),
                                  random_state(kSmall, kSmallArea, false, 1), true)
                   .ok());
}

TEST_F(AccumulationFile, PreviousOneIsKept) {
  write_small(path_, 1, true);
  EXPECT_EQ(files_in_folder(), 1U);
  write_small(path_, 2, true);
  expect_small(path_, 2);
  expect_small(previous_accumulation(path_), 1);
  write_small(path_, 3, true);
  expect_small(path_, 3);
  expect_small(previous_accumulation(path_), 2);
  write_small(path_, 4, false);
  expect_small(path_, 4);
  expect_small(previous_accumulation(path_), 2);
  // A writer that was killed between the two renames leaves one file of two names.
  fs::remove(previous_accumulation(path_));
  fs::create_hard_link(path_, previous_accumulation(path_));
  write_small(path_, 5, true);
  expect_small(path_, 5);
  expect_small(previous_accumulation(path_), 4);
  EXPECT_EQ(files_in_folder(), 2U);
}

TEST_F(AccumulationFile, LinksAreFollowed) {
  fs::create_directories(folder_ / "elsewhere");
  const fs::path target = folder_ / "elsewhere" / "real.kacc";
  write_small(target, 1);
  fs::create_symlink(target, path_);
  write_small(path_, 2, true);
  EXPECT_TRUE(fs::is_symlink(path_));
  expect_small(target, 2);
  EXPECT_EQ(previous_accumulation(path_), fs::weakly_canonical(target) += ".previous");
  expect_small(previous_accumulation(path_), 1);
}

// The old file stays, and nothing else.
void expect_failed_write(const fs::path& path, const char* reason) {
  const Result<void> written =
      write_accumulation(path, identity_of(kSmall, kSmallArea), random_state(kSmall, kSmallArea, true, 2), true);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().kind, ErrorKind::input_output);
  EXPECT_EQ(written.error().message, path.string() + ": cannot write: " + reason);
  expect_small(path, 1);
}

TEST_F(AccumulationFile, LimitOfFileSizeLeavesTheOldOne) {
  write_small(path_, 1);
  const auto size = fs::file_size(path_);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  for (const rlim_t limit : {rlim_t{0}, rlim_t{100}, size / 2, size - 1}) {
    const rlimit small{limit, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    expect_failed_write(path_, std::strerror(EFBIG));
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(files_in_folder(), 1U);
  }
  std::signal(SIGXFSZ, SIG_DFL);
}

TEST_F(AccumulationFile, FullDiskLeavesTheOldOne) {
  // In a namespace of its own, which ends with the thread.
  bool mounted = false;
  std::thread([&] {
    if (unshare(CLONE_NEWNS | CLONE_FS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=1024k") != 0)
      return;
    mounted = true;
    write_small(path_, 1);
    // Too little is left for a second one of 0.5 MB.
    set_contents(folder_ / "filler", std::string((size_t{1} << 20) - 3 * fs::file_size(path_) / 2, 'x'));
    expect_failed_write(path_, std::strerror(ENOSPC));
    EXPECT_EQ(files_in_folder(), 2U);
    fs::remove(folder_ / "filler");
    EXPECT_FALSE(fs::exists(previous_accumulation(path_)));
    write_small(path_, 3);
    expect_small(path_, 3);
    umount2(folder_.c_str(), MNT_DETACH);
  }).join();
  if (!mounted) GTEST_SKIP() << "a small disk can be had by root alone";
}

// What the test below kills: writes for as long as it is let.
void write_for_ever(const char* path) {
  const AccumulationIdentity identity = identity_of(kSmall, kSmallArea);
  RenderState state = random_state(kSmall, kSmallArea, true, 1);
  for (uint32_t runs = 1;; ++runs) {
    state.work.runs = runs;
    std::ranges::fill(state.film.planes()[0].bytes, static_cast<std::byte>(runs));
    if (!write_accumulation(path, identity, state, true).ok()) return;
  }
}

TEST_F(AccumulationFile, KilledWritersLeaveAGoodFile) {
  write_small(path_, 1);
  setenv(kWriterVariable, path_.c_str(), 1);
  std::mt19937 random(12);
  size_t leftovers = 0;
  for (int i = 0; i < 50; ++i) {
    const auto before = fs::last_write_time(path_);
    const pid_t writer = fork();
    if (writer == 0) {
      execl("/proc/self/exe", "writer", nullptr);
      _exit(127);
    }
    // Once it is at work, at any moment.
    for (int wait = 0; wait < 10000 && fs::last_write_time(path_) == before; ++wait) usleep(1000);
    ASSERT_NE(fs::last_write_time(path_), before);
    usleep(random() % 15000);
    kill(writer, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(writer, &status, 0), writer);
    ASSERT_TRUE(WIFSIGNALED(status)) << status;
    leftovers = std::max(leftovers, files_in_folder() - 2);
    for (const fs::path& path : {path_, previous_accumulation(path_)}) {
      const Result<Accumulation> read = read_accumulation(path);
      ASSERT_TRUE(read.ok()) << read.error().message;
      const uint32_t runs = read.value().state.work.runs;
      if (runs == 3) continue; // perhaps the first one, of random bytes
      for (const std::byte byte : read.value().state.film.planes()[0].bytes)
        ASSERT_EQ(byte, static_cast<std::byte>(runs));
    }
  }
  unsetenv(kWriterVariable);
  EXPECT_GE(leftovers, 1U); // some were killed while they wrote
  EXPECT_LE(leftovers, 2U); // a temporary file, and perhaps the second name of the old one
  write_small(path_, 2, true);
  EXPECT_EQ(files_in_folder(), 2U);
}

} // namespace
} // namespace kindling

// The program itself is the writer: a fork of the test would lack the threads that compress.
int main(int argc, char** argv) {
  if (const char* path = std::getenv(kindling::kWriterVariable)) {
    kindling::write_for_ever(path);
    return 1;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
