// EXT_meshopt_compression and KHR_meshopt_compression: decompression of bufferViews.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"

namespace kindling::gltf {

// Returns the extension object of a buffer or bufferView, or null.
[[nodiscard]] const nlohmann::json* find_meshopt_extension(const nlohmann::json& object);

// Replaces the bytes of every compressed bufferView by decoded ones, in parallel with TBB. Throws
// ImportFailure.
void decompress_meshopt_views(Document& document);

} // namespace kindling::gltf
