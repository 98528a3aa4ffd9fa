// Reads and writes accumulation files (.kacc): a RenderState and the render that it belongs to.
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
// Returns true for FILE.kacc, and for the files that a checkpoint leaves beside it:
// FILE.kacc.previous and FILE.kacc.damaged.
[[nodiscard]] bool names_accumulation(const std::filesystem::path& file);

// Identifies a render. Made and compared in render_identity.h. All texts are UTF-8.
struct AccumulationIdentity {
  std::string program;                // program_identity(); files of different programs do not mix
  std::string image;                  // pixel_settings(); must agree to resume or merge
  uint64_t scene_hash = 0;            // over all bytes read for the scene, its environment and its profiles
  std::vector<std::string> arguments; // of the command line, without the program's name; empty: not from a command
  std::filesystem::path folder;       // absolute; relative paths in the arguments begin here
  V2i size_px{0, 0};                  // of the whole image
  PixelRect crop;                     // the wanted pixels of the image; a part may cover fewer
  uint32_t samples_per_pixel = 0;     // final number of samples
  uint32_t planned_samples = 0;       // RenderSettings::planned_samples
  SampleRange part;                   // samples that this file is to hold; of a whole render [0, samples_per_pixel)
  std::string metadata;               // metadata_to_json() of images made from it; not compared
};

struct Accumulation {
  AccumulationIdentity identity;
  RenderState state;
};

// Writes a temporary file beside the name, syncs it and renames it. With `keep_previous` the old
// file is kept as previous_accumulation(path); at every moment one of the two names is a complete
// file. Removes temporary files that killed writers of the same name left. Compresses on all
// threads of the caller's TBB arena. `state.film` must have identity.size_px and the area of the
// coverage. Fails (input_output), leaving the old file, also for a coverage with more spans than
// readers accept (max_coverage_bytes()).
[[nodiscard]] Result<void> write_accumulation(const std::filesystem::path& path, const AccumulationIdentity& identity,
                                              const RenderState& state, bool keep_previous);
// Returns "NAME.previous"; for a symbolic link, beside its target.
[[nodiscard]] std::filesystem::path previous_accumulation(const std::filesystem::path& path);

// Reads a file and verifies all checksums, which cover every byte. Fails (input_output) if the file
// cannot be read, is no accumulation file, has another version, is cut off, or is damaged (with the
// place). Allocates memory only for contents that the file is large enough to hold.
[[nodiscard]] Result<Accumulation> read_accumulation(const std::filesystem::path& path);
// Checks whether the file can be read: reads all of it, some blocks at a time, without memory for
// the sums. Fails as read_accumulation() does.
[[nodiscard]] Result<void> check_accumulation(const std::filesystem::path& path);
// The contents of a file without the sums, of which only the sizes are checked.
struct AccumulationSummary {
  AccumulationIdentity identity;
  Coverage coverage;
  RenderWork work;
  uint64_t sum_bytes = 0; // memory for the sums and the state of adaptive sampling
};
[[nodiscard]] Result<AccumulationSummary> read_accumulation_summary(const std::filesystem::path& path);

} // namespace kindling
