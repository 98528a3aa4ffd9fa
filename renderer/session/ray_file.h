// Reads and writes files of recorded rays; README.md has their layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/ray_set.h"

#include <filesystem>

namespace kindling {

inline constexpr uint32_t kRayFileVersion = 1;

// Writes a complete file or none. Fails (input_output).
[[nodiscard]] Result<void> write_ray_file(const std::filesystem::path& path, const RayRecording& recording);

// True if the numbers of a ray are ones: origin and direction finite, the direction not zero, no
// NaN as its ends.
[[nodiscard]] bool is_valid_ray(const accel::Ray& ray);

// Fails (input_output) if the file cannot be read, is no ray file, has another version or another
// size than its header gives, or holds an invalid ray: not finite, without direction, or with NaN
// as its end.
[[nodiscard]] Result<RayRecording> read_ray_file(const std::filesystem::path& path);

} // namespace kindling
