// Finds lines that only repeat the edges of triangles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <span>

namespace kindling::gltf {

// Sets Primitive::outline of the lines in one mesh that are outlines: at least three quarters of
// their segments have both ends where an edge of one of the mesh's triangles has them. `modes` has
// glTF's mode of each primitive. Parallel; independent of the number of threads.
void mark_outlines(std::span<Primitive> primitives, std::span<const int> modes);

} // namespace kindling::gltf
