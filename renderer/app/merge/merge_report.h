// The report of a merge: lines for people, JSON for programs.
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
  RenderWork work;       // sum over all parts
  double mean_spp = 0.0; // over the pixels of the crop
  double check_s = 0.0;  // reading headers and comparing them
  double merge_s = 0.0;  // reading and adding up
  double write_s = 0.0;
  double total_s = 0.0;
  uint64_t film_bytes = 0;
  uint64_t peak_resident_bytes = 0;
  std::vector<std::string> outputs;

  // The missing share of all samples of the image, in [0, 1].
  [[nodiscard]] double missing_share() const;
};

// Prints the files that were left out and the samples that are missing: warnings with
// --allow-missing, else notes.
void report_plan(const MergePlan& plan, bool allow_missing, Console& console);
// Several lines without a final '\n'.
[[nodiscard]] std::string format_merge_summary(const MergeReport& report);
// README.md describes the keys, which do not change.
[[nodiscard]] std::string format_merge_json(const MergeReport& report);

} // namespace kindling::app
