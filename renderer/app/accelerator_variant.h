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

// "fast", "balanced", "best".
[[nodiscard]] std::string_view quality_name(accel::Quality quality);
[[nodiscard]] std::optional<accel::Quality> quality_from_name(std::string_view name);

struct AcceleratorVariant {
  accel::Kind kind = accel::Kind::embree;
  accel::Quality quality = accel::Quality::balanced;
  bool robust = true;
  std::optional<accel::SimdTarget> simd; // of the kd-tree; none: the best that the processor runs

  // "embree:best:non-robust"; what is default is left out, so that equal variants have equal names.
  [[nodiscard]] std::string name() const;
  bool operator==(const AcceleratorVariant&) const = default;
};

// NAME[:QUALITY][:robust|:non-robust][:SIMD][,...], SIMD being portable, avx2 or avx512. Fails (usage) on unknown words, on an
// accelerator without such a setting (only Embree can be not robust, brute force has no quality, the kd-tree alone has instruction
// sets to choose from), on an instruction set that this processor does not run, and on one given twice.
[[nodiscard]] Result<std::vector<AcceleratorVariant>> parse_accelerator_variants(std::string_view text);

} // namespace kindling::app
