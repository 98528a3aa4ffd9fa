// Mutations of JSON that keep it JSON, so that inputs pass the parser.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/mutators/random.h"

#include <string>
#include <string_view>

namespace kindling::fuzz {

// Returns the text with one to four of its values or names changed, moved, copied or removed. Text
// that is not JSON, or nested deeper than 100 levels, is mutated as bytes by libFuzzer, with its
// dictionary; now and then any text is. At most `max_size` bytes.
[[nodiscard]] std::string mutate_json(std::string_view text, size_t max_size, Random& random);

// Returns the bytes after a mutation by libFuzzer. At most `max_size`.
[[nodiscard]] std::string mutate_bytes(std::string_view bytes, size_t max_size);

} // namespace kindling::fuzz
