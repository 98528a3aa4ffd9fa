// What images say of themselves, as text: accumulation files carry it to where no scene is.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/write_film.h"
#include "renderer/session/accumulation_file.h"

#include <string>
#include <string_view>

namespace kindling::app {

// A JSON object on one line.
[[nodiscard]] std::string metadata_to_json(const ImageMetadata& metadata);
// The same back, to the bit; what is no such text or has members of other types gives as much as can be read.
[[nodiscard]] ImageMetadata metadata_from_json(std::string_view json);

// Of images made of an accumulation: those of its scene and camera, the command that renders it, and what was spent on it.
[[nodiscard]] ImageMetadata metadata_of(const Accumulation& accumulation);

} // namespace kindling::app
