// The command line that renders the image of a frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/view/frame.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kindling {

// Flags of `kindling render` that command_words() writes by the state of a view; all others that
// `kindling view` was given are passed on.
[[nodiscard]] const std::vector<std::string>& written_flags();

// Returns the words of a command line, each unquoted, that renders the pixels of a frame to the
// bit, `denoised` or as rendered. `passed_on`: flags and their values. Numbers are written so that
// reading them gives the same bits.
[[nodiscard]] std::vector<std::string> command_words(const LinearFrame& frame, const ViewState& display,
                                                     const std::filesystem::path& scene_file,
                                                     const std::vector<std::string>& passed_on, bool denoised = false);

// Returns the name of a file for the frame: "lambo-64spp.png".
[[nodiscard]] std::string frame_file_name(const LinearFrame& frame, const std::filesystem::path& scene_file,
                                          const char* extension);

} // namespace kindling
