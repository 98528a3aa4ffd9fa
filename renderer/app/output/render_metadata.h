// What images say of themselves, as text: accumulation files carry it to where no scene is.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/write_film.h"
#include "renderer/session/accumulation_file.h"
#include "renderer/session/image_metadata.h"

namespace kindling::app {

// Of images made of an accumulation: those of its scene and camera, the command that renders it, and what was spent on it.
[[nodiscard]] ImageMetadata metadata_of(const Accumulation& accumulation);

} // namespace kindling::app
