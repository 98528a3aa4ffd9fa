// Generated meshes and rays for the accelerator benchmarks; no files needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace kindling::accel::bench {

enum class Shape {
  hall,   // a closed hall with a terrain floor and columns: rays stay inside
  sphere, // a noisy sphere, like a scanned object: small triangles of equal size, most bounces leave
  soup,   // unconnected triangles of mixed sizes
};
inline constexpr Shape kShapes[] = {Shape::hall, Shape::sphere, Shape::soup};
[[nodiscard]] std::string shape_name(Shape shape);

// One mesh with one identity instance, ready for BuildInput.
struct BenchScene {
  std::vector<Imath::V3f> positions; // padded beyond vertex_count
  size_t vertex_count = 0;
  std::vector<uint32_t> indices;
  Imath::V3f eye, target;
  TriangleMesh mesh;
  MeshGroup group{0, 1};
  Instance instance;

  [[nodiscard]] size_t triangle_count() const { return indices.size() / 3; }
  [[nodiscard]] BuildInput input() const { return {{&mesh, 1}, {&group, 1}, {&instance, 1}, {}}; }
};

// Returns a scene of about `triangles` triangles, on the heap because the mesh points into it.
[[nodiscard]] std::unique_ptr<BenchScene> make_scene(Shape shape, size_t triangles);

// Returns camera rays in blocks of 8 x 8 pixels, one jittered ray per pixel.
[[nodiscard]] std::vector<Ray> camera_rays(const BenchScene& scene, int width, int height);
// Returns a ray from each hit in a cosine-distributed direction about its geometric normal.
[[nodiscard]] std::vector<Ray> diffuse_rays(const BenchScene& scene, const std::vector<Ray>& rays,
                                            const std::vector<Hit>& hits);
// Returns the rays with t_max set to a fraction of the size of the scene.
[[nodiscard]] std::vector<Ray> shortened(const BenchScene& scene, std::vector<Ray> rays, float fraction);

} // namespace kindling::accel::bench
