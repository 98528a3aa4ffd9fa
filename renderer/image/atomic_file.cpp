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

} // namespace

AtomicFile::AtomicFile(std::FILE* file, fs::path target, fs::path temporary)
    : file_(file), target_(std::move(target)), temporary_(std::move(temporary)) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : file_(std::exchange(other.file_, nullptr)), error_(other.error_), target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)) {}

AtomicFile::~AtomicFile() {
  if (!file_) return;
  std::fclose(file_);
  unlink(temporary_.c_str());
}

Result<AtomicFile> AtomicFile::create(const fs::path& path) {
  if (path.empty() || !path.has_filename()) return cannot_write(path, "this names no file");
  std::error_code code;
  const bool is_link = fs::is_symlink(path, code);
  const fs::path target = is_link ? fs::weakly_canonical(path, code) : path;
  if (is_link && code) return cannot_write(path, code.message());
  if (fs::exists(target, code) && !fs::is_regular_file(target, code)) {
    return cannot_write(path, "it exists and is not a regular file");
  }
  const fs::path folder = folder_of(target);
  if (!fs::is_directory(folder, code))
    return cannot_write(path, fmt::format("there is no folder '{}'", folder.string()));

  static std::atomic<unsigned> counter{0};
  const fs::path temporary = folder / fmt::format(".kindling-{}-{}.tmp", getpid(), counter++);
  const int fd = open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) return cannot_write(path, std::strerror(errno));
  std::FILE* file = fdopen(fd, "wb");
  if (!file) {
    const int error = errno;
    close(fd);
    unlink(temporary.c_str());
    return cannot_write(path, std::strerror(error));
  }
  return AtomicFile(file, target, temporary);
}

void AtomicFile::write(const void* data, size_t size) {
  if (error_ == 0 && std::fwrite(data, 1, size, file_) != size) error_ = errno;
}

void AtomicFile::seek(int64_t offset) {
  if (error_ == 0 && fseeko(file_, offset, SEEK_SET) != 0) error_ = errno;
}

Result<void> AtomicFile::commit() {
  const auto check = [this](bool good) {
    if (!good && error_ == 0) error_ = errno;
  };
  check(std::fflush(file_) == 0);
  check(fsync(fileno(file_)) == 0);
  check(std::fclose(std::exchange(file_, nullptr)) == 0);
  if (error_ == 0) check(std::rename(temporary_.c_str(), target_.c_str()) == 0);
  if (error_ != 0) {
    unlink(temporary_.c_str());
    return cannot_write(target_, std::strerror(error_));
  }
  sync_folder(folder_of(target_));
  return {};
}

} // namespace kindling
