// Creates an accelerator by kind, and maps kinds to names.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <memory>
#include <optional>
#include <string_view>

namespace kindling::accel {

// Builds an accelerator over the borrowed input. Returns null only if cancelled. Throws
// std::bad_alloc when memory runs out, nothing else. Parallel with TBB in the caller's arena.
// `previous`: structures of an earlier accelerator, or null; those that cannot be used are freed
// before others are built. They do not change any answer.
[[nodiscard]] std::unique_ptr<Accelerator> make_accelerator(Kind kind, const BuildInput& input,
                                                            const BuildOptions& options = {},
                                                            std::unique_ptr<PersistentStructures> previous = nullptr);

// Returns "embree", "kdtree" or "brute-force".
[[nodiscard]] std::string_view kind_name(Kind kind);
[[nodiscard]] std::optional<Kind> kind_from_name(std::string_view name);
// Returns e.g. "Embree 3.13.5" or "Kindling kd-tree", for reports and image metadata.
[[nodiscard]] std::string_view kind_description(Kind kind);

// "fast", "balanced", "best".
[[nodiscard]] std::string_view quality_name(Quality quality);
[[nodiscard]] std::optional<Quality> quality_from_name(std::string_view name);

} // namespace kindling::accel
