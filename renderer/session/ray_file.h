// Ray sets in files, so that anybody's accelerator can race on the same rays. README.md has the layout of the bytes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/ray_set.h"

#include <filesystem>

namespace kindling {

inline constexpr uint32_t kRayFileVersion = 1;

// Complete or not at all. Fails (input_output) if it cannot be written.
[[nodiscard]] Result<void> write_ray_file(const std::filesystem::path& path, const RayRecording& recording);

// Fails (input_output) if it cannot be read, is no ray file, is of another version, has more or fewer bytes than its header
// says, or holds a ray that is none: not finite, without direction, or with an end that is not a number.
[[nodiscard]] Result<RayRecording> read_ray_file(const std::filesystem::path& path);

} // namespace kindling
