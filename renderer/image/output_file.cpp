// Follows links, compares files, and checks names before files are written.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/output_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

namespace kindling {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxLinks = 40;          // as Linux follows
constexpr size_t kTemporaryBytes = 80; // longest name of a temporary file (AtomicFile), '/' included
constexpr long kUsualNameBytes = 255;  // where the file system states no limit

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

// Follows the links of a name. `visit` gets every name on the way.
template <typename Visit>
fs::path follow(const fs::path& path, const Visit& visit) {
  fs::path at = path;
  for (int i = 0; i <= kMaxLinks; ++i) {
    visit(at);
    std::error_code code;
    if (!fs::is_symlink(fs::symlink_status(at, code))) return at;
    const fs::path target = fs::read_symlink(at, code);
    if (code) return path;
    at = at.parent_path() / target; // an absolute target replaces the folder
  }
  return path;
}

// Returns whether the name stands for an open file: replacing it would not write to that file.
bool names_open_file(const fs::path& path) {
  bool open = false;
  (void)follow(path, [&](const fs::path& at) {
    std::error_code code;
    const std::string folder = fs::weakly_canonical(folder_of(at), code).string() + "/";
    open |= folder.starts_with("/proc/") || folder == "/dev/fd/";
  });
  return open;
}

const char* kind_of_file(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  if (S_ISLNK(mode)) return "a symbolic link";
  return "a device";
}

// Returns why no file can be created in the folder; empty if one can.
std::string folder_fault(const fs::path& folder) {
  struct stat status {};
  const std::string name = folder.string();
  if (stat(folder.c_str(), &status) != 0)
    return errno == ENOENT ? fmt::format("folder '{}' does not exist; create it first", name)
                           : fmt::format("folder '{}': {}", name, std::strerror(errno));
  if (!S_ISDIR(status.st_mode)) return fmt::format("'{}' is not a folder", name);
  if (status.st_nlink == 0) return fmt::format("folder '{}' was deleted; use another one", name);
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return fmt::format("folder '{}' cannot be written to: {}", name, std::strerror(errno));
  return {};
}

// Returns why the name is too long for its folder, with the longest companion; empty if it is not.
std::string length_fault(const fs::path& target, std::span<const char* const> companions) {
  size_t ending = 0;
  for (const char* companion : companions) ending = std::max(ending, std::strlen(companion));
  const fs::path folder = folder_of(target);
  const long limit = pathconf(folder.c_str(), _PC_NAME_MAX);
  const auto max_bytes = static_cast<size_t>(limit > 0 ? limit : kUsualNameBytes);
  const size_t bytes = target.filename().native().size();
  if (bytes + ending > max_bytes)
    return fmt::format("the name has {} bytes; use at most {}", bytes, max_bytes - std::min(max_bytes, ending));
  const size_t path_bytes = folder.native().size() + std::max(1 + bytes + ending, kTemporaryBytes);
  if (path_bytes >= PATH_MAX)
    return fmt::format("the path has {} bytes, too long for the system's {}; use a shorter one", target.native().size(),
                       PATH_MAX);
  return {};
}

} // namespace

fs::path end_of_links(const fs::path& path) {
  const fs::path end = follow(path, [](const fs::path&) {});
  if (end == path) return path;
  std::error_code code;
  fs::path canonical = fs::weakly_canonical(end, code);
  return code ? end : canonical;
}

FileIdentity::FileIdentity(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) == 0) {
    device_ = status.st_dev;
    inode_ = status.st_ino;
    return;
  }
  std::error_code code;
  const fs::path end = end_of_links(path);
  const fs::path canonical = fs::weakly_canonical(folder_of(end), code) / end.filename();
  path_ = (code ? fs::absolute(end, code).lexically_normal() : canonical).string();
  if (path_.empty()) path_ = path.string();
}

Result<void> check_writable(const fs::path& path, std::span<const char* const> companions) {
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorKind::input_output, fmt::format("{}: {}", path.string(), why)};
  };
  if (path == kStandardOutput) return {};
  struct stat status {};
  const bool exists = stat(path.c_str(), &status) == 0;
  if (!exists && errno == ELOOP) return refuse("is a symbolic link in a loop of links; use the name of a file");
  if (exists && S_ISDIR(status.st_mode)) return refuse("is a folder; use the name of a file");
  if (!path.has_filename()) return refuse("has no file name; use the name of a file");
  if (names_open_file(path))
    return refuse("names an open file of a process; use the name of a file, or - for standard output");
  if (exists && !S_ISREG(status.st_mode))
    return refuse(fmt::format("is {}; use the name of a file", kind_of_file(status.st_mode)));
  const fs::path target = end_of_links(path);
  if (const std::string fault = folder_fault(folder_of(target)); !fault.empty()) return refuse(fault);
  if (const std::string fault = length_fault(target, companions); !fault.empty()) return refuse(fault);
  for (const char* companion : companions) {
    const fs::path name = fs::path(target) += companion;
    if (lstat(name.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
      return refuse(fmt::format("'{}' beside it is {}; remove it, or use another name", name.filename().string(),
                                kind_of_file(status.st_mode)));
  }
  return {};
}

} // namespace kindling
