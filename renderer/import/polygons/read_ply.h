// PLY files: text, and binary of either byte order.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/file_bytes.h"
#include "renderer/import/polygons/polygon_builder.h"

namespace kindling::polygons {

// Reads the elements `vertex` (x, y, z; nx, ny, nz; s, t or u, v; red, green, blue, alpha, 8-bit
// ones as sRGB) and `face` (vertex_indices or vertex_index). Other elements and properties are
// skipped. Throws ImportFailure.
void read_ply(gltf::Bytes file, PolygonBuilder& builder);

} // namespace kindling::polygons
