// Files that appear under their name only when complete: written beside it, synced, then renamed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/image/output_file.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>

namespace kindling {

// A file that is replaced keeps its mode, and its owner, group, access list and extended attributes
// as far as the process may set them; of several hard links only this name gets the new file.
// If it is destroyed without commit(), the temporary file is removed and the old file remains.
class AtomicFile {
 public:
  // Creates the temporary file, which only its owner can read if the file exists. Symbolic links
  // are followed: the link remains, and the file at its end is created or replaced. A target that
  // exists and is not a regular file (a folder, a device) is refused. With the path kStandardOutput
  // the temporary file is in memory, and commit() copies it to standard output. Never blocks.
  [[nodiscard]] static Result<AtomicFile> create(const std::filesystem::path& path);

  // Write or move the position. After a first failure they do nothing, and commit() returns its
  // reason.
  void write(const void* data, size_t size);
  void seek(int64_t offset);

  [[nodiscard]] bool failed() const { return error_ != 0; }

  // Flushes to the disk and renames. On an error the old file remains. With `previous`, a name in
  // the same folder, the old file is renamed to it; at any time at least one of the two names is a
  // complete file.
  [[nodiscard]] Result<void> commit(const std::filesystem::path& previous = {});

  // Removes temporary files that killed writers of `path` left behind. Those of live writers, on
  // this or another machine, are locked and remain. Nothing is removed if the file system does not
  // support locks.
  static void remove_leftovers(const std::filesystem::path& path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

 private:
  [[nodiscard]] Result<void> commit_to_standard_output();

  AtomicFile(std::FILE* file, int lock, std::filesystem::path target, std::filesystem::path temporary);

  std::FILE* file_ = nullptr;
  int lock_ = -1; // a second descriptor that holds the lock until the file is renamed
  int error_ = 0; // errno of the first failure
  std::filesystem::path target_;
  std::filesystem::path temporary_;
};

} // namespace kindling
