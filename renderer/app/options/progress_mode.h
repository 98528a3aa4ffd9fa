// How progress is shown.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace kindling::app {

enum class ProgressMode { automatic, plain, json, none };
[[nodiscard]] std::optional<ProgressMode>
progress_mode_from_name(std::string_view name); // "auto", "plain", "json", "none"

} // namespace kindling::app
