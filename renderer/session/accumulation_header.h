// Converts the header of an accumulation file to JSON and back: identity, coverage and planes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/film/film.h"
#include "renderer/session/accumulation_file.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// An array of records of a fixed size.
struct StoredPlane {
  std::string name;
  size_t record_bytes = 0;
  size_t records = 0;
  bool operator==(const StoredPlane&) const = default;
};

struct AccumulationHeader {
  AccumulationSummary summary; // after reading its coverage has no blocks yet: see ParsedHeader
  AovSet aovs;
  bool trims_outliers = false;
  std::optional<PixelRect> splat_area; // of light paths; unset: none
  std::vector<std::string> light_groups;
  bool adaptive = false;
  uint64_t matte_terms = 0; // of all pixels (FlatMattes); 0 without mattes
};

// Returns the memory that the planes take together.
[[nodiscard]] uint64_t byte_count(std::span<const StoredPlane> planes);
// Returns the maximum memory for the spans of a coverage beside such planes. A few bytes of JSON
// can give the spans of all blocks at once, so they need a bound.
[[nodiscard]] uint64_t max_coverage_bytes(std::span<const StoredPlane> planes);

// Returns the planes of film, adaptive sampling and mattes in the order of the file.
[[nodiscard]] std::vector<StoredPlane> planes_of(const AccumulationHeader& header, const PixelRect& area);

[[nodiscard]] std::string header_to_json(const AccumulationHeader& header);

// A header as read. The coverage is expanded by coverage_of() once the file is known to be as large
// as it claims.
struct ParsedHeader {
  AccumulationHeader header;
  PixelRect area;
  std::vector<StoredPlane> planes;
  // Consecutive blocks with the same coverage.
  struct CoverageRun {
    size_t blocks = 0;
    BlockCoverage coverage;
  };
  std::vector<CoverageRun> runs; // all blocks of the area
};
// Fails (input_output) with a message that lacks the name of the file.
[[nodiscard]] Result<ParsedHeader> header_from_json(std::string_view json);
[[nodiscard]] Coverage coverage_of(const ParsedHeader& parsed);

} // namespace kindling
