// The flags of output images that several commands share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"

#include <string>

namespace kindling::app {

// -o, for RenderOptions::outputs. `default_name` is printed in the help as the default.
void add_output_flag(FlagSet& flags, RenderOptions& options, const std::string& default_name);
// --exr-float, --png-bits, --jpeg-quality, --cryptomatte-levels, --denoise, --view, --exposure,
// --ocio.
void add_image_format_flags(FlagSet& flags, RenderOptions& options);
// All flags of a command that changes a finished image: both of the above, --threads, --quiet,
// --verbose.
void add_finished_image_flags(FlagSet& flags, RenderOptions& options, const std::string& default_name);

} // namespace kindling::app
