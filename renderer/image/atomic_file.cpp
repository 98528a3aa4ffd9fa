// Temporary name, fsync, rename, fsync of the folder.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/atomic_file.h"

#include <fmt/format.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kindling {

namespace {

namespace fs = std::filesystem;

Error cannot_write(const fs::path& path, std::string_view why) {
  return Error{ErrorKind::input_output, fmt::format("{}: cannot write: {}", path.string(), why)};
}

// The rename is only durable once the folder is.
void sync_folder(const fs::path& folder) {
  if (const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); fd >= 0) {
    fsync(fd);
    close(fd);
  }
}

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

// Of the name (FNV-1a), so that the leftovers of one file are known.
std::string temporary_prefix(const fs::path& target) {
  uint64_t hash = 0xcbf29ce484222325;
  const std::string name = target.filename().string();
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return fmt::format(".kindling-{:016x}-", hash);
}

// A new file, locked for as long as a descriptor of it is open; below 0: errno says why not.
int create_locked(const fs::path& path) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) return fd;
  struct stat status {};
  // Who removes leftovers may have been quicker with the lock.
  const bool taken = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (!taken && (fstat(fd, &status) != 0 || status.st_nlink > 0)) return fd;
  close(fd);
  errno = EEXIST;
  return -1;
}

// As AtomicFile::commit() has it: 0, or errno.
int keep_and_rename(const fs::path& temporary, const fs::path& target, const fs::path& previous) {
  const auto rename_to = [](const fs::path& from, const fs::path& to) {
    return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
  };
  if (previous.empty() || access(target.c_str(), F_OK) != 0) return rename_to(temporary, target);
  // A second name for the old file, which then takes the place of the one before it: the target is there all the time.
  const fs::path second = fs::path(temporary) += ".previous";
  for (int attempt = 0; attempt < 3 && link(target.c_str(), second.c_str()) == 0; ++attempt) {
    const int error = rename_to(second, previous);
    unlink(second.c_str());        // nothing was renamed where both were the same file already
    if (error == ENOENT) continue; // who removes leftovers was quicker
    return error != 0 ? error : rename_to(temporary, target);
  }
  // No such links here: for a moment there is the previous name alone.
  if (const int error = rename_to(target, previous); error != 0) return error;
  const int error = rename_to(temporary, target);
  if (error != 0) rename_to(previous, target);
  return error;
}

} // namespace

AtomicFile::AtomicFile(std::FILE* file, int lock, fs::path target, fs::path temporary)
    : file_(file), lock_(lock), target_(std::move(target)), temporary_(std::move(temporary)) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : file_(std::exchange(other.file_, nullptr)), lock_(std::exchange(other.lock_, -1)), error_(other.error_),
      target_(std::move(other.target_)), temporary_(std::move(other.temporary_)) {}

AtomicFile::~AtomicFile() {
  if (file_) {
    std::fclose(file_);
    unlink(temporary_.c_str());
  }
  if (lock_ >= 0) close(lock_);
}

fs::path AtomicFile::target_of(const fs::path& path) {
  std::error_code code;
  if (!fs::is_symlink(path, code)) return path;
  fs::path target = fs::weakly_canonical(path, code);
  return code ? path : target;
}

Result<AtomicFile> AtomicFile::create(const fs::path& path) {
  if (path.empty() || !path.has_filename()) return cannot_write(path, "this names no file");
  std::error_code code;
  const fs::path target = target_of(path);
  if (fs::exists(target, code) && !fs::is_regular_file(target, code)) {
    return cannot_write(path, "it exists and is not a regular file");
  }
  const fs::path folder = folder_of(target);
  if (!fs::is_directory(folder, code))
    return cannot_write(path, fmt::format("there is no folder '{}'", folder.string()));

  static std::atomic<unsigned> counter{0};
  fs::path temporary;
  int fd = -1;
  // A process of the same number on another machine may have taken a name.
  for (int attempt = 0; attempt < 1000 && fd < 0; ++attempt) {
    temporary = folder / fmt::format("{}{}-{}.tmp", temporary_prefix(target), getpid(), counter++);
    fd = create_locked(temporary);
    if (fd < 0 && errno != EEXIST) break;
  }
  if (fd < 0) return cannot_write(path, std::strerror(errno));
  const int lock = fcntl(fd, F_DUPFD_CLOEXEC, 0);
  std::FILE* file = lock >= 0 ? fdopen(fd, "wb") : nullptr;
  if (!file) {
    const int error = errno;
    close(fd);
    if (lock >= 0) close(lock);
    unlink(temporary.c_str());
    return cannot_write(path, std::strerror(error));
  }
  return AtomicFile(file, lock, target, temporary);
}

void AtomicFile::remove_leftovers(const fs::path& path) {
  const fs::path target = target_of(path);
  const std::string prefix = temporary_prefix(target);
  std::error_code code;
  for (fs::directory_iterator i(folder_of(target), code), end; !code && i != end; i.increment(code)) {
    if (!i->path().filename().native().starts_with(prefix)) continue;
    const int fd =
        open(i->path().c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC); // some file systems lock for writing only
    if (fd < 0) continue;
    if (flock(fd, LOCK_EX | LOCK_NB) == 0) unlink(i->path().c_str());
    close(fd);
  }
}

void AtomicFile::write(const void* data, size_t size) {
  // fwrite() takes no null pointer, and an empty vector's data() may be one.
  if (error_ == 0 && size > 0 && std::fwrite(data, 1, size, file_) != size) error_ = errno;
}

void AtomicFile::seek(int64_t offset) {
  if (error_ == 0 && fseeko(file_, offset, SEEK_SET) != 0) error_ = errno;
}

Result<void> AtomicFile::commit(const fs::path& previous) {
  const auto check = [this](bool good) {
    if (!good && error_ == 0) error_ = errno;
  };
  check(std::fflush(file_) == 0);
  check(fsync(fileno(file_)) == 0);
  check(std::fclose(std::exchange(file_, nullptr)) == 0);
  if (error_ == 0) error_ = keep_and_rename(temporary_, target_, previous);
  if (error_ != 0) {
    unlink(temporary_.c_str());
    return cannot_write(target_, std::strerror(error_));
  }
  sync_folder(folder_of(target_));
  return {};
}

Result<void> check_writable(const fs::path& path) {
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorKind::input_output, fmt::format("{}: {}", path.string(), why)};
  };
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return refuse("is a folder; use the name of a file");
  const fs::path folder = folder_of(path);
  if (!fs::exists(folder, ignored))
    return refuse(fmt::format("folder '{}' does not exist; create it first", folder.string()));
  if (!fs::is_directory(folder, ignored)) return refuse(fmt::format("'{}' is not a folder", folder.string()));
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return refuse(fmt::format("folder '{}' cannot be written to", folder.string()));
  return {};
}

} // namespace kindling
