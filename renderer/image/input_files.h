// Outputs that would replace inputs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>
#include <span>

namespace kindling {

// Fails (usage) if a file at `path` would replace one of the files that were read, by this or
// another name.
[[nodiscard]] Result<void> check_not_among(const std::filesystem::path& path,
                                           std::span<const std::filesystem::path> read);

} // namespace kindling
