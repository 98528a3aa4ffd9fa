// Parses progress events and error lines of Kindling's own processes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/program_lines.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kindling {

bool ProgramLines::take(std::string_view line) {
  if (line.starts_with('{')) {
    const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
    const auto text = [&](const char* key) {
      const auto found = json.find(key);
      return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
    };
    if (json.is_object() && text("event") == "progress") {
      const bool news = text("phase") == "render" && json.contains("fraction");
      if (news && json["fraction"].is_number()) progress = json["fraction"].get<double>();
      rendering = rendering || news;
      return news;
    }
    if (json.is_object() && !text("message").empty()) log_(fmt::format("{}: {}", text("event"), text("message")));
    if (json.is_object()) return false; // the summary is in the statistics file as well
  }
  constexpr std::string_view kError = "kindling: error: ";
  if (line.starts_with(kError)) error = line.substr(kError.size());
  log_(line);
  return false;
}

} // namespace kindling
