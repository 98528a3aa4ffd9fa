// Contacts of large triangles: marked cells, and nothing where nothing touches.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/find_contacts.h"

#include "renderer/base/hash.h"
#include "tests/integrator/test_scenes.h"

#include <tbb/global_control.h>

#include <chrono>

namespace kindling::test {
namespace {

Geometry geometry_of(const std::vector<Primitive>& primitives) {
  Primitive all;
  for (const Primitive& primitive : primitives) {
    const auto first = static_cast<uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), primitive.positions.begin(), primitive.positions.end());
    for (const uint32_t index : primitive.indices) all.indices.push_back(first + index);
  }
  return make_geometry({std::move(all), M44f(), 0, false, {}}, Material());
}

std::unique_ptr<const Contacts> contacts_of(const Geometry& geometry, const M44f& place = M44f(),
                                            const CancelToken* cancel = nullptr) {
  const std::vector<accel::MeshGroup> groups{{0, 1}};
  std::vector<WorldInstance> instances(1);
  instances[0].object_to_world = place;
  instances[0].identity = place == M44f();
  Box3f bounds;
  for (const V3f& p : geometry.positions) bounds.extendBy(transform_point(place, p));
  return find_contacts({std::span(&geometry, 1), groups, instances, {}, bounds}, cancel);
}

accel::Hit hit_of(uint32_t triangle, float u, float v) {
  return {.t = 1.0f, .u = u, .v = v, .instance = 0, .mesh = 0, .triangle = triangle};
}

// A floor of two triangles: (0, 0), (4, 0), (4, 4) and (0, 0), (4, 4), (0, 4) in x and -z.
Primitive floor() { return quad(V3f(0, 0, 0), V3f(4, 0, 0), V3f(0, 0, -4), 0); }

TEST(Contacts, ConvexCornersAndFlatNeighborsTouchNothingInside) {
  EXPECT_EQ(contacts_of(geometry_of({floor()})), nullptr);
  // A wall that rises from the edge of the floor, upright and outwards.
  EXPECT_EQ(contacts_of(geometry_of({floor(), quad(V3f(0, 0, 0), V3f(4, 0, 0), V3f(0, 3, 0), 0)})), nullptr);
  EXPECT_EQ(contacts_of(geometry_of({floor(), quad(V3f(0, 0, 0), V3f(4, 0, 0), V3f(0, 3, 2), 0)})), nullptr);
  EXPECT_EQ(contacts_of(geometry_of({sphere(V3f(0.0f), 1.0f, 16, 0)})), nullptr);
}

TEST(Contacts, MarkCellsUnderAWall) {
  // From x = 1 to x = 2 at z = -0.6, on the first triangle. There x = 4 (u + v) and z = -4 v.
  for (const float low : {0.0f, -1.0f}) { // it stands on the floor, or pierces it
    const auto contacts = contacts_of(geometry_of({floor(), quad(V3f(1, low, -0.6f), V3f(1, 0, 0), V3f(0, 3, 0), 0)}));
    ASSERT_NE(contacts, nullptr);
    for (const float x : {1.01f, 1.5f, 1.99f}) EXPECT_TRUE(contacts->at(hit_of(0, (x - 0.6f) / 4.0f, 0.15f))) << x;
    EXPECT_FALSE(contacts->at(hit_of(0, 0.6f, 0.15f)));
    EXPECT_FALSE(contacts->at(hit_of(0, 0.15f, 0.6f)));
    EXPECT_FALSE(contacts->at(hit_of(1, 0.15f, 0.15f)));
    // Two cells beside the wall, and beyond its end.
    EXPECT_FALSE(contacts->at(hit_of(0, 0.225f, 0.15f + 2.0f / 64.0f)));
    EXPECT_FALSE(contacts->at(hit_of(0, 0.35f + 2.0f / 64.0f, 0.15f)));
    EXPECT_FALSE(contacts->at(hit_of(7, 0.15f, 0.15f)));
  }
}

TEST(Contacts, EveryPointOfADiagonalWallIsMarked) {
  const V3f from(0.3f, 0, -0.1f), along(3.4f, 0, -2.9f);
  const Geometry geometry = geometry_of({floor(), quad(from, along, V3f(0, 1, 0), 0)});
  for (const M44f& place : {M44f(), M44f().setTranslation(V3f(100, 50, -70))}) {
    const auto contacts = contacts_of(geometry, place);
    ASSERT_NE(contacts, nullptr);
    int inside = 0;
    for (int i = 1; i < 1000; ++i) {
      const V3f p = from + along * (static_cast<float>(i) / 1000.0f);
      const float v = -p.z / 4.0f, u = p.x / 4.0f - v;
      if (u < 1e-3f) continue;
      ++inside;
      EXPECT_TRUE(contacts->at(hit_of(0, u, v))) << i;
    }
    EXPECT_GT(inside, 900);
  }
}

// Another triangle in the same place touches every cell, so that its further copies are skipped.
TEST(Contacts, CoincidentTrianglesTouchEverywhere) {
  std::vector<Primitive> scene{floor()};
  Primitive copies;
  copies.positions = {V3f(1, 1, 0), V3f(3, 1, 0.5f), V3f(1, 2, 0.25f)};
  for (int copy = 0; copy < 100'000; ++copy) copies.indices.insert(copies.indices.end(), {0, 1, 2});
  scene.push_back(copies);
  const auto contacts = contacts_of(geometry_of(scene));
  ASSERT_NE(contacts, nullptr);
  for (int u = 0; u < 64; ++u)
    for (int v = 0; u + v < 64; ++v)
      EXPECT_TRUE(contacts->at(hit_of(2, static_cast<float>(u) / 64.0f, static_cast<float>(v) / 64.0f)))
          << u << " " << v;
}

// Each needle lies in the boxes of thousands of others: the search keeps to the larger triangles.
TEST(Contacts, NeedlesAreComparedWithTheLargestOnly) {
  std::vector<Primitive> scene{floor(), quad(V3f(1, 0, -0.6f), V3f(1, 0, 0), V3f(0, 3, 0), 0)};
  Primitive needles;
  uint32_t h = 1;
  const auto number = [&h] {
    h = hash_u32(h + 1);
    return static_cast<float>(h) * 0x1p-32f;
  };
  for (uint32_t i = 0; i < 40'000; ++i) {
    const V3f a(3.0f * number(), 0.5f + 2.5f * number(), -3.0f * number());
    const V3f b(3.0f * number(), 0.5f + 2.5f * number(), -3.0f * number());
    needles.positions.insert(needles.positions.end(), {a, b, b + V3f(1e-4f, 0, 0)});
    needles.indices.insert(needles.indices.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  }
  scene.push_back(needles);
  const Geometry geometry = geometry_of(scene);
  const auto start = std::chrono::steady_clock::now();
  const auto contacts = contacts_of(geometry);
  // Milliseconds; without a limit 1.6 billion pairs would take minutes.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
  ASSERT_NE(contacts, nullptr);
  EXPECT_TRUE(contacts->at(hit_of(0, 0.225f, 0.15f)));
  CancelToken cancel;
  cancel.cancel();
  EXPECT_EQ(contacts_of(geometry, M44f(), &cancel), nullptr);
}

// Many instances of a mesh count by their bounds, and the time does not grow with their triangles.
TEST(Contacts, ManyInstancesCountByTheirBounds) {
  std::vector<Geometry> geometries;
  geometries.push_back(geometry_of({floor()}));
  geometries.push_back(geometry_of({sphere(V3f(0.0f), 0.1f, 32, 0)}));
  const std::vector<accel::MeshGroup> groups{{0, 1}, {1, 1}};
  std::vector<WorldInstance> instances(1);
  instances[0].identity = true;
  WorldInstance copy;
  copy.group = 1;
  copy.identity = false;
  copy.object_to_world.setTranslation(V3f(1.0f, 0.0f, -0.5f));
  instances.insert(instances.end(), 100'000, copy);
  const Box3f bounds(V3f(0, -1, -4), V3f(4, 1, 0));
  const auto contacts = find_contacts({geometries, groups, instances, {}, bounds});
  ASSERT_NE(contacts, nullptr);
  EXPECT_TRUE(contacts->at(hit_of(0, (1.0f - 0.5f) / 4.0f, 0.5f / 4.0f)));
  EXPECT_FALSE(contacts->at(hit_of(0, 0.5f, 0.4f)));
}

TEST(Contacts, SmallTrianglesHaveNone) {
  std::vector<Primitive> scene{floor()};
  const float side = 4.0f * kLargeTriangle; // its diagonal is below the limit, that of the scene above 5.6
  scene.push_back(quad(V3f(6, 0, 0), V3f(side, 0, 0), V3f(0, 0, -side), 0));
  scene.push_back(quad(V3f(6 + side * 0.4f, 0, -side * 0.3f), V3f(side * 0.2f, 0, 0), V3f(0, 1, 0), 0));
  EXPECT_EQ(contacts_of(geometry_of(scene)), nullptr);
}

TEST(Contacts, AreTheSameForAnyNumberOfThreads) {
  std::vector<Primitive> scene{floor()};
  for (int i = 0; i < 2000; ++i) {
    const float f = static_cast<float>(i) / 2000.0f;
    const V3f corner(4.0f * f, -0.1f, -3.9f * std::fmod(f * 37.0f, 1.0f));
    scene.push_back(quad(corner, V3f(0.02f, 0, 0.01f), V3f(0, 0.2f, 0), 0));
  }
  const Geometry geometry = geometry_of(scene);
  const auto cells = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto contacts = contacts_of(geometry);
    std::vector<bool> marked;
    for (uint32_t triangle = 0; triangle < 2; ++triangle)
      for (int i = 0; i < 64; ++i)
        marked.push_back(contacts->at(
            hit_of(triangle, static_cast<float>(i % 8) / 8.0f + 0.05f, static_cast<float>(i / 8) / 8.0f + 0.05f)));
    return marked;
  };
  EXPECT_EQ(cells(1), cells(4));
}

} // namespace
} // namespace kindling::test
