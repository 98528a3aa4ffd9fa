// A folder for temporary files, which the next process removes if its own is killed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>

namespace kindling {

// The folder is named "kindling-paged-HOST-XXXXXX" and locked (flock()) while its object lives, so
// that a folder without a lock belongs to no process, whatever became of process numbers. It holds
// plain files only.
class TemporaryFolder {
 public:
  // Creates a folder in $TMPDIR, or in /tmp if it is not set. Fails (input_output) if that is not a
  // folder, or if nothing can be created in it.
  [[nodiscard]] static Result<TemporaryFolder> create();
  // Removes the folders that killed processes left there: those of this user and this host that are
  // not locked. Symbolic links are not followed, and folders with anything but plain files remain.
  static void remove_leftovers();

  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  ~TemporaryFolder(); // removes the folder with its files

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  TemporaryFolder(std::filesystem::path path, int descriptor);

  std::filesystem::path path_;
  int descriptor_; // of the folder; holds the lock
};

} // namespace kindling
