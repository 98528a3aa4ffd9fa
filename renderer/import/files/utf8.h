// Repair of text that is not UTF-8.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kindling::gltf {

// Replaces bytes that are not part of a well-formed sequence (Unicode 15, table 3-7) by U+FFFD, one
// for each longest start of a sequence, as web browsers do.
[[nodiscard]] std::string replace_invalid_utf8(std::string_view text);

} // namespace kindling::gltf
