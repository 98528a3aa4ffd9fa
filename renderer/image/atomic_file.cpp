// Atomic replacement of files: temporary name, fsync, rename, fsync of the folder.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/atomic_file.h"

#include <fmt/format.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

namespace kindling {

namespace {

namespace fs = std::filesystem;

Error cannot_write(const fs::path& path, std::string_view why) {
  return Error{ErrorKind::input_output, fmt::format("{}: cannot write: {}", path.string(), why)};
}

// Syncs a folder, without which a rename in it is not durable.
void sync_folder(const fs::path& folder) {
  if (const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); fd >= 0) {
    fsync(fd);
    close(fd);
  }
}

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

// Returns the prefix of temporary names for a target, from a hash of its name (FNV-1a), by which
// leftovers are recognized.
std::string temporary_prefix(const fs::path& target) {
  uint64_t hash = 0xcbf29ce484222325;
  const std::string name = target.filename().string();
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return fmt::format(".kindling-{:016x}-", hash);
}

// Creates a new file that is locked while one of its descriptors is open. Returns the descriptor;
// negative on failure, with the reason in errno.
int create_locked(const fs::path& path, mode_t mode) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NONBLOCK, mode);
  if (fd < 0) return fd;
  struct stat status {};
  // A process that removes leftovers may have locked or removed the file first.
  const bool taken = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (!taken && (fstat(fd, &status) != 0 || status.st_nlink > 0)) return fd;
  close(fd);
  errno = EEXIST;
  return -1;
}

// Copies an extended attribute; failures are ignored, since file systems differ in what they allow.
void copy_attribute(const char* from, int to, const char* name) {
  std::vector<char> value(1 << 16);
  const ssize_t size = getxattr(from, name, value.data(), value.size());
  if (size >= 0) fsetxattr(to, name, value.data(), static_cast<size_t>(size), 0);
}

// Gives a file in the making the owner, group, mode, access list and extended attributes of the
// file that it will replace, as far as the process may.
void keep_attributes(const fs::path& old, int fd) {
  struct stat status {};
  if (stat(old.c_str(), &status) != 0) return;
  mode_t mode = status.st_mode & 07777;
  if (fchown(fd, status.st_uid, status.st_gid) != 0 && fchown(fd, static_cast<uid_t>(-1), status.st_gid) != 0) {
    struct stat own {};
    // Another group than the old one may do no more than everybody.
    if (fstat(fd, &own) != 0 || own.st_gid != status.st_gid)
      mode &= ~static_cast<mode_t>(S_IRWXG & ~((status.st_mode & S_IRWXO) << 3));
  }
  fchmod(fd, mode);
  copy_attribute(old.c_str(), fd, "system.posix_acl_access");
  std::vector<char> names(1 << 16);
  const ssize_t size = listxattr(old.c_str(), names.data(), names.size());
  for (ssize_t at = 0; at < size; at += static_cast<ssize_t>(std::strlen(names.data() + at)) + 1)
    if (std::string_view(names.data() + at).starts_with("user.")) copy_attribute(old.c_str(), fd, names.data() + at);
}

// Renames as described at AtomicFile::commit(); returns 0 or errno.
int rename_with_backup(const fs::path& temporary, const fs::path& target, const fs::path& previous) {
  const auto rename_to = [](const fs::path& from, const fs::path& to) {
    return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
  };
  if (previous.empty() || access(target.c_str(), F_OK) != 0) return rename_to(temporary, target);
  // A second link to the old file replaces the previous backup, so the target exists at all times.
  const fs::path second = fs::path(temporary) += ".previous";
  for (int attempt = 0; attempt < 3 && link(target.c_str(), second.c_str()) == 0; ++attempt) {
    const int error = rename_to(second, previous);
    unlink(second.c_str());        // rename() does nothing if both names are links to one file
    if (error == ENOENT) continue; // another process removed the link as a leftover
    return error != 0 ? error : rename_to(temporary, target);
  }
  // Without hard links, only the backup exists for a moment.
  if (const int error = rename_to(target, previous); error != 0) return error;
  const int error = rename_to(temporary, target);
  if (error != 0) rename_to(previous, target);
  return error;
}

// Copies all of `file` to standard output; 0, or errno.
int copy_to_standard_output(std::FILE* file) {
  std::rewind(file);
  char piece[65536];
  for (size_t count = 0; (count = std::fread(piece, 1, sizeof piece, file)) > 0;)
    for (size_t done = 0; done < count;) {
      const ssize_t written = ::write(STDOUT_FILENO, piece + done, count - done);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      done += static_cast<size_t>(written);
    }
  return std::ferror(file) != 0 ? EIO : 0;
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
    if (!temporary_.empty()) unlink(temporary_.c_str());
  }
  if (lock_ >= 0) close(lock_);
}

Result<AtomicFile> AtomicFile::create(const fs::path& path) {
  if (path.empty() || !path.has_filename()) return cannot_write(path, "the path has no file name");
  if (path == kStandardOutput) {
    // In memory: the folder of temporary files may be missing or full.
    const int fd = memfd_create("kindling-output", MFD_CLOEXEC);
    std::FILE* file = fd >= 0 ? fdopen(fd, "wb+") : nullptr;
    if (!file) {
      const int error = errno;
      if (fd >= 0) close(fd);
      return Error{ErrorKind::input_output,
                   fmt::format("standard output: no file in memory: {}", std::strerror(error))};
    }
    return AtomicFile(file, -1, path, {});
  }
  std::error_code code;
  const fs::path target = end_of_links(path);
  if (fs::exists(target, code) && !fs::is_regular_file(target, code)) {
    return cannot_write(path, "it exists and is not a regular file");
  }
  const fs::path folder = folder_of(target);
  if (!fs::is_directory(folder, code))
    return cannot_write(path, fmt::format("the folder '{}' does not exist", folder.string()));

  static std::atomic<unsigned> counter{0};
  fs::path temporary;
  int fd = -1;
  // A process with the same id on another machine may already use a name.
  for (int attempt = 0; attempt < 1000 && fd < 0; ++attempt) {
    temporary = folder / fmt::format("{}{}-{}.tmp", temporary_prefix(target), getpid(), counter++);
    fd = create_locked(temporary, fs::exists(target, code) ? S_IRUSR | S_IWUSR : 0666);
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
  const fs::path target = end_of_links(path);
  const std::string prefix = temporary_prefix(target);
  std::error_code code;
  for (fs::directory_iterator i(folder_of(target), code), end; !code && i != end; i.increment(code)) {
    if (!i->path().filename().native().starts_with(prefix)) continue;
    // Some file systems require write access for locks. O_NONBLOCK: a pipe of this name fails.
    const int fd = open(i->path().c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) continue;
    struct stat status {};
    const bool is_file = fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
    if (is_file && flock(fd, LOCK_EX | LOCK_NB) == 0) unlink(i->path().c_str());
    close(fd);
  }
}

void AtomicFile::write(const void* data, size_t size) {
  // The data() of an empty vector may be null, which fwrite() does not accept.
  if (error_ == 0 && size > 0 && std::fwrite(data, 1, size, file_) != size) error_ = errno;
}

void AtomicFile::seek(int64_t offset) {
  if (error_ == 0 && fseeko(file_, offset, SEEK_SET) != 0) error_ = errno;
}

Result<void> AtomicFile::commit(const fs::path& previous) {
  if (temporary_.empty()) return commit_to_standard_output();
  const auto check = [this](bool good) {
    if (!good && error_ == 0) error_ = errno;
  };
  check(std::fflush(file_) == 0);
  if (error_ == 0) keep_attributes(target_, fileno(file_));
  check(fsync(fileno(file_)) == 0);
  check(std::fclose(std::exchange(file_, nullptr)) == 0);
  if (error_ == 0) error_ = rename_with_backup(temporary_, target_, previous);
  if (error_ != 0) {
    unlink(temporary_.c_str());
    return cannot_write(target_, std::strerror(error_));
  }
  sync_folder(folder_of(target_));
  return {};
}

Result<void> AtomicFile::commit_to_standard_output() {
  if (error_ == 0 && std::fflush(file_) != 0) error_ = errno;
  if (error_ == 0) error_ = copy_to_standard_output(file_);
  std::fclose(std::exchange(file_, nullptr));
  if (error_ == 0) return {};
  return Error{ErrorKind::input_output, fmt::format("standard output: cannot write: {}", std::strerror(error_))};
}

} // namespace kindling
