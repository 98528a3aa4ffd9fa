// Gives points and lines their width, which depends on the distance to a camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"

namespace kindling {

// The camera at which points and lines have the width that is asked for. Elsewhere, and when they
// or the camera move, they are bodies like any other.
struct StrokeView {
  M44f camera_to_world; // rigid
  float pixel = 0.0f;   // side of a pixel: perspective, at distance 1; orthographic, in meters
  bool orthographic = false;
};

[[nodiscard]] bool has_strokes(const Scene& scene);

// Removes the primitives that are outlines. Returns how many.
size_t remove_outlines(Scene& scene);

// Moves the vertices of points and lines by half of `width_px` pixels along their offsets, which
// are then removed. Each vertex has the width of its own depth, in the first placement of its mesh
// in `rest`, the scene in its rest pose. Skins and morph targets deform the bodies like other
// meshes. Parallel; independent of the number of threads.
void size_strokes(Scene& scene, const PosedScene& rest, const StrokeView& view, float width_px);

} // namespace kindling
