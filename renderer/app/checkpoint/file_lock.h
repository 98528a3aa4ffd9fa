// One process at a time: a lock that ends with the process that holds it, however it ends.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>

namespace kindling::app {

// Holds "FILE.lock", which is locked by flock() and removed at the end; what a killed process leaves is locked by nobody. Where the file
// system has no locks nothing is locked.
class FileLock {
 public:
  // Fails (input_output) if another process holds it, with who does, or if the lock file cannot be made.
  [[nodiscard]] static Result<FileLock> acquire(const std::filesystem::path& file);

  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  FileLock(int descriptor, std::filesystem::path path);
  int descriptor_ = -1;
  std::filesystem::path path_;
};

} // namespace kindling::app
