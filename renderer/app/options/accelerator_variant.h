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
  std::optional<accel::SimdTarget> simd; // instruction set of the kernels; unset: the best that the processor runs

  // "embree:best:non-robust". Defaults are left out, so that equal variants have equal names.
  [[nodiscard]] std::string name() const;
  bool operator==(const AcceleratorVariant&) const = default;
};

// Parses NAME[:QUALITY][:robust|:non-robust][:SIMD][,...]. SIMD is portable, avx2 or avx512 for the
// kd-tree, and sse2, sse4.2, avx, avx2 or avx512 for Embree. Fails (usage) on unknown words, on
// settings that an accelerator does not have (only Embree can be non-robust; brute force has
// neither qualities nor instruction sets), on an instruction set that this processor does not run,
// and on a variant that is given twice.
[[nodiscard]] Result<std::vector<AcceleratorVariant>> parse_accelerator_variants(std::string_view text);

// "embree,kdtree:best": the variants as --accel takes them.
[[nodiscard]] std::string join_variants(const std::vector<AcceleratorVariant>& variants);

// Parses one of the names above except portable. Fails (usage) if this processor does not run it.
[[nodiscard]] Result<accel::SimdTarget> parse_instruction_set(std::string_view text);

// Gives each variant that names no instruction set the best kernels that run on a processor with
// `limit`.
void limit_instruction_set(std::vector<AcceleratorVariant>& variants, accel::SimdTarget limit);

} // namespace kindling::app
