// The public list of supported glTF extensions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Support for one extension of glTF: the one table for errors, documents, tests and `info --list-extensions`.
struct ExtensionSupport {
  std::string_view name;
  enum class Level : uint8_t { full, partial, ignored } level = Level::full; // ignored: known, has no effect yet, warns
  std::string_view note;
};
[[nodiscard]] std::vector<ExtensionSupport> supported_extensions();    // by name
[[nodiscard]] std::string_view name_of(ExtensionSupport::Level level); // full, partial, ignored
// As Markdown, the table of the README.
[[nodiscard]] std::string extension_table_markdown();

} // namespace kindling
