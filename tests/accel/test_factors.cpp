// Difficult meshes cost no more than a stated factor of a typical one with as many triangles.
//
// The factors of visits and references are counted, so they are the same on every machine; those of
// builds are of processor time. tests/faults/bounds.py --factors measures times of rays, and
// Embree.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>

namespace kindling::accel::testing {
namespace {

constexpr int kTriangles = 20000;
const Box3f kCube(V3f(-1), V3f(1));

void add_box(Mesh& mesh, float half) {
  constexpr uint32_t kFaces[] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (unsigned i = 0; i < 8; ++i)
    mesh.add(V3f((i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half));
  for (const uint32_t index : kFaces) mesh.indices.push_back(first + index);
}

Mesh nested_boxes() {
  Mesh mesh;
  for (int i = 0; i < kTriangles / 12; ++i) add_box(mesh, 0.5f + 0.5f * static_cast<float>(i) * 12.0f / kTriangles);
  return mesh;
}

Mesh nested_spheres() {
  Mesh mesh;
  const Mesh one = sphere(6, 8, 1.0f, V3f(0));
  const auto count = kTriangles / (one.indices.size() / 3);
  for (size_t i = 0; i < count; ++i) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const V3f& p : one.positions) mesh.add(p * (0.5f + 0.5f * static_cast<float>(i) / static_cast<float>(count)));
    for (const uint32_t index : one.indices) mesh.indices.push_back(first + index);
  }
  return mesh;
}

Mesh needles() {
  Rng rng(2);
  Mesh mesh;
  for (int i = 0; i < kTriangles; ++i) {
    const V3f a = uniform_in(rng, kCube), b = uniform_in(rng, kCube);
    mesh.add_triangle(a, b, b + uniform_direction(rng) * 1e-4f);
  }
  return mesh;
}

void add_random_triangle(Mesh& mesh, Rng& rng, const Box3f& within) {
  const V3f corners[] = {uniform_in(rng, within), uniform_in(rng, within), uniform_in(rng, within)};
  mesh.add_triangle(corners[0], corners[1], corners[2]);
}

// Triangles of sizes between 10^low and 10^high.
Mesh soup(float low, float high) {
  Rng rng(4);
  Mesh mesh;
  for (int i = 0; i < kTriangles; ++i) {
    const float size = std::pow(10.0f, uniform(rng, low, high));
    const V3f at = uniform_in(rng, kCube);
    const Box3f around(at - V3f(size), at + V3f(size));
    add_random_triangle(mesh, rng, around);
  }
  return mesh;
}

// A cluster of 0.1 mm, and two triangles 2 km apart.
Mesh cluster() {
  Rng rng(3);
  Mesh mesh;
  const Box3f spot(V3f(-5e-5f), V3f(5e-5f));
  for (int i = 0; i < kTriangles - 2; ++i) {
    const V3f at = uniform_in(rng, spot);
    const Box3f around(at, at + V3f(1e-6f));
    add_random_triangle(mesh, rng, around);
  }
  for (const float x : {-1000.0f, 1000.0f}) mesh.add_triangle(V3f(x, 0, 0), V3f(x, 1, 0), V3f(x, 0, 1));
  return mesh;
}

// Lines between random points of a box.
std::vector<Ray> lines_in(const Box3f& box, int count) {
  Rng rng(5);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const V3f a = uniform_in(rng, box), b = uniform_in(rng, box);
    rays.push_back({.origin = a, .direction = (b - a).normalized(), .t_max = (b - a).length()});
  }
  return rays;
}

struct Cost {
  double build_s = 0.0;    // processor time of one thread
  double references = 0.0; // for each triangle
  double visits = 0.0;     // of a ray: nodes and groups of four triangles, which take about as long
};

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Cost cost_of(const TestScene& scene, const Box3f& region, int builds) {
  Cost cost;
  cost.build_s = 1e9;
  std::unique_ptr<Accelerator> tree;
  tbb::task_arena(1).execute([&] {
    for (int i = 0; i < builds; ++i) {
      const double start = processor_s();
      tree = build(Kind::kdtree, scene);
      cost.build_s = std::min(cost.build_s, processor_s() - start);
    }
  });
  cost.references = static_cast<double>(tree->statistics().reference_count) / kTriangles;
  const std::vector<Ray> rays = lines_in(region, 500);
  for (const Ray& ray : rays) {
    const TraversalCost of = tree->traversal_cost(ray, false).value();
    cost.visits += (of.nodes + 0.25 * of.triangles) / static_cast<double>(rays.size());
  }
  return cost;
}

// Bounds: a fifth above what was counted, and three times the processor time that was measured.
struct Shape {
  const char* name;
  std::function<Mesh()> mesh;
  Box3f region; // of the rays
  double build; // factors over the typical mesh
  double visits;
  double references; // for each triangle
};

TEST(KdTreeFactors, DifficultMeshesStayWithinFactorsOfATypicalOne) {
  const int cells = static_cast<int>(std::lround(std::sqrt(kTriangles / 2)));
  const TestScene typical(terrain(cells, 2.0f, 0.1f));
  const Cost one = cost_of(typical, typical.bounds(), 5);
  std::printf("%-12s build %7.3f s  visits %8.1f  references %.2f\n", "typical", one.build_s, one.visits,
              one.references);
  const Box3f spot(V3f(-5e-5f), V3f(5e-5f));
  const Shape shapes[] = {
      {"needles", needles, kCube, 65, 90, 7.5},
      {"all sizes", [] { return soup(-4.0f, 0.0f); }, kCube, 8, 1.2, 4.5},
      {"large", [] { return soup(0.0f, 0.0f); }, kCube, 72, 93, 7.5},
      {"boxes", nested_boxes, kCube, 8, 106, 5},
      {"spheres", nested_spheres, kCube, 21, 7.8, 7.2},
      {"one cell", cluster, spot, 3, 3, 1.1},
      {"copies", [] { return duplicates(kTriangles); }, kCube, 1, 205, 1},
  };
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(shape.name);
    const Cost cost = cost_of(TestScene(shape.mesh()), shape.region, 2);
    std::printf("%-12s build %7.2f    visits %8.1f  references %.2f\n", shape.name, cost.build_s / one.build_s,
                cost.visits / one.visits, cost.references);
    EXPECT_LE(cost.build_s, shape.build * one.build_s);
    EXPECT_LE(cost.visits, shape.visits * one.visits);
    EXPECT_LE(cost.references, shape.references);
  }
}

// The margins of its cells are those of its own triangles, not of the scene.
TEST(KdTreeFactors, ClusterFarFromOthersHasTheOraclesHits) {
  const TestScene scene(cluster());
  const auto tree = build(Kind::kdtree, scene), oracle = build(Kind::brute_force, scene);
  Rng rng(7);
  std::vector<Ray> rays = lines_in(Box3f(V3f(-5e-5f), V3f(5e-5f)), 300);
  for (const Ray& ray : grazing_rays(rng, scene, 300)) rays.push_back(ray);
  for (const Ray& ray : axis_parallel_rays(rng, scene, 200)) rays.push_back(ray);
  std::vector<Hit> hits(rays.size());
  tree->intersect(rays, hits);
  int found = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const Hit expected = oracle->intersect(rays[i]), hit = tree->intersect(rays[i]);
    found += expected.is_hit() ? 1 : 0;
    EXPECT_EQ(std::memcmp(&hit, &expected, sizeof(Hit)), 0);
    EXPECT_EQ(std::memcmp(&hits[i], &expected, sizeof(Hit)), 0);
  }
  EXPECT_GT(found, 200);
}

} // namespace
} // namespace kindling::accel::testing
