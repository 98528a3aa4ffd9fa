// Whether accumulations are of one picture.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/accumulation_file.h"

#include <string>
#include <vector>

namespace kindling {

// What keeps the two from being parts of one picture, one entry for each difference, with the value of `a` first: "seed: 3 and 4". Empty:
// they are.
[[nodiscard]] std::vector<std::string> picture_differences(const AccumulationIdentity& a,
                                                           const AccumulationIdentity& b);

} // namespace kindling
