// The oracle: every ray against every triangle. Slow and simple; what the other accelerators are tested against.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <memory>

namespace kindling::accel {

// Null only if cancelled. Ties in t go to the smallest (instance, mesh, triangle).
[[nodiscard]] std::unique_ptr<Accelerator> make_brute_force(const BuildInput& input, const BuildOptions& options);

} // namespace kindling::accel
