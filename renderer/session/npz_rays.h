// Rays from NumPy's .npz files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/session/ray_set.h"

#include <filesystem>

namespace kindling {

// Reads arrays of float32 or float64 as numpy.savez() and savez_compressed() write them: `origins`
// and `directions` of shape (N, 3); optional `t_min` (0), `t_max` (infinity) and `time` (0) of
// shape (N,) or (). The result has two sets of all rays, `nearest` and `any-hit`, and the geometry
// hash 0: rays from elsewhere, for any geometry. Fails (input_output) if the file cannot be read,
// is damaged, has other shapes or types, more than 2^24 rays or 1 GiB of
// file or arrays (so that reading takes at most about 3 GB of memory), or holds a ray that none may
// be (ray_file.h). Other arrays are not read.
[[nodiscard]] Result<RayRecording> read_npz_rays(const std::filesystem::path& path);

} // namespace kindling
