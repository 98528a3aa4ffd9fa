// Mutations of .kacc files that keep their checksums right.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/mutators/random.h"

#include <string>
#include <string_view>

namespace kindling::fuzz {

// Mutates the header's JSON, a block's header or its compressed records, and corrects all
// checksums; now and then, and if the file has no header, mutates bytes anywhere. At most
// `max_size` bytes.
[[nodiscard]] std::string mutate_accumulation(std::string_view file, size_t max_size, Random& random);

} // namespace kindling::fuzz
