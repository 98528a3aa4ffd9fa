// The instruction sets that accelerators' kernels are compiled for, chosen at run time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace kindling::accel {

// Ascending: a processor that runs one runs all before it.
enum class SimdTarget { portable, sse2, sse42, avx, avx2, avx512 };

// The sets of the kd-tree's kernels (portable, avx2, avx512) that this processor runs, best last; `portable` is always there.
[[nodiscard]] std::vector<SimdTarget> simd_targets();
[[nodiscard]] SimdTarget best_simd_target();

// The sets of Embree's kernels (sse2 to avx512) that this processor runs, best last; none on other processors than x86.
[[nodiscard]] std::vector<SimdTarget> embree_simd_targets();

// "portable", "sse2", "sse4.2", "avx", "avx2", "avx512".
[[nodiscard]] std::string_view simd_target_name(SimdTarget target);
[[nodiscard]] std::optional<SimdTarget> simd_target_from_name(std::string_view name);

} // namespace kindling::accel
