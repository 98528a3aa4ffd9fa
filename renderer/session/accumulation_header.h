// The header of an accumulation file as JSON: what the file is about, what it has, and how its planes lie in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/film/film.h"
#include "renderer/session/accumulation_file.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// An array of the file: records of a fixed size.
struct StoredPlane {
  std::string name;
  size_t record_bytes = 0;
  size_t records = 0;
  bool operator==(const StoredPlane&) const = default;
};

struct AccumulationHeader {
  AccumulationSummary summary; // where read: its coverage has no blocks yet, see below
  AovSet aovs;
  bool trims_outliers = false;
  bool adaptive = false;
};

// Of the planes together, in memory.
[[nodiscard]] uint64_t byte_count(std::span<const StoredPlane> planes);
// That the spans of a coverage may take beside such planes: a few bytes of JSON say for all blocks at once how many each has.
[[nodiscard]] uint64_t max_coverage_bytes(std::span<const StoredPlane> planes);

// The planes of film and adaptive sampling that such a file has, in their order.
[[nodiscard]] std::vector<StoredPlane> planes_of(const AccumulationHeader& header, const PixelRect& area);

[[nodiscard]] std::string header_to_json(const AccumulationHeader& header);

// A header that is read, and what of it asks for memory by its numbers: made once the file has been seen to be as large as it says.
struct ParsedHeader {
  AccumulationHeader header;
  PixelRect area;
  std::vector<StoredPlane> planes;
  // Blocks of the same coverage in a row.
  struct CoverageRun {
    size_t blocks = 0;
    BlockCoverage coverage;
  };
  std::vector<CoverageRun> runs; // of all blocks of the area
};
// Fails (input_output) with what is wrong, without the file's name.
[[nodiscard]] Result<ParsedHeader> header_from_json(std::string_view json);
[[nodiscard]] Coverage coverage_of(const ParsedHeader& parsed);

} // namespace kindling
