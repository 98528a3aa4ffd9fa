// Intel Embree as an Accelerator: the reference in speed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <memory>
#include <string_view>

namespace kindling::accel {

// Null only if cancelled; throws std::bad_alloc if Embree cannot build. Parallel in the caller's TBB arena.
[[nodiscard]] std::unique_ptr<Accelerator> make_embree(const BuildInput& input, const BuildOptions& options);

// "Embree 3.13.5": the version that was compiled against.
[[nodiscard]] std::string_view embree_description();

} // namespace kindling::accel
