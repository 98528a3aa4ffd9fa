// Files for readers that take a path, and checks that end the process.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_support.h"

#include <tbb/global_control.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace kindling::fuzz {

void use_one_thread() {
  static const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  static_cast<void>(one);
}

InputFolder::InputFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "kindling_fuzz_XXXXXX").string();
  require(mkdtemp(name.data()) != nullptr, "a folder can be made in $TMPDIR");
  path_ = name;
}

InputFolder::~InputFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path InputFolder::write(const std::filesystem::path& name, Bytes bytes) const {
  std::filesystem::path file = path_ / name;
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  require(fd >= 0, "the input's file can be opened");
  while (!bytes.empty()) {
    const ssize_t count = ::write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    require(count > 0, "the input's file can be written; is $TMPDIR full?");
    bytes = bytes.subspan(static_cast<size_t>(count));
  }
  close(fd);
  return file;
}

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "finding: not true: %s\n", what);
  std::abort();
}

void require_good_message(const Error& error, std::string_view named) {
  const std::string& text = error.message;
  if (!text.empty() && text.find('\n') == std::string::npos && text.find(named) != std::string::npos) return;
  std::fprintf(stderr, "finding: an error must be one line that contains '%.*s': '%s'\n",
               static_cast<int>(named.size()), named.data(), text.c_str());
  std::abort();
}

} // namespace kindling::fuzz
