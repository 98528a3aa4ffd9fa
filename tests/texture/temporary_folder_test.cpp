// Tests of temporary folders: which ones a process removes, and which it must not touch.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/temporary_folder.h"

#include "renderer/texture/texture_memory.h"
#include "tests/texture/redirected_tmpdir.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kindling {
namespace {

namespace fs = std::filesystem;

class TemporaryFolders : public test::RedirectedTmpdir {
 protected:
  // Returns the folder that a process has left: it was killed.
  [[nodiscard]] fs::path leave_folder() const {
    const pid_t child = fork();
    if (child == 0) {
      Result<TemporaryFolder> made = TemporaryFolder::create();
      if (made.ok()) std::ofstream(made.value().path() / "0.raw") << "texels";
      kill(getpid(), SIGKILL);
    }
    waitpid(child, nullptr, 0);
    for (const auto& entry : fs::directory_iterator(folder_)) return entry.path();
    return {};
  }
};

TEST_F(TemporaryFolders, NextProcessRemovesThoseOfKilledOnes) {
  const fs::path left = leave_folder();
  ASSERT_TRUE(fs::exists(left / "0.raw"));
  const TextureMemory memory(1);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(TemporaryFolders, FoldersInUseRemain) {
  Result<TemporaryFolder> made = TemporaryFolder::create();
  ASSERT_TRUE(made.ok()) << made.error().message;
  const fs::path path = made.value().path();
  std::ofstream(path / "0.raw") << "texels";
  TemporaryFolder::remove_leftovers();
  const pid_t child = fork(); // as another process sees it
  if (child == 0) {
    TemporaryFolder::remove_leftovers();
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(fs::exists(path / "0.raw"));
  { const TemporaryFolder moved = std::move(made).value(); }
  EXPECT_FALSE(fs::exists(path));
}

// Neither a link nor anything in it is touched, nor folders of other names or with folders in them.
TEST_F(TemporaryFolders, LinksAndForeignFoldersRemain) {
  const fs::path left = leave_folder();
  const fs::path precious = folder_ / "precious";
  fs::create_directories(precious);
  std::ofstream(precious / "file") << "work of a year";
  fs::path link = left;
  link += "link";
  fs::create_directory_symlink(precious, link);
  fs::create_symlink(precious / "file", left / "1.raw");
  fs::path nested = left;
  fs::create_directories((nested += "nested") / "folder");
  TemporaryFolder::remove_leftovers();
  EXPECT_TRUE(fs::exists(precious / "file"));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_FALSE(fs::exists(left / "0.raw"));
  EXPECT_TRUE(fs::exists(nested / "folder"));
}

// Creators and cleaners at once: a creator never loses its folder.
TEST_F(TemporaryFolders, CreationIsSafeAgainstRemoval) {
  std::vector<std::jthread> threads;
  int lost = 0;
  threads.emplace_back([](const std::stop_token& stop) {
    while (!stop.stop_requested()) TemporaryFolder::remove_leftovers();
  });
  for (int i = 0; i < 2000; ++i) {
    Result<TemporaryFolder> made = TemporaryFolder::create();
    lost += !made.ok() || !std::ofstream(made.value().path() / "0.raw");
  }
  threads.clear();
  EXPECT_EQ(lost, 0);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(TemporaryFolders, MissingFolderIsAnErrorOfTheMachine) {
  setenv("TMPDIR", (folder_ / "no").c_str(), 1);
  const Result<TemporaryFolder> made = TemporaryFolder::create();
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().kind, ErrorKind::input_output);
  EXPECT_EQ(made.error().message.find("no temporary folder in '" + (folder_ / "no").string() + "': "), 0U)
      << made.error().message;
  TemporaryFolder::remove_leftovers();
}

} // namespace
} // namespace kindling
