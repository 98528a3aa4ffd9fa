// The flags of the files that finished pixels go to: their names, and how values become theirs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"

#include <string>

namespace kindling::app {

// -o, for RenderOptions::outputs. `default_name` stands in the help as what is written without it.
void add_output_flag(FlagSet& flags, RenderOptions& options, const std::string& default_name);
// --exr-float, --png-bits, --jpeg-quality, --view, --exposure, --ocio.
void add_image_format_flags(FlagSet& flags, RenderOptions& options);

} // namespace kindling::app
