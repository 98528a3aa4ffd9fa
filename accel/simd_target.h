// The instruction sets that kernels are compiled for, chosen at run time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace kindling::accel {

enum class SimdTarget { portable, avx2, avx512 };

// Those that this program was compiled for and this processor runs, best last; `portable` is always there.
[[nodiscard]] std::vector<SimdTarget> simd_targets();
[[nodiscard]] SimdTarget best_simd_target();

// "portable", "avx2", "avx512".
[[nodiscard]] std::string_view simd_target_name(SimdTarget target);
[[nodiscard]] std::optional<SimdTarget> simd_target_from_name(std::string_view name);

} // namespace kindling::accel
