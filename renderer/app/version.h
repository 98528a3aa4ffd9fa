// What this program is and was built with.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kindling::app {

// "0.1.0"
[[nodiscard]] std::string_view version();
// "GCC 12.2.0"
[[nodiscard]] std::string_view compiler();
// Several lines: version, compiler, accelerators, TBB; ends with '\n'.
[[nodiscard]] std::string version_text();

} // namespace kindling::app
