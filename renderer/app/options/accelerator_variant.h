// An accelerator with its settings, as `kindling shootout --accel` names it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"
#include "renderer/base/result.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

struct AcceleratorVariant {
  accel::Kind kind = accel::Kind::embree;
  accel::Quality quality = accel::Quality::balanced;
  bool robust = true;
  std::optional<accel::SimdTarget> simd; // of the kernels; none: the best that the processor runs

  // "embree:best:non-robust"; what is default is left out, so that equal variants have equal names.
  [[nodiscard]] std::string name() const;
  bool operator==(const AcceleratorVariant&) const = default;
};

// NAME[:QUALITY][:robust|:non-robust][:SIMD][,...], SIMD being portable, avx2 or avx512 for the kd-tree and sse2, sse4.2, avx, avx2 or
// avx512 for Embree. Fails (usage) on unknown words, on an accelerator without such a setting (only Embree can be not robust, brute
// force has neither qualities nor instruction sets), on an instruction set that this processor does not run, and on one given twice.
[[nodiscard]] Result<std::vector<AcceleratorVariant>> parse_accelerator_variants(std::string_view text);

// One of the names above but portable. Fails (usage) where this processor does not run it.
[[nodiscard]] Result<accel::SimdTarget> parse_instruction_set(std::string_view text);

// Restricts variants without an instruction set of their own to processors with `limit`: each gets its best kernels that need no more.
void limit_instruction_set(std::vector<AcceleratorVariant>& variants, accel::SimdTarget limit);

} // namespace kindling::app
