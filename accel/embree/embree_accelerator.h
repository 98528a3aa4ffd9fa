// Intel Embree behind the accelerator interface: the reference for speed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <memory>
#include <string_view>

namespace kindling::accel {

// Returns null only if cancelled; throws std::bad_alloc if Embree cannot build. Parallel in the
// caller's TBB arena.
[[nodiscard]] std::unique_ptr<Accelerator> make_embree(const BuildInput& input, const BuildOptions& options,
                                                       std::unique_ptr<PersistentStructures> previous = nullptr);

// Returns the version that was compiled against, e.g. "Embree 3.13.5".
[[nodiscard]] std::string_view embree_description();

// Embree's calls for many rays: packets as wide as its kernels (rtcIntersect16, rtcOccluded16; 8 or
// 4) or streams (rtcIntersect1M, rtcOccluded1M; Embree 3 only), each with or without the flag that
// marks rays as coherent.
enum class EmbreeCall { packet, coherent_packet, stream, coherent_stream };

// Returns an accelerator for comparisons that answers all batch queries of `embree`, which must
// outlive it, by one call. Its answers differ from single queries by rounding and in ties, as
// elsewhere only those of the coherent queries may. Null if `embree` was not made by make_embree(),
// or the version has no such call.
[[nodiscard]] std::unique_ptr<Accelerator> with_embree_call(const Accelerator& embree, EmbreeCall call);

} // namespace kindling::accel
