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

  // Flushes to the disk and renames. An error leaves the old file.
  [[nodiscard]] Result<void> commit();

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

 private:
  AtomicFile(std::FILE* file, std::filesystem::path target, std::filesystem::path temporary);

  std::FILE* file_ = nullptr;
  int error_ = 0; // errno of the first failure
  std::filesystem::path target_;
  std::filesystem::path temporary_;
};

} // namespace kindling
