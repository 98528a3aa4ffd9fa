// Inflates the bodies of points and lines.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/strokes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace kindling {
namespace {

constexpr size_t kVertexGrain = 1U << 14;

Box3f box_of(const std::vector<V3f>& positions) {
  Box3f box;
  for (const V3f& p : positions) box.extendBy(p);
  return box;
}

// A skin may scale; the ratio of the boxes estimates how much, up to a factor of about 2.
float scale_of_skin(const std::vector<V3f>& before, const std::vector<V3f>& after) {
  const float scale = box_of(after).size().length() / box_of(before).size().length();
  return scale > 0.0f && std::isfinite(scale) ? scale : 1.0f;
}

void size_primitive(Primitive& primitive, const PosedMesh& placed, size_t index, const StrokeView& view,
                    float width_px) {
  const std::vector<V3f>& posed =
      placed.deformed.empty() ? primitive.positions : placed.deformed[index].positions; // of the space of mesh_to_world
  const float scale = primitive.joints.empty() || placed.deformed.empty()
                          ? 1.0f
                          : scale_of_skin(primitive.positions, placed.deformed[index].positions);
  const M44f& c = view.camera_to_world;
  const V3f eye(c[3][0], c[3][1], c[3][2]), back(c[2][0], c[2][1], c[2][2]);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, primitive.positions.size(), kVertexGrain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t v = range.begin(); v < range.end(); ++v) {
                        const V3f from_eye = transform_point(placed.mesh_to_world, posed[v]) - eye;
                        const float depth = -from_eye.dot(back); // behind the camera any width will do
                        const float distance = view.orthographic ? 1.0f : depth > 0.0f ? depth : from_eye.length();
                        const float radius = 0.5f * width_px * view.pixel * distance;
                        const V3f& offset = primitive.stroke_offsets[v];
                        const float unit = transform_vector(placed.mesh_to_world, offset).length() * scale;
                        if (unit > 0.0f && std::isfinite(radius / unit))
                          primitive.positions[v] += offset * (radius / unit);
                      }
                    });
}

} // namespace

bool has_strokes(const Scene& scene) {
  return std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& mesh) {
    return std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                       [](const Primitive& primitive) { return !primitive.stroke_offsets.empty(); });
  });
}

size_t remove_outlines(Scene& scene) {
  size_t removed = 0;
  for (Mesh& mesh : scene.meshes)
    removed += std::erase_if(mesh.primitives, [](const Primitive& primitive) { return primitive.outline; });
  return removed;
}

void size_strokes(Scene& scene, const PosedScene& rest, const StrokeView& view, float width_px) {
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    const auto first = std::find_if(rest.meshes.begin(), rest.meshes.end(),
                                    [&](const PosedMesh& posed) { return posed.mesh == static_cast<int>(m); });
    const PosedMesh unplaced; // shown later by an animation
    std::vector<Primitive>& primitives = scene.meshes[m].primitives;
    for (size_t p = 0; p < primitives.size(); ++p) {
      if (primitives[p].stroke_offsets.empty()) continue;
      size_primitive(primitives[p], first == rest.meshes.end() ? unplaced : *first, p, view, width_px);
      primitives[p].stroke_offsets = std::vector<V3f>();
    }
  }
}

} // namespace kindling
