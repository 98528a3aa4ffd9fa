// What a render or a merge that runs for a farm says, line by line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_worker.h"

#include <string>
#include <string_view>

namespace kindling {

// Progress for a record, the last error for its message, the rest for the log.
class ProgramLines {
 public:
  explicit ProgramLines(const FarmLog& log) : log_(log) {}

  // A line as it is written with --progress json. True where there is news of the progress.
  bool take(std::string_view line);

  double progress = 0.0;  // of the render phase
  bool rendering = false; // that phase has begun
  std::string error;      // the last, without "kindling: error: "

 private:
  const FarmLog& log_;
};

} // namespace kindling
