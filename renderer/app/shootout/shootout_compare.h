// Compares the JSON reports of two shootouts, as of two machines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>
#include <string>

namespace kindling::app {

// Returns tables of the second report's speed over the first one's, by scene, kind of rays, call
// and accelerator, with what else differs: processor, version, compiler, settings, geometry. Names
// are those of the files. Fails (input_output) if a text is no report, or if no scene and no
// accelerator is in both.
[[nodiscard]] Result<std::string> compare_shootouts(const std::string& first_name, const std::string& first_json,
                                                    const std::string& second_name, const std::string& second_json);

// The same for files, of at most 64 MiB.
[[nodiscard]] Result<std::string> compare_shootout_files(const std::filesystem::path& first,
                                                         const std::filesystem::path& second);

} // namespace kindling::app
