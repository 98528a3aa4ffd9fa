// Compiled kernels in the user's cache folder: a driver takes minutes to compile them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace kindling {

// Returns the file for what a driver of this version makes of the PTX for GPUs of this capability
// (10 major + minor), in $XDG_CACHE_HOME/kindling/kernels, or in ~/.cache without that variable.
// Empty if there is no such folder.
[[nodiscard]] std::filesystem::path kernel_cache_file(std::string_view ptx, int capability, int driver_version);

// Returns the bytes of the file; none if it does not exist or cannot be read.
[[nodiscard]] std::vector<char> read_cached_kernels(const std::filesystem::path& file);

// Writes the file and its folder, and removes the oldest files there beyond eight. A cache that
// cannot be written is no error.
void cache_kernels(const std::filesystem::path& file, std::span<const char> code);

} // namespace kindling
