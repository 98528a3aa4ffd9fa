// The contents of an accumulation file (checkpoint, part or merge) for `kindling info`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/distributed/work_parts.h"
#include "renderer/session/accumulation_file.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// A set of samples, and the number of pixels that have it.
struct CoverageKind {
  BlockCoverage samples;
  uint64_t pixels = 0;
};

struct AccumulationInfo {
  std::filesystem::path file;
  uint64_t file_bytes = 0;
  int64_t saved_s = 0; // seconds since 1970, by the file system
  AccumulationSummary summary;
  std::filesystem::path scene_file; // from the arguments; empty if this program cannot parse them
  WorkPart part;
  std::vector<CoverageKind> coverage; // sorted by decreasing number of pixels
  double mean_samples = 0.0;          // per pixel of the area
  double done_share = 0.0;            // share of the wanted samples, in [0, 1]; converged pixels count as done
  std::optional<std::string> damage;  // the reason if the sums cannot be read, although the header can
  // FILE.previous, if it exists: a resume falls back to it if FILE is damaged.
  struct Previous {
    std::filesystem::path file;
    int64_t saved_s = 0;
    double mean_samples = 0.0;
    std::optional<std::string> damage;
  };
  std::optional<Previous> previous;
};

// Reads all of the file and of its previous generation, some blocks at a time. Fails (input_output)
// if the header cannot be read; the message names a previous generation that can be.
[[nodiscard]] Result<AccumulationInfo> collect_accumulation_info(const std::filesystem::path& file);

[[nodiscard]] std::string format_accumulation_table(const AccumulationInfo& info);
[[nodiscard]] std::string format_accumulation_json(const AccumulationInfo& info);

} // namespace kindling::app
