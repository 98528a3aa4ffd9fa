// Picks an accelerator by kind or name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <memory>
#include <optional>
#include <string_view>

namespace kindling::accel {

// Builds over the borrowed input. Null only if cancelled. Throws std::bad_alloc when memory runs out, nothing else.
// Parallel with TBB in the caller's arena. `kept`, if any, are structures of an earlier accelerator, of which those that do not serve
// are freed before others are built. The answers are the same with them or without.
[[nodiscard]] std::unique_ptr<Accelerator> make_accelerator(Kind kind, const BuildInput& input,
                                                            const BuildOptions& options = {},
                                                            std::unique_ptr<PersistentStructures> kept = nullptr);

// "embree", "kdtree", "brute-force".
[[nodiscard]] std::string_view kind_name(Kind kind);
[[nodiscard]] std::optional<Kind> kind_from_name(std::string_view name);
// "Embree 3.13.5", "Kindling kd-tree", ...: for reports and image metadata.
[[nodiscard]] std::string_view kind_description(Kind kind);

// "fast", "balanced", "best".
[[nodiscard]] std::string_view quality_name(Quality quality);
[[nodiscard]] std::optional<Quality> quality_from_name(std::string_view name);

} // namespace kindling::accel
