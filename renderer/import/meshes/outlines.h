// Finds lines that only repeat the edges of triangles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/scene/scene.h"

#include <span>

namespace kindling::gltf {

// Sets Primitive::outline of all primitives of one mesh: of those of LINES, LINE_STRIP or LINE_LOOP
// at least three quarters of whose segments are edges of triangles of this mesh, with the same
// positions at both ends. `modes` has glTF's mode of each primitive. Parallel; independent of the
// number of threads.
void mark_outlines(std::span<Primitive> primitives, std::span<const int> modes);

} // namespace kindling::gltf
