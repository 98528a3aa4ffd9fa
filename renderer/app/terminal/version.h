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
// Which program made a file, down to its sources: "Kindling 0.1.0 (sources 91c2..., GCC 12.2.0, x86-64-v3, Release build)". The
// same on every machine that built the same sources alike; programs that differ in it need not make the same image to the bit.
[[nodiscard]] std::string program_identity();
// Several lines: version, compiler, accelerators, TBB; ends with '\n'.
[[nodiscard]] std::string version_text();

} // namespace kindling::app
