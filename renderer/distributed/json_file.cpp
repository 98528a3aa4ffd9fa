// Atomic writing of JSON files by rename.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/json_file.h"

#include <fmt/format.h>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace kindling {

namespace {

Error failed(const std::filesystem::path& path, const char* what) {
  return {ErrorKind::input_output, fmt::format("{}: {}: {}", path.string(), what, std::strerror(errno))};
}

} // namespace

Result<void> write_json_file(const std::filesystem::path& path, const nlohmann::ordered_json& json) {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  // Unique to this process, even among several machines.
  const std::filesystem::path temporary = fmt::format("{}.{}-{}.tmp", path.string(), host, getpid());
  const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  errno = 0;
  std::ofstream file(temporary, std::ios::binary);
  file << text;
  file.close();
  if (!file) {
    const Error error = failed(temporary, "cannot be written");
    unlink(temporary.c_str());
    return error;
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) {
    const Error error = failed(path, "cannot be replaced");
    unlink(temporary.c_str());
    return error;
  }
  return {};
}

Result<nlohmann::ordered_json> read_json_file(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (file) text << file.rdbuf(); // which fails for an empty file, too
  if (!file || (!text && errno != 0)) return failed(path, "cannot be read");
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(text.str(), nullptr, false);
  if (!json.is_object()) return Error{ErrorKind::input_output, fmt::format("{}: is not a JSON object", path.string())};
  return json;
}

} // namespace kindling
