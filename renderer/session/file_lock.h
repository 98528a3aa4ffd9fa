// A lock on a file by one process at a time, released when the process ends for any reason.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>

namespace kindling {

// Holds "FILE.lock", locked by flock() and removed at the end. A lock file that a killed process
// leaves behind is not locked. On file systems without locks nothing is locked. FILE is the end of
// symbolic links, so that all names of a file share a lock; links in place of the lock are refused.
class FileLock {
 public:
  // Fails (input_output) if another process holds the lock, naming it, or if the lock file cannot
  // be created.
  [[nodiscard]] static Result<FileLock> acquire(const std::filesystem::path& file);

  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  FileLock(int descriptor, std::filesystem::path path);
  int descriptor_ = -1;
  std::filesystem::path path_;
};

} // namespace kindling
