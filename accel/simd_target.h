// Instruction sets that the accelerators' kernels are compiled for, selected at run time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace kindling::accel {

// In ascending order: a processor that supports one supports all before it.
enum class SimdTarget { portable, sse2, sse42, avx, avx2, avx512 };

// Returns the sets of the kd-tree's kernels (portable, avx2, avx512) that this processor supports,
// best last. `portable` is always among them.
[[nodiscard]] std::vector<SimdTarget> simd_targets();
[[nodiscard]] SimdTarget best_simd_target();

// Returns the sets of Embree's kernels (sse2 to avx512) that this processor supports, best last;
// none on processors other than x86.
[[nodiscard]] std::vector<SimdTarget> embree_simd_targets();

// Returns "portable", "sse2", "sse4.2", "avx", "avx2" or "avx512".
[[nodiscard]] std::string_view simd_target_name(SimdTarget target);
[[nodiscard]] std::optional<SimdTarget> simd_target_from_name(std::string_view name);

} // namespace kindling::accel
