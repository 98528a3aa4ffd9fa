// Mutations of .glb files that keep the lengths of their chunks right.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/mutators/random.h"

#include <string>
#include <string_view>

namespace kindling::fuzz {

// Mutates the JSON or the BIN chunk in a container of the right length; now and then, and if the
// file is no container, mutates bytes anywhere. At most `max_size` bytes.
[[nodiscard]] std::string mutate_glb(std::string_view file, size_t max_size, Random& random);

} // namespace kindling::fuzz
