// Files beside a checkpoint: one lock for all names, no links or pipes in its place.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/checkpoint.h"
#include "tests/session/test_accumulation.h"

#include <fstream>

#include <sys/stat.h>

namespace kindling::test {
namespace {

namespace fs = std::filesystem;

class CheckpointFiles : public AccumulationFolder {
 protected:
  [[nodiscard]] fs::path at(const std::string& name) const { return folder_ / name; }
};

TEST_F(CheckpointFiles, AllNamesShareOneLock) {
  write_small(at("real.kacc"), 1);
  fs::create_symlink("real.kacc", at("link.kacc"));
  const Result<FileLock> lock = FileLock::acquire(at("link.kacc"));
  ASSERT_TRUE(lock.ok()) << lock.error().message;
  EXPECT_TRUE(fs::exists(at("real.kacc.lock")));
  const Result<FileLock> second = FileLock::acquire(at("real.kacc"));
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find("is rendering to it"), std::string::npos) << second.error().message;
}

// Another user's link must not make us write to a file of ours, nor a pipe block us.
TEST_F(CheckpointFiles, LocksAreFiles) {
  std::ofstream(at("victim")) << "precious";
  fs::create_symlink("victim", at("a.kacc.lock"));
  fs::create_symlink("nothing", at("b.kacc.lock"));
  ASSERT_EQ(mkfifo(at("c.kacc.lock").c_str(), 0600), 0);
  for (const char* name : {"a.kacc", "b.kacc", "c.kacc"}) {
    const Result<FileLock> lock = FileLock::acquire(at(name));
    ASSERT_FALSE(lock.ok()) << name;
    EXPECT_EQ(lock.error().kind, ErrorKind::input_output);
    EXPECT_NE(lock.error().message.find("has its name; remove it"), std::string::npos) << lock.error().message;
  }
  EXPECT_EQ(fs::file_size(at("victim")), 8U);
  EXPECT_FALSE(fs::exists(at("nothing")));
}

// The damaged file is set aside where it is; the link to it remains.
TEST_F(CheckpointFiles, DamagedFileBehindALinkIsSetAside) {
  fs::create_directory(at("disk"));
  write_small(at("disk/real.kacc"), 1, true);
  write_small(at("disk/real.kacc"), 2, true);
  fs::resize_file(at("disk/real.kacc"), 100);
  fs::create_symlink("disk/real.kacc", at("link.kacc"));
  const auto opened = Checkpoint::open({.file = at("link.kacc")}, {});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  EXPECT_TRUE(fs::is_symlink(at("link.kacc")));
  EXPECT_TRUE(fs::exists(at("disk/real.kacc.damaged")));
  EXPECT_FALSE(fs::exists(at("link.kacc.damaged")));
}

} // namespace
} // namespace kindling::test
