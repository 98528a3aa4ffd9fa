// `kindling resume`: its flags, and how they and what a checkpoint says of itself become a render.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/progress_display.h"
#include "renderer/base/result.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kindling {
struct AccumulationIdentity;
}

namespace kindling::app {

class FlagSet;
struct RenderOptions;

// Unset: as the checkpoint says.
struct ResumeOptions {
  std::filesystem::path file;   // .kacc
  std::filesystem::path folder; // where the render's relative names begin
  std::filesystem::path scene_file;
  std::optional<uint32_t> spp;
  std::vector<std::filesystem::path> outputs;
  std::filesystem::path stats_file;
  std::optional<int> threads;
  std::optional<double> time_limit_s;
  std::optional<double> checkpoint_every_s;
  std::optional<ProgressMode> progress;
  bool quiet = false;
  bool verbose = false;
};

void add_resume_flags(FlagSet& flags, ResumeOptions& options);
[[nodiscard]] Result<void> check_resume_flags(const FlagSet& flags, const ResumeOptions& options);

// The arguments of the render that goes on with this checkpoint: those it was begun with, and more samples if they are asked for, laid out
// as the first ones.
[[nodiscard]] std::vector<std::string> resumed_arguments(const AccumulationIdentity& identity,
                                                         const ResumeOptions& resume);

// Puts the flags of `resume`, which are about this run alone, over those of the render.
void override_render(const ResumeOptions& resume, RenderOptions& options);

} // namespace kindling::app
