// The brute-force oracle: tests every ray against every triangle; slow, simple, for tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <memory>

namespace kindling::accel {

// Returns null only if cancelled. Ties in t go to the smallest (instance, mesh, triangle).
[[nodiscard]] std::unique_ptr<Accelerator> make_brute_force(const BuildInput& input, const BuildOptions& options);

} // namespace kindling::accel
