// Accumulation files (.kacc): a RenderState with everything that says which image it belongs to. Checkpoints, parts and merges of
// parts are such files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/render_state.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

inline constexpr std::string_view kAccumulationExtension = ".kacc";
// FILE.kacc, or what a checkpoint leaves beside it: FILE.kacc.previous, FILE.kacc.damaged.
[[nodiscard]] bool names_accumulation(const std::filesystem::path& file);

// Which image, and how it was asked for. All texts are UTF-8.
struct AccumulationIdentity {
  std::string program; // name, version and build: "Kindling 0.7.0 (...)"; files of different ones do not mix
  std::string
      image; // JSON object, one member for each setting that the pixels depend on, keys in order; must agree to be merged
  uint64_t scene_hash = 0;            // of all bytes that were read for the scene, its environment and its profiles
  std::vector<std::string> arguments; // of the command that renders it, without the program's name
  std::filesystem::path folder;       // absolute: where the arguments' relative paths begin
  V2i size_px{0, 0};                  // of the whole image
  PixelRect crop;                     // of it that is wanted; a part's area may be less
  uint32_t samples_per_pixel = 0;     // wanted in the end
  uint32_t planned_samples = 0;       // that the sampling is laid out for: RenderSettings::planned_samples
  SampleRange part;                   // the samples that this file is to hold: of a whole render [0, samples_per_pixel)
  std::string metadata; // JSON object: what images made of it say of the scene, the camera and the render; not compared
};

struct Accumulation {
  AccumulationIdentity identity;
  RenderState state;
};

// Written beside the name, synced, renamed; what stood there before is kept as previous_accumulation(path) if `keep_previous`, and at
// every moment one of the two names is a complete file. Removes what killed writers of the same name left. Compresses on all threads of
// the caller's TBB arena. `state.film` must be of identity.size_px and of the area of the coverage. Fails (input_output), and then the
// file that was there still is; also for a coverage in so many pieces that reading it would be refused (max_coverage_bytes()).
[[nodiscard]] Result<void> write_accumulation(const std::filesystem::path& path, const AccumulationIdentity& identity,
                                              const RenderState& state, bool keep_previous);
// "NAME.previous", beside what a symbolic link leads to.
[[nodiscard]] std::filesystem::path previous_accumulation(const std::filesystem::path& path);

// Every byte of the file is under a checksum; the header has a version. Fails (input_output) where the file cannot be read, is not one of
// ours, is of another version, is cut off or damaged (with the place). Memory is asked for only for what the file is seen to hold.
[[nodiscard]] Result<Accumulation> read_accumulation(const std::filesystem::path& path);
// Whether it could be read: all of it is, some blocks at a time, so that no memory for the sums is needed. Fails as above.
[[nodiscard]] Result<void> check_accumulation(const std::filesystem::path& path);
// What it is about and what it has, without the sums: of these only the sizes are checked.
struct AccumulationSummary {
  AccumulationIdentity identity;
  Coverage coverage;
  RenderWork work;
  uint64_t sum_bytes = 0; // that the sums, and the state of adaptive sampling, take in memory
};
[[nodiscard]] Result<AccumulationSummary> read_accumulation_summary(const std::filesystem::path& path);

} // namespace kindling
