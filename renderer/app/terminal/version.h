// Version, compiler and identity of the program.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kindling::app {

// "0.1.0"
[[nodiscard]] std::string_view version();
// "GCC 12.2.0"
[[nodiscard]] std::string_view compiler();
// Identifies the program down to its sources: "Kindling 0.1.0 (sources 91c2..., GCC 12.2.0,
// x86-64-v3, Release build)". Builds of the same sources with the same settings are equal in it;
// programs that differ may render images that differ in their bits.
[[nodiscard]] std::string program_identity();
// Several lines: version, compiler, accelerators, TBB; ends with '\n'.
[[nodiscard]] std::string version_text();

} // namespace kindling::app
