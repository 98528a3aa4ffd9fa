// What a merge found and made: lines for people and the JSON for programs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/terminal/console.h"
#include "renderer/distributed/merge_accumulations.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling::app {

struct MergeReport {
  std::string command_line;
  MergePlan plan;
  RenderWork work;       // of all parts
  double mean_spp = 0.0; // over the pixels of the crop
  double check_s = 0.0;  // what the files are about, and whether they belong together
  double merge_s = 0.0;  // read and added up
  double write_s = 0.0;
  double total_s = 0.0;
  uint64_t film_bytes = 0;
  uint64_t peak_resident_bytes = 0;
  std::vector<std::string> outputs;

  // Of all samples of the image, in [0, 1].
  [[nodiscard]] double missing_share() const;
};

// Which files were left out, and what is missing: warnings where that is allowed, else notes.
void tell_plan(const MergePlan& plan, bool allow_missing, Console& console);
// Several lines without a final '\n'.
[[nodiscard]] std::string format_merge_summary(const MergeReport& report);
// The keys are described in README.md and stay what they are.
[[nodiscard]] std::string format_merge_json(const MergeReport& report);

} // namespace kindling::app
