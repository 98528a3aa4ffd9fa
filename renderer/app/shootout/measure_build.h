// Times a build and measures its memory; the same code measures plugins.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/contestant.h"
#include "renderer/app/terminal/process_info.h"

#include <algorithm>

namespace kindling::app {

// `build` is timed; memory is that of this process.
template <typename Build>
BuildMeasurement measure_build(bool measures_memory, const Build& build) {
  BuildMeasurement result;
  const bool measures_peak = measures_memory && restart_peak_resident();
  const uint64_t resident_before = measures_memory ? resident_bytes() : 0,
                 huge_before = measures_memory ? huge_page_bytes() : 0;
  result.work = measure(process_clock_s, build);
  if (!measures_memory) return result;
  const uint64_t huge = huge_page_bytes();
  result.huge_page_bytes = huge - std::min(huge, huge_before);
  if (const uint64_t peak = measures_peak ? peak_resident_bytes() : 0; peak > 0)
    result.peak_growth_bytes = peak - std::min(peak, resident_before);
  return result;
}

} // namespace kindling::app
