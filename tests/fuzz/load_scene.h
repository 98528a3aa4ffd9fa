// Loads a glTF file as the program does, strictly and with repairs, and poses what it holds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/fuzz_support.h"

#include <string>

namespace kindling::fuzz {

// Requires that a load with repairs accepts what a strict one accepts, and that errors name the
// file. Limits on elements, pixels and instances are lower than those of renders, so that an
// input takes little memory and time.
void load_and_pose(const std::filesystem::path& path);

// Returns a .glb with these two chunks.
[[nodiscard]] std::string make_glb(std::string json, std::string_view bin);

} // namespace kindling::fuzz
