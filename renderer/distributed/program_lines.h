// Parser for the output of a farm's render or merge process, line by line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_worker.h"

#include <string>
#include <string_view>

namespace kindling {

// Extracts progress and the last error for a record, and passes all other lines to the log.
class ProgramLines {
 public:
  explicit ProgramLines(const FarmLog& log) : log_(log) {}

  // Parses a line written with --progress json. True if it updates the progress.
  bool take(std::string_view line);

  double progress = 0.0;  // of the render phase
  bool rendering = false; // the render phase has begun
  std::string error;      // the last one, without "kindling: error: "

 private:
  const FarmLog& log_;
};

} // namespace kindling
