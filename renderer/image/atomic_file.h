// A file that appears under its name only when it is complete: written beside it, synced, then renamed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>

namespace kindling {

// Destroyed without commit(): the temporary file is removed and what stood under the name stays.
class AtomicFile {
 public:
  // Follows symbolic links. Refuses a target that exists and is not a regular file (a folder, a device).
  [[nodiscard]] static Result<AtomicFile> create(const std::filesystem::path& path);

  // After a first failure nothing more is written; commit() then gives its reason.
  void write(const void* data, size_t size);
  void seek(int64_t offset);

  [[nodiscard]] bool failed() const { return error_ != 0; }

  // Flushes to the disk and renames. An error leaves the old file. With `previous`, a name in the same folder, what stood under the name
  // until then gets that name: at every moment at least one of the two is there and complete.
  [[nodiscard]] Result<void> commit(const std::filesystem::path& previous = {});

  // What a symbolic link leads to, else the name itself: where create() puts the file.
  [[nodiscard]] static std::filesystem::path target_of(const std::filesystem::path& path);
  // Removes the temporary files of writers of `path` that were killed. Those of living writers, here or on another machine, are locked
  // and stay; where the file system knows no locks, all do.
  static void remove_leftovers(const std::filesystem::path& path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

 private:
  AtomicFile(std::FILE* file, int lock, std::filesystem::path target, std::filesystem::path temporary);

  std::FILE* file_ = nullptr;
  int lock_ = -1; // a second descriptor, which holds the lock until the name is final
  int error_ = 0; // errno of the first failure
  std::filesystem::path target_;
  std::filesystem::path temporary_;
};

// Checks that a file can be created at `path`, or replaced. Fails (input_output) if it is a folder, or if its
// folder does not exist or is not writable.
[[nodiscard]] Result<void> check_writable(const std::filesystem::path& path);

} // namespace kindling
