// The metadata of images with mattes: which names the ids stand for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/aov.h"
#include "renderer/film/write_film.h"
#include "renderer/scene/surface_names.h"

namespace kindling {

// Adds, for each matte of the set, the texts that the Cryptomatte specification asks for: name,
// hash, conversion, and the manifest, a JSON object of names and ids. Objects are the nodes with
// meshes, assets the roots above them, materials all of the file and the default one.
void add_matte_metadata(const SurfaceNames& names, AovSet aovs, ImageMetadata& metadata);

} // namespace kindling
