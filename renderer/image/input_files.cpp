// Compares an output with the files that were read.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/input_files.h"

#include "renderer/image/output_file.h"

#include <fmt/format.h>

#include <string>

namespace kindling {

Result<void> check_not_among(const std::filesystem::path& path, std::span<const std::filesystem::path> read) {
  const FileIdentity written(path);
  for (const std::filesystem::path& file : read) {
    if (FileIdentity(file) != written) continue;
    const std::string alias = file == path ? "" : fmt::format(", by the name '{}'", file.string());
    return Error{
        ErrorKind::usage,
        fmt::format("{}: is a file that the image is rendered from{}; it would be overwritten: use another name",
                    path.string(), alias)};
  }
  return {};
}

} // namespace kindling
