// The public list of supported glTF extensions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Support for one extension of glTF. The list serves error messages, the README, tests and `info`.
struct ExtensionSupport {
  std::string_view name;
  enum class Level : uint8_t { full, partial, ignored } level = Level::full; // ignored: has no effect, a warning
  std::string_view note;
};
[[nodiscard]] std::vector<ExtensionSupport> supported_extensions();    // ordered by name
[[nodiscard]] std::string_view name_of(ExtensionSupport::Level level); // full, partial, ignored
// Returns the table of renderer/import/README.md in Markdown.
[[nodiscard]] std::string extension_table_markdown();

} // namespace kindling
