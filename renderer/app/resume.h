// `kindling resume`: from a checkpoint to the command line of the render that goes on with it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options.h"
#include "renderer/app/resume_flags.h"
#include "renderer/base/result.h"

namespace kindling::app {

// A render with a checkpoint that must be there. Makes the folder that it was begun in, or resume.folder, the current one, from which its
// relative names begin; those of `resume` begin at the current folder of before. Fails (input_output) if the file or the folder cannot be
// read, (usage) if another program made it.
[[nodiscard]] Result<CommandLine> resume_command_line(const ResumeOptions& resume);

} // namespace kindling::app
