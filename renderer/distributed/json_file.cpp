// Atomic writing of JSON files by rename.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/json_file.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

namespace kindling {

namespace {

Error failed(const std::filesystem::path& path, const char* what) {
  return {ErrorKind::input_output, fmt::format("{}: {}: {}", path.string(), what, std::strerror(errno))};
}

int int_of(const nlohmann::ordered_json& json, const char* key) {
  using Limits = std::numeric_limits<int>;
  // Unsigned numbers above the range of int64_t would wrap around.
  if (json.is_number_integer() && (!json.is_number_unsigned() || json.get<uint64_t>() <= uint64_t{Limits::max()}))
    if (const auto number = json.get<int64_t>(); number >= Limits::min() && number <= Limits::max())
      return static_cast<int>(number);
  constexpr size_t kShown = 40;
  const std::string text =
      json.is_structured() ? json.type_name() : json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  throw NotAWholeNumber{fmt::format("'{}' is {}; use a whole number from {} to {}", key, text.substr(0, kShown),
                                    Limits::min(), Limits::max())};
}

} // namespace

Result<void> write_json_file(const std::filesystem::path& path, const nlohmann::ordered_json& json) {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  // Unique to this process, even among several machines.
  const std::filesystem::path temporary = fmt::format("{}.{}-{}.tmp", path.string(), host, getpid());
  const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  unlink(temporary.c_str()); // of a killed process with this number
  const int fd = open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
  if (fd < 0) return failed(temporary, "cannot be written");
  bool good = true;
  for (std::string_view rest = text; good && !rest.empty();) {
    const ssize_t count = write(fd, rest.data(), rest.size());
    if (count < 0 && errno == EINTR) continue;
    good = count > 0;
    if (good) rest.remove_prefix(static_cast<size_t>(count));
  }
  const int write_error = errno;
  if (close(fd) != 0 || !good) {
    if (!good) errno = write_error;
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
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored))
    return Error{ErrorKind::input_output, fmt::format("{}: is not a regular file", path.string())};
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (file) text << file.rdbuf(); // which fails for an empty file, too
  if (!file || (!text && errno != 0)) return failed(path, "cannot be read");
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(text.str(), nullptr, false);
  if (!json.is_object()) return Error{ErrorKind::input_output, fmt::format("{}: is not a JSON object", path.string())};
  return json;
}

int whole_number(const nlohmann::ordered_json& object, const char* key) { return int_of(object.at(key), key); }

std::vector<int> whole_numbers(const nlohmann::ordered_json& object, const char* key) {
  const nlohmann::ordered_json& list = object.at(key);
  if (!list.is_array()) throw NotAWholeNumber{fmt::format("'{}' is {}; use a list", key, list.type_name())};
  std::vector<int> numbers;
  for (const nlohmann::ordered_json& number : list) numbers.push_back(int_of(number, key));
  return numbers;
}

} // namespace kindling
