// Image metadata as JSON text, which accumulation files store for merges without a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/write_film.h"
#include "renderer/session/accumulation_file.h"

#include <string>
#include <string_view>

namespace kindling::app {

// Returns a JSON object on one line.
[[nodiscard]] std::string metadata_to_json(const ImageMetadata& metadata);
// The inverse, exact to the bit. Returns as much as can be read of malformed text or members of
// other types.
[[nodiscard]] ImageMetadata metadata_from_json(std::string_view json);

// The metadata of images that are made from an accumulation: scene and camera, the command that
// renders it, and the work spent.
[[nodiscard]] ImageMetadata metadata_of(const Accumulation& accumulation);

} // namespace kindling::app
