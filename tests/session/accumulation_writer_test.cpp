// A complete accumulation file exists at every moment, on full disks and with killed writers.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/test_accumulation.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <random>
#include <thread>

#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kindling::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWriterVariable = "KINDLING_TEST_ACCUMULATION_WRITER";

class AccumulationWriter : public AccumulationFolder {};

TEST_F(AccumulationWriter, KeepsPreviousFile) {
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
  // A writer killed between the two renames leaves one file with two names.
  fs::remove(previous_accumulation(path_));
  fs::create_hard_link(path_, previous_accumulation(path_));
  write_small(path_, 5, true);
  expect_small(path_, 5);
  expect_small(previous_accumulation(path_), 4);
  EXPECT_EQ(files_in_folder(), 2U);
}

TEST_F(AccumulationWriter, FollowsLinks) {
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

// Checks that the old file stays, and nothing else.
void expect_failed_write(const fs::path& path, const char* reason) {
  const Result<void> written =
      write_accumulation(path, identity_of(kSmall, kSmallArea), random_state(kSmall, kSmallArea, true, 2), true);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().kind, ErrorKind::input_output);
  EXPECT_EQ(written.error().message, path.string() + ": cannot write: " + reason);
  expect_small(path, 1);
}

TEST_F(AccumulationWriter, FileSizeLimitKeepsOldFile) {
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

TEST_F(AccumulationWriter, FullDiskKeepsOldFile) {
  // In a mount namespace that ends with the thread.
  bool mounted = false;
  std::thread([&] {
    if (unshare(CLONE_NEWNS | CLONE_FS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=4096k") != 0)
      return;
    mounted = true;
    write_small(path_, 1);
    // Leaves too little room for a second file.
    set_contents(folder_ / "filler", std::string((size_t{4} << 20) - 3 * fs::file_size(path_) / 2, 'x'));
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

// The process that the test below kills: writes until then.
void write_for_ever(const char* path) {
  const AccumulationIdentity identity = identity_of(kSmall, kSmallArea);
  RenderState state = random_state(kSmall, kSmallArea, true, 1);
  for (uint32_t runs = 1;; ++runs) {
    state.work.runs = runs;
    std::ranges::fill(state.film.planes()[0].bytes, static_cast<std::byte>(runs));
    if (!write_accumulation(path, identity, state, true).ok()) return;
  }
}

TEST_F(AccumulationWriter, KilledWritersLeaveCompleteFile) {
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
    // At a random moment after it has started.
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
      if (runs == 3) continue; // may be the first file, of random bytes
      const std::vector<Film::ConstPlane> planes = read.value().state.film.planes();
      ASSERT_FALSE(planes[0].bytes.empty());
      for (const std::byte byte : planes[0].bytes) ASSERT_EQ(byte, static_cast<std::byte>(runs));
    }
  }
  unsetenv(kWriterVariable);
  EXPECT_GE(leftovers, 1U); // some were killed while writing
  EXPECT_LE(leftovers, 2U); // a temporary file, and possibly the second name of the old one
  write_small(path_, 2, true);
  EXPECT_EQ(files_in_folder(), 2U);
}

} // namespace
} // namespace kindling::test

// The writer is this program started again: a fork of the test would lack the threads that
// compress.
int main(int argc, char** argv) {
  if (const char* path = std::getenv(kindling::test::kWriterVariable)) {
    kindling::test::write_for_ever(path);
    return 1;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
