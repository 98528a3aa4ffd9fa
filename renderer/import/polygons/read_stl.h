// STL files, binary and text.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/file_bytes.h"
#include "renderer/import/polygons/polygon_builder.h"

namespace kindling::polygons {

// Reads the facets; their normals are those of the triangles and ignored. A file is binary if its
// size is that of the count in its header, whatever it begins with. Throws ImportFailure.
void read_stl(gltf::Bytes file, PolygonBuilder& builder);

} // namespace kindling::polygons
