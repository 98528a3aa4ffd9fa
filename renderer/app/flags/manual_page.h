// The manual page, man 1 kindling, written from the table of flags.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_table.h"

#include <span>
#include <string>
#include <string_view>

namespace kindling::app {

// The page as troff source with the man macros. Needs `commands` in the order of the page.
[[nodiscard]] std::string manual_page(std::span<const CommandTable> commands, std::string_view version);

} // namespace kindling::app
