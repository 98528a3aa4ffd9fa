// Image metadata as JSON text, which accumulation files store for merges without a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/write_film.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/image_metadata.h"

#include <cstdint>
#include <string>

namespace kindling::app {

// The metadata of images that are made from an accumulation: scene and camera, the command that
// renders it, and the work spent.
[[nodiscard]] ImageMetadata metadata_of(const Accumulation& accumulation);

// Returns the flag, after a space, that fixes the guide of a render whose time limit chose its
// paths. Command lines that are stored end in it.
[[nodiscard]] std::string training_flag(uint64_t training_paths);
// The same for light paths, which a time limit chooses, too.
[[nodiscard]] std::string light_paths_flag(float fraction);
[[nodiscard]] std::string direct_samples_flag(int samples);
[[nodiscard]] std::string reflection_samples_flag(int samples);
[[nodiscard]] std::string path_reuse_flag(int pixels);
[[nodiscard]] std::string photons_flag(float fraction);

} // namespace kindling::app
