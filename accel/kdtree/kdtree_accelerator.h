// The SAH kd-tree accelerator, with a second level for transformed instances.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/view_tables.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kindling::accel {

// Returns null only if cancelled; throws std::bad_alloc if memory runs out. Parallel in the
// caller's TBB arena. The result, and so every answer, is the same for any number of threads. Ties
// in t go to the smallest (instance, mesh, triangle).
[[nodiscard]] std::unique_ptr<Accelerator> make_kdtree(const BuildInput& input, const BuildOptions& options,
                                                       std::unique_ptr<PersistentStructures> previous = nullptr);

// Returns the view of an accelerator that make_kdtree() built, and null for other kinds. The
// accelerator must outlive it. Ordinary queries do without the tables, so nothing keeps them: their
// size is 64 bytes per transformed instance, and little else.
[[nodiscard]] std::unique_ptr<const kd::StructureTables> view_of(const Accelerator& accelerator);

// Appends the crossings of rays, the nearest `limit` of each, to `crossings`, and sets counts[i] to
// the number of those of ray i; bit for bit the answers of all_hits(), and faster for many rays.
// Returns false, and does nothing, for other kinds.
[[nodiscard]] bool kdtree_all_hits(const Accelerator& accelerator, std::span<const Ray> rays, size_t limit,
                                   std::vector<Crossing>& crossings, std::span<uint32_t> counts);

} // namespace kindling::accel
