// Modes of the progress display, and their names.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace kindling::app {

enum class ProgressMode { automatic, plain, json, none };
// "auto", "plain", "json", "none".
[[nodiscard]] std::string_view progress_mode_name(ProgressMode mode);
[[nodiscard]] std::optional<ProgressMode> progress_mode_from_name(std::string_view name);

} // namespace kindling::app
