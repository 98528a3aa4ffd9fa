// Repair of JSON numbers beyond the range of double.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kindling::gltf {

// Returns JSON text in which numbers that overflow (1e309, which other parsers read as infinity)
// are the largest double of their sign. Text within quotes is unchanged.
[[nodiscard]] std::string limit_numbers(std::string_view text);

} // namespace kindling::gltf
