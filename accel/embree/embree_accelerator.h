// Intel Embree as an Accelerator: the reference in speed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <memory>
#include <string_view>

namespace kindling::accel {

// Null only if cancelled; throws std::bad_alloc if Embree cannot build. Parallel in the caller's TBB arena.
[[nodiscard]] std::unique_ptr<Accelerator> make_embree(const BuildInput& input, const BuildOptions& options,
                                                       std::unique_ptr<PersistentStructures> kept = nullptr);

// "Embree 3.13.5": the version that was compiled against.
[[nodiscard]] std::string_view embree_description();

// Embree's calls for many rays: a packet as wide as its kernels (rtcIntersect16, rtcOccluded16; 8 or 4) or a stream (rtcIntersect1M, rtcOccluded1M;
// Embree 3 only), each without and with the flag that calls the rays coherent.
enum class EmbreeCall { packet, coherent_packet, stream, coherent_stream };

// For comparisons: an accelerator over the scenes of `embree`, which must outlive it, that answers all four batch queries by
// that call. They then differ from single queries by rounding and in ties, as only the coherent ones may elsewhere. Null if
// `embree` was not made by make_embree(), or the version has no such call.
[[nodiscard]] std::unique_ptr<Accelerator> with_embree_call(const Accelerator& embree, EmbreeCall call);

} // namespace kindling::accel
