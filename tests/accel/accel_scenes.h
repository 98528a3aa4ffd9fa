// Test meshes, scenes and ray generators for the accelerator tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace kindling::accel::testing {

using Imath::Box3f;
using Imath::M44f;
using Imath::V3f;

// Returns a transform that scales, then rotates about the axis (in radians), then translates.
inline M44f placed(const V3f& scale, const V3f& axis, float angle, const V3f& translation) {
  M44f m, r;
  m.setScale(scale);
  r.setAxisAngle(axis.normalized(), angle);
  m *= r;
  r.makeIdentity();
  r.setTranslation(translation);
  return m * r;
}

struct Mesh {
  std::vector<V3f> positions;
  std::vector<uint32_t> indices;
  bool opaque = true;
  std::vector<std::vector<V3f>> later; // positions at the later keys, if the mesh deforms

  uint32_t add(const V3f& p) {
    positions.push_back(p);
    return static_cast<uint32_t>(positions.size() - 1);
  }
  void add_triangle(const V3f& a, const V3f& b, const V3f& c) {
    for (const V3f& p : {a, b, c}) indices.push_back(add(p));
  }
  [[nodiscard]] V3f corner(uint32_t triangle, int k) const {
    return positions[indices[3 * triangle + static_cast<uint32_t>(k)]];
  }
  [[nodiscard]] Box3f bounds() const;
};

// Owns the data that a BuildInput borrows.
class TestScene {
 public:
  TestScene() = default;
  // A scene of one mesh with one identity instance.
  explicit TestScene(Mesh mesh) { add_instance(add_group({std::move(mesh)}), M44f()); }

  uint32_t add_group(std::vector<Mesh> meshes);
  void add_instance(uint32_t group, const M44f& object_to_world) {
    instances_.push_back({group, object_to_world, kNoId});
  }
  void add_instance(uint32_t group, std::vector<M44f> keys); // a moving instance
  void set_filter(HitFilter filter) { filter_ = filter; }

  [[nodiscard]] BuildInput input() const { return {views_, groups_, instances_, motion_views_, filter_}; }
  // Returns the static scene at one time. Triangles that are not finite at some key have no area in
  // it.
  [[nodiscard]] TestScene posed(float time) const;
  [[nodiscard]] const Mesh& mesh(uint32_t i) const { return meshes_[i]; }
  [[nodiscard]] const std::vector<Instance>& instances() const { return instances_; }
  [[nodiscard]] Box3f bounds() const; // world bounds of finite vertices

 private:
  std::deque<Mesh> meshes_; // with 16 bytes of padding in the positions' capacity
  std::deque<std::vector<std::span<const V3f>>> later_views_;
  std::vector<TriangleMesh> views_;
  std::deque<std::vector<M44f>> motions_;
  std::vector<std::span<const M44f>> motion_views_;
  std::vector<MeshGroup> groups_;
  std::vector<Instance> instances_;
  HitFilter filter_;
};

using Rng = std::mt19937;
[[nodiscard]] float uniform(Rng& rng, float low = 0.0f, float high = 1.0f);
[[nodiscard]] V3f uniform_in(Rng& rng, const Box3f& box);
[[nodiscard]] V3f uniform_direction(Rng& rng);

// Closed meshes.
[[nodiscard]] Mesh sphere(int rings, int segments, float radius, const V3f& center);
[[nodiscard]] Mesh gridded_box(int cells, const V3f& low, const V3f& high);
// Open meshes.
[[nodiscard]] Mesh triangle_soup(Rng& rng, int count, float extent, float size);
[[nodiscard]] Mesh terrain(int cells, float extent, float height);
[[nodiscard]] Mesh slivers(Rng& rng, int count);       // long and thin, with aspect ratios down to 1e-6
[[nodiscard]] Mesh coplanar_pile(Rng& rng, int count); // overlapping triangles in one axis-aligned plane
[[nodiscard]] Mesh duplicates(int count);              // copies of one triangle
[[nodiscard]] Mesh degenerate(Rng& rng, int count);    // points, lines, NaN and infinite vertices; none can be hit
[[nodiscard]] Mesh scaled(Mesh mesh, float factor);

struct NamedScene {
  std::string name;
  TestScene scene;
};
// Returns all of these meshes, some in several sizes, each as a scene without transforms.
[[nodiscard]] std::deque<NamedScene> adversarial_scenes();

// Returns random segments and lines through the box.
[[nodiscard]] std::vector<Ray> random_rays(Rng& rng, const Box3f& box, int count);
// Returns rays along the axes, with components +0 and -0, through random points and vertices.
[[nodiscard]] std::vector<Ray> axis_parallel_rays(Rng& rng, const TestScene& scene, int count);
// Returns rays almost in the planes of triangles, and exactly through vertices and edges.
[[nodiscard]] std::vector<Ray> grazing_rays(Rng& rng, const TestScene& scene, int count);

inline constexpr Kind kAllKinds[] = {Kind::brute_force, Kind::embree, Kind::kdtree};
// Returns the name suffix of a parameterized test.
[[nodiscard]] std::string kind_label(const ::testing::TestParamInfo<Kind>& info);
[[nodiscard]] std::string simd_label(const ::testing::TestParamInfo<SimdTarget>& info);

// An accelerator with one of its sets of kernels.
struct Kernels {
  Kind kind = Kind::brute_force;
  std::optional<SimdTarget> simd; // none for brute force
  bool compact = false;           // a kd-tree's compact queries (accel/kdtree/compact)
};
// Returns all kernels that this processor supports, best last for each kind.
[[nodiscard]] std::vector<Kernels> all_kernels();
[[nodiscard]] std::string kernels_label(const ::testing::TestParamInfo<Kernels>& info);

[[nodiscard]] std::unique_ptr<Accelerator> build(Kind kind, const TestScene& scene, BuildOptions options = {});
[[nodiscard]] std::unique_ptr<Accelerator> build(const Kernels& kernels, const TestScene& scene,
                                                 BuildOptions options = {});

} // namespace kindling::accel::testing
