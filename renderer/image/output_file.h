// Names of output files before the work: what they refer to, and whether a file can be put there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <compare>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace kindling {

// The path that stands for standard output; a file of this name is "./-".
inline constexpr const char* kStandardOutput = "-";

// Returns the file that a name leads to: the end of its symbolic links, which may not exist yet.
// Other names, and links that form a loop, are returned unchanged.
[[nodiscard]] std::filesystem::path end_of_links(const std::filesystem::path& path);

// The identity of a file: by device and inode if it exists, so that hard and symbolic links and
// other spellings of one file are equal; else by its canonical path.
class FileIdentity {
 public:
  explicit FileIdentity(const std::filesystem::path& path);

  friend auto operator<=>(const FileIdentity&, const FileIdentity&) = default;

 private:
  uint64_t device_ = 0;
  uint64_t inode_ = 0;
  std::string path_; // empty if the file exists
};

// Checks that a file can be created at `path`, or replaced. kStandardOutput always can. Fails
// (input_output) for what is not a regular file (a folder, pipe, socket or device), for the name of
// an open file of a process (/dev/stdout, /proc/self/fd/1), for a name that is too long, and for a
// folder that does not exist, was deleted or is not writable. `companions` are endings of files
// that are written or renamed beside it (".previous"): there, only regular files may exist.
[[nodiscard]] Result<void> check_writable(const std::filesystem::path& path,
                                          std::span<const char* const> companions = {});

} // namespace kindling
