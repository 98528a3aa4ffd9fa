// Tests of names of output files, and of what a replaced file keeps.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/output_file.h"

#include "renderer/image/atomic_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <string>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/xattr.h>
#include <unistd.h>

namespace kindling {
namespace {

namespace fs = std::filesystem;

class OutputFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / ("kindling_out_" + std::string(info->name()) + std::to_string(getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    folder_ = fs::canonical(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path at(const std::string& name) const { return folder_ / name; }
  void write(const std::string& name, const std::string& text = "old") const { std::ofstream(at(name)) << text; }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream file(at(name));
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  [[nodiscard]] mode_t mode(const fs::path& path) const {
    struct stat status {};
    EXPECT_EQ(lstat(path.c_str(), &status), 0);
    return status.st_mode & 07777;
  }

  fs::path folder_;
};

void replace(const fs::path& path) {
  Result<AtomicFile> file = AtomicFile::create(path);
  ASSERT_TRUE(file.ok()) << file.error().message;
  file.value().write("new", 3);
  const Result<void> done = file.value().commit();
  EXPECT_TRUE(done.ok()) << done.error().message;
}

TEST_F(OutputFile, RefusesPipesFoldersAndDevices) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  at("socket").string().copy(address.sun_path, sizeof address.sun_path - 1);
  const bool bound = bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  fs::create_directory(at("folder"));
  fs::create_symlink("pipe", at("link"));
  fs::create_symlink("loop", at("loop"));
  const auto message = [](const fs::path& path) {
    const Result<void> result = check_writable(path);
    EXPECT_FALSE(result.ok()) << path;
    if (result.ok()) return std::string();
    EXPECT_EQ(result.error().kind, ErrorKind::input_output);
    return result.error().message.substr(path.native().size());
  };
  EXPECT_EQ(message(at("pipe")), ": is a pipe; use the name of a file");
  EXPECT_EQ(message(at("link")), ": is a pipe; use the name of a file");
  if (bound) {
    EXPECT_EQ(message(at("socket")), ": is a socket; use the name of a file");
  }
  EXPECT_EQ(message("/dev/null"), ": is a device; use the name of a file");
  EXPECT_EQ(message(at("folder")), ": is a folder; use the name of a file");
  EXPECT_EQ(message(at("loop")), ": is a symbolic link in a loop of links; use the name of a file");
  for (const char* name : {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"})
    EXPECT_EQ(message(name), ": names an open file of a process; use the name of a file, or - for standard output");
  close(listener);
}

TEST_F(OutputFile, AcceptsFilesAndStandardOutput) {
  write("old");
  fs::create_symlink("old", at("link"));
  fs::create_symlink("new", at("dangling"));
  for (const fs::path& path : {at("old"), at("link"), at("dangling"), at("fresh"), fs::path(kStandardOutput)})
    EXPECT_TRUE(check_writable(path).ok()) << path;
}

TEST_F(OutputFile, RefusesFoldersThatVanished) {
  const auto message = [](const fs::path& path) {
    const Result<void> result = check_writable(path);
    return result.ok() ? std::string() : result.error().message;
  };
  EXPECT_EQ(message(at("no/a.png")),
            at("no/a.png").string() + ": folder '" + at("no").string() + "' does not exist; create it first");
  fs::create_symlink("no/b.png", at("link"));
  EXPECT_NE(message(at("link")).find("no' does not exist"), std::string::npos);
  const fs::path before = fs::current_path();
  fs::create_directory(at("gone"));
  fs::current_path(at("gone"));
  fs::remove(at("gone"));
  EXPECT_EQ(message("a.png"), "a.png: folder '.' was deleted; use another one");
  fs::current_path(before);
}

TEST_F(OutputFile, RefusesNamesThatAreTooLong) {
  const auto message = [&](size_t length, std::span<const char* const> companions = {}) {
    const Result<void> result = check_writable(at(std::string(length, 'a')), companions);
    return result.ok() ? std::string() : result.error().message.substr(at("").native().size() + length);
  };
  const auto limit = static_cast<size_t>(pathconf(folder_.c_str(), _PC_NAME_MAX));
  EXPECT_EQ(message(limit), "");
  EXPECT_EQ(message(limit + 1),
            ": the name has " + std::to_string(limit + 1) + " bytes; use at most " + std::to_string(limit));
  constexpr std::array kEndings{".lock", ".previous"};
  EXPECT_EQ(message(limit - 9, kEndings), "");
  EXPECT_NE(message(limit - 8, kEndings), "");
  EXPECT_FALSE(check_writable(fs::path(folder_) / std::string(5000, '/') / "a.png").ok());
}

TEST_F(OutputFile, RefusesCompanionsThatAreNoFiles) {
  constexpr std::array kEndings{".lock", ".previous"};
  write("a.previous");
  EXPECT_TRUE(check_writable(at("a"), kEndings).ok());
  ASSERT_EQ(mkfifo(at("a.lock").c_str(), 0600), 0);
  EXPECT_EQ(check_writable(at("a"), kEndings).error().message,
            at("a").string() + ": 'a.lock' beside it is a pipe; remove it, or use another name");
  fs::create_symlink("a.lock", at("b.previous"));
  EXPECT_FALSE(check_writable(at("b"), kEndings).ok());
}

TEST_F(OutputFile, IdentityIsThatOfTheFile) {
  write("a");
  write("other");
  fs::create_hard_link(at("a"), at("hard"));
  fs::create_symlink("a", at("soft"));
  fs::create_directory(at("folder"));
  fs::create_symlink("folder", at("door"));
  fs::create_symlink("folder/new", at("dangling"));
  const FileIdentity a(at("a"));
  for (const fs::path& name : {at("hard"), at("soft"), at("folder/../a"), at("door/../a")})
    EXPECT_EQ(FileIdentity(name), a) << name;
  EXPECT_NE(FileIdentity(at("other")), a);
  const FileIdentity fresh(at("folder/new"));
  for (const fs::path& name : {at("door/new"), at("dangling"), at("folder/./new"), at("door/../folder/new")})
    EXPECT_EQ(FileIdentity(name), fresh) << name;
  EXPECT_NE(FileIdentity(at("new")), fresh);
}

TEST_F(OutputFile, ReplacedFileKeepsItsMode) {
  for (const mode_t wanted : {mode_t{0600}, mode_t{0640}, mode_t{0664}, mode_t{0755}, mode_t{0444}}) {
    write("a");
    ASSERT_EQ(chmod(at("a").c_str(), wanted), 0);
    replace(at("a"));
    EXPECT_EQ(mode(at("a")), wanted);
    EXPECT_EQ(read("a"), "new");
    fs::remove(at("a"));
  }
  const mode_t mask = umask(027);
  replace(at("fresh"));
  umask(mask);
  EXPECT_EQ(mode(at("fresh")), 0640U);
}

// A private file is not readable by others while its successor is written.
TEST_F(OutputFile, TemporaryFileIsAsPrivateAsTheOldOne) {
  write("a");
  ASSERT_EQ(chmod(at("a").c_str(), 0600), 0);
  Result<AtomicFile> file = AtomicFile::create(at("a"));
  ASSERT_TRUE(file.ok());
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_EQ(mode(entry.path()), 0600U) << entry.path();
}

TEST_F(OutputFile, ReplacedFileKeepsItsAttributes) {
  write("a");
  if (setxattr(at("a").c_str(), "user.shot", "12", 2, 0) != 0) {
    ASSERT_EQ(errno, ENOTSUP);
    GTEST_SKIP() << "this file system has no extended attributes";
  }
  replace(at("a"));
  std::array<char, 8> value{};
  EXPECT_EQ(getxattr(at("a").c_str(), "user.shot", value.data(), value.size()), 2);
}

// The link remains, and the file at its end is created.
TEST_F(OutputFile, FollowsDanglingLinks) {
  fs::create_directory(at("folder"));
  fs::create_symlink("folder/new", at("link"));
  replace(at("link"));
  EXPECT_TRUE(fs::is_symlink(at("link")));
  EXPECT_FALSE(fs::is_symlink(at("folder/new")));
  EXPECT_EQ(read("folder/new"), "new");
}

// A pipe with the name of a leftover blocks no save, and remains.
TEST_F(OutputFile, LeftoversThatArePipesRemain) {
  Result<AtomicFile> file = AtomicFile::create(at("a"));
  ASSERT_TRUE(file.ok());
  fs::path name = fs::directory_iterator(folder_)->path();
  ASSERT_EQ(mkfifo((name += "x").c_str(), 0600), 0);
  AtomicFile::remove_leftovers(at("a"));
  EXPECT_TRUE(fs::exists(name));
}

} // namespace
} // namespace kindling
