// Compiled kernels in the user's cache folder, a file for each.
//
// A driver takes minutes to compile some of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace kindling {

// Returns a number for the PTX of all kernels, which names its files.
[[nodiscard]] uint64_t kernel_cache_key(std::string_view ptx);

// Returns the file for what a driver of this version makes of an entry point of the PTX with this
// key, for GPUs of this capability (10 major + minor), in $XDG_CACHE_HOME/kindling/kernels, or in
// ~/.cache without that variable. Empty if there is no such folder.
[[nodiscard]] std::filesystem::path kernel_cache_file(uint64_t key, std::string_view entry, int capability,
                                                      int driver_version);

// Returns what cache_kernels() was given for the file; nothing if the file does not exist, cannot
// be read or is damaged, so that a driver never sees damaged code.
[[nodiscard]] std::vector<char> read_cached_kernels(const std::filesystem::path& file);

// The number of files in the cache: those of all kernels for a few programs and drivers.
inline constexpr size_t kMaxCachedKernels = 64;
// Writes the file and its folder, and removes the oldest files there beyond kMaxCachedKernels. A
// cache that cannot be written is no error. Several threads may call it for different files.
void cache_kernels(const std::filesystem::path& file, std::span<const char> code);

} // namespace kindling
