// The version, the compiler and the sources that this program was built from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kindling {

[[nodiscard]] std::string_view version();      // "0.1.0"
[[nodiscard]] std::string_view compiler();     // "GCC 12.2.0"
[[nodiscard]] std::string_view sources_hash(); // 16 hexadecimal digits, over all sources and their build files
[[nodiscard]] std::string_view build_type();   // "Release build"

// Identifies the program that made a file, down to its sources: "Kindling 0.1.0 (sources 91c2...,
// GCC 12.2.0, x86-64-v3, Release build, libm 2.36)". The same on every machine that built the same
// sources alike. Programs with different identities need not make the same image to the bit.
[[nodiscard]] std::string program_identity();

} // namespace kindling
