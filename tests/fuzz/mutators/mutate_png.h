// Mutations of PNG files that keep their checksums right.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/mutators/random.h"

#include <string>
#include <string_view>

namespace kindling::fuzz {

// Mutates, copies or removes a chunk, or the rows inside of its compressed data, and corrects the
// checksums; now and then, and if the file has no chunks, mutates bytes anywhere. At most
// `max_size` bytes.
[[nodiscard]] std::string mutate_png(std::string_view file, size_t max_size, Random& random);

} // namespace kindling::fuzz
