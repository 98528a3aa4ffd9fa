// `kindling resume`: from a checkpoint to the command line of the render that goes on with it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/options/options.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/base/result.h"

#include <string>
#include <vector>

namespace kindling {
struct AccumulationIdentity;
}

namespace kindling::app {

// A render with a checkpoint that must be there. Makes the folder that it was begun in, or resume.folder, the current one, from which its
// relative names begin; those of `resume` begin at the current folder of before. Fails (input_output) if the file or the folder cannot be
// read, (usage) if another program made it.
[[nodiscard]] Result<CommandLine> resume_command_line(const ResumeOptions& resume);

// The arguments of the render that goes on with this checkpoint: those it was begun with, and more samples if they are asked for, laid out
// as the first ones.
[[nodiscard]] std::vector<std::string> resumed_arguments(const AccumulationIdentity& identity,
                                                         const ResumeOptions& resume);

// Puts the flags of `resume`, which are about this run alone, over those of the render.
void override_render(const ResumeOptions& resume, RenderOptions& options);

} // namespace kindling::app
