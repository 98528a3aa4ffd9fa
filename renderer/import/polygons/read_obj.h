// Wavefront OBJ files: vertices, normals, texture coordinates and faces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/file_bytes.h"
#include "renderer/import/polygons/polygon_builder.h"

namespace kindling::polygons {

// Everything else (groups, materials, curves, lines) is ignored. Normals and texture coordinates
// are read if every corner of every face has them. Throws ImportFailure.
void read_obj(gltf::Bytes file, gltf::Warnings& warnings, PolygonBuilder& builder);

} // namespace kindling::polygons
