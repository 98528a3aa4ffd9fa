// Decodes an image from memory, for the harnesses of image formats.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/fuzz/fuzz_support.h"

namespace kindling::fuzz {

// Requires a decoded image to have the pixels that its size asks for, and errors to be one line.
// The limit on pixels is lower than that of renders.
void decode_to_the_end(Bytes bytes);

} // namespace kindling::fuzz
