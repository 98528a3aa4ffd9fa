// Creates, locks and removes folders by their descriptors.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/temporary_folder.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kindling {
namespace {

namespace fs = std::filesystem;

// Names of folders of this host: flock() of some network file systems reaches one host only.
std::string folder_prefix() {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  std::string name = host.data();
  for (char& c : name)
    if (c == '/') c = '_';
  return "kindling-paged-" + name + "-";
}

int open_folder(const fs::path& path) {
  return open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
}

// Returns whether the name still stands for the open folder, which another process may have
// removed.
bool is_current(const fs::path& path, int descriptor) {
  struct stat open_one {};
  struct stat named {};
  return fstat(descriptor, &open_one) == 0 && lstat(path.c_str(), &named) == 0 && open_one.st_ino == named.st_ino &&
         open_one.st_dev == named.st_dev;
}

// Removes the files of an open folder, and then the folder unless anything else is in it.
void remove_folder(const fs::path& path, int descriptor) {
  const int copy = fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  DIR* entries = copy >= 0 ? fdopendir(copy) : nullptr;
  if (entries == nullptr) {
    if (copy >= 0) close(copy);
    return;
  }
  rewinddir(entries);
  for (const dirent* entry = readdir(entries); entry != nullptr; entry = readdir(entries)) {
    struct stat status {};
    if (fstatat(descriptor, entry->d_name, &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(status.st_mode))
      unlinkat(descriptor, entry->d_name, 0);
  }
  closedir(entries);
  if (is_current(path, descriptor)) rmdir(path.c_str()); // fails if it is not empty
}

} // namespace

TemporaryFolder::TemporaryFolder(fs::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

TemporaryFolder::~TemporaryFolder() {
  if (descriptor_ < 0) return;
  remove_folder(path_, descriptor_);
  close(descriptor_);
}

Result<TemporaryFolder> TemporaryFolder::create() {
  const auto failed = [](const std::string& parent, const std::string& why) {
    return Error{ErrorKind::input_output,
                 "no temporary folder in '" + parent + "': " + why + "; set TMPDIR to a folder that can be written to"};
  };
  std::error_code code;
  const fs::path parent = fs::temp_directory_path(code);
  if (code) {
    const char* variable = std::getenv("TMPDIR");
    return failed(variable != nullptr ? variable : "/tmp", code.message());
  }
  for (int attempt = 0; attempt < 100; ++attempt) {
    std::string name = (parent / (folder_prefix() + "XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr) return failed(parent.string(), std::strerror(errno));
    const int descriptor = open_folder(name);
    if (descriptor < 0) {
      if (errno == ENOENT) continue; // another process removed it before it was locked
      return failed(parent.string(), std::strerror(errno));
    }
    const bool taken = flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!taken && is_current(name, descriptor)) return TemporaryFolder(name, descriptor);
    close(descriptor);
  }
  return failed(parent.string(), "other processes remove it");
}

void TemporaryFolder::remove_leftovers() {
  std::error_code code;
  const fs::path parent = fs::temp_directory_path(code);
  if (code) return;
  const std::string prefix = folder_prefix();
  for (fs::directory_iterator i(parent, code), end; !code && i != end; i.increment(code)) {
    if (!i->path().filename().native().starts_with(prefix)) continue;
    const int descriptor = open_folder(i->path());
    if (descriptor < 0) continue;
    struct stat status {};
    const bool own = fstat(descriptor, &status) == 0 && status.st_uid == geteuid();
    if (own && flock(descriptor, LOCK_EX | LOCK_NB) == 0) remove_folder(i->path(), descriptor);
    close(descriptor);
  }
}

} // namespace kindling
