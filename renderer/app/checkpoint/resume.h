// Turns a checkpoint and the flags of `kindling resume` into the options of a render.
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

// Returns a render whose checkpoint must exist. Changes the current folder to the one that the
// render was started in, or to resume.folder, because relative names of the render begin there;
// names in `resume` are relative to the folder before the change. Fails (input_output) if the file
// or the folder cannot be read, (usage) if another program wrote the file.
[[nodiscard]] Result<CommandLine> resume_command_line(const ResumeOptions& resume);

// Returns the arguments that the render was started with, followed by --spp and --planned-spp if
// more samples are asked for.
[[nodiscard]] std::vector<std::string> resumed_arguments(const AccumulationIdentity& identity,
                                                         const ResumeOptions& resume);

// Overrides the options of the render with the flags of `resume`, which concern this run alone.
void override_render(const ResumeOptions& resume, RenderOptions& options);

} // namespace kindling::app
