// What `kindling info` tells of an accumulation file: a checkpoint, a part, or a merge of parts.
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

// Pixels that have the same samples.
struct CoverageKind {
  BlockCoverage samples;
  uint64_t pixels = 0;
};

struct AccumulationInfo {
  std::filesystem::path file;
  uint64_t file_bytes = 0;
  int64_t saved_s = 0; // since 1970, as the file system says
  AccumulationSummary summary;
  std::filesystem::path scene_file; // as the arguments have it; empty if this program does not understand them
  WorkPart part;
  std::vector<CoverageKind> coverage; // of the most pixels first
  double mean_samples = 0.0;          // of the pixels of the area, of all samples
  double done_share = 0.0; // of the samples that it is to hold, in [0, 1]; pixels that need no more count as done
  std::optional<std::string> damage; // why it cannot be read, though its header can
  // FILE.previous, if it is there: what can be gone on from should FILE be damaged.
  struct Previous {
    std::filesystem::path file;
    int64_t saved_s = 0;
    double mean_samples = 0.0;
    std::optional<std::string> damage;
  };
  std::optional<Previous> previous;
};

// Reads all of the file and of its previous generation, some blocks at a time. Fails (input_output) where there is no header to be read; the
// message says whether there is a previous generation that can be.
[[nodiscard]] Result<AccumulationInfo> collect_accumulation_info(const std::filesystem::path& file);

[[nodiscard]] std::string format_accumulation_table(const AccumulationInfo& info);
[[nodiscard]] std::string format_accumulation_json(const AccumulationInfo& info);

} // namespace kindling::app
