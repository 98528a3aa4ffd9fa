// Locks a file beside the protected one, which is replaced by renaming and would lose its lock.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/file_lock.h"

#include "renderer/base/text.h"
#include "renderer/image/output_file.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kindling {

namespace fs = std::filesystem;

namespace {

// Returns whether the name still refers to the open file: another process may have removed it
// before we locked it.
bool is_current(int descriptor, const fs::path& path) {
  struct stat open_file {};
  struct stat named_file {};
  return fstat(descriptor, &open_file) == 0 && lstat(path.c_str(), &named_file) == 0 &&
         open_file.st_ino == named_file.st_ino && open_file.st_dev == named_file.st_dev;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

// Returns "process 17 on node3", as the process that holds the lock wrote it.
std::string read_owner(int descriptor) {
  std::array<char, 300> text{};
  const ssize_t size = pread(descriptor, text.data(), text.size() - 1, 0);
  return size > 0 ? printable(text.data()) : "another process";
}

} // namespace

FileLock::FileLock(int descriptor, fs::path path) : descriptor_(descriptor), path_(std::move(path)) {}

FileLock::FileLock(FileLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

FileLock::~FileLock() {
  if (descriptor_ < 0) return;
  unlink(path_.c_str()); // before the lock is released
  close(descriptor_);
}

Result<FileLock> FileLock::acquire(const fs::path& file) {
  const fs::path path = end_of_links(file) += ".lock"; // one lock for all names of a file
  const auto failed = [&](std::string_view why) {
    return Error{ErrorKind::input_output, fmt::format("{}: cannot be created: {}", path.string(), why)};
  };
  for (;;) {
    // Writing through a link, or to a pipe, would change another file or block.
    const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (descriptor < 0)
      return failed(errno == ELOOP ? "a symbolic link has its name; remove it" : std::strerror(errno));
    struct stat status {};
    if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
      close(descriptor);
      return failed("something else than a file has its name; remove it");
    }
    FileLock lock(descriptor, path);
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      const std::string owner = read_owner(descriptor);
      close(std::exchange(lock.descriptor_, -1));
      return Error{
          ErrorKind::input_output,
          fmt::format("{}: {} is rendering to it; wait for it to end, or use another file name", file.string(), owner)};
    }
    if (!is_current(descriptor, path)) {
      close(std::exchange(lock.descriptor_, -1));
      continue;
    }
    const std::string owner = fmt::format("process {} on {}", getpid(), host_name());
    if (ftruncate(descriptor, 0) == 0) // on a full disk messages lack the name, no more
        [[maybe_unused]]
      const ssize_t written = pwrite(descriptor, owner.data(), owner.size(), 0);
    return lock;
  }
}

} // namespace kindling
