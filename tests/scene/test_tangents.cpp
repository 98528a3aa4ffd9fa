// Tests of tangents of meshes with known results: planes, seams, spheres, degenerate triangles.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/tangents.h"
#include "tests/scene/scene_checks.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::expect_near;
using test::xyz;

// A grid of n x n quads in [0, 1]^2 of the xy plane, facing +z, its image upright: u = x, v = 1 -
// y.
Primitive plane(uint32_t n) {
  Primitive primitive;
  primitive.texcoords.resize(1);
  for (uint32_t j = 0; j <= n; ++j) {
    for (uint32_t i = 0; i <= n; ++i) {
      const float x = static_cast<float>(i) / static_cast<float>(n);
      const float y = static_cast<float>(j) / static_cast<float>(n);
      primitive.positions.push_back({x, y, 0});
      primitive.normals.push_back({0, 0, 1});
      primitive.texcoords[0].push_back({x, 1 - y});
    }
  }
  for (uint32_t j = 0; j < n; ++j) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      for (const uint32_t v : {a, b, d, a, d, c}) primitive.indices.push_back(v);
    }
  }
  return primitive;
}

// Latitudes and longitudes with smooth normals; the column at the seam is doubled.
Primitive sphere(uint32_t rings, uint32_t columns) {
  Primitive primitive;
  primitive.texcoords.resize(1);
  for (uint32_t j = 0; j <= rings; ++j) {
    for (uint32_t i = 0; i <= columns; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(columns);
      const float v = static_cast<float>(j) / static_cast<float>(rings);
      const float theta = v * kPi;
      const float phi = (i == columns ? 0.0f : u) * 2.0f * kPi; // the seam is closed exactly
      const V3f n(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
      const V3f pole(0, j == 0 ? 1.0f : -1.0f, 0);
      primitive.positions.push_back(j == 0 || j == rings ? pole : n);
      primitive.normals.push_back(j == 0 || j == rings ? pole : n);
      primitive.texcoords[0].push_back({u, v});
    }
  }
  for (uint32_t j = 0; j < rings; ++j) {
    for (uint32_t i = 0; i < columns; ++i) {
      const uint32_t a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      for (const uint32_t v : {a, c, d, a, d, b}) primitive.indices.push_back(v);
    }
  }
  return primitive;
}

TEST(Tangents, PointAlongUOnPlane) {
  Primitive primitive = plane(4);
  generate_tangents(primitive, 0);
  ASSERT_EQ(primitive.positions.size(), 25u); // no vertex is split
  ASSERT_EQ(primitive.tangents.size(), 25u);
  for (const V4f& tangent : primitive.tangents) {
    expect_near(xyz(tangent), {1, 0, 0});
    EXPECT_EQ(tangent.w, 1.0f); // cross(z, x) = y: up in the image
  }
}

TEST(Tangents, FollowRotatedAndMirroredTexcoords) {
  Primitive turned = plane(2);
  for (V2f& uv : turned.texcoords[0]) uv = {uv.y, 1 - uv.x}; // u along -y, v along -x
  generate_tangents(turned, 0);
  for (const V4f& tangent : turned.tangents) {
    expect_near(xyz(tangent), {0, -1, 0});
    EXPECT_EQ(tangent.w, 1.0f); // cross(z, -y) = x: along decreasing v
  }
  Primitive mirrored = plane(2);
  for (V2f& uv : mirrored.texcoords[0]) uv.x = 1 - uv.x;
  generate_tangents(mirrored, 0);
  for (const V4f& tangent : mirrored.tangents) {
    expect_near(xyz(tangent), {-1, 0, 0});
    EXPECT_EQ(tangent.w, -1.0f);
  }
}

TEST(Tangents, UseRequestedTexcoordSet) {
  Primitive primitive = plane(2);
  primitive.texcoords.push_back(primitive.texcoords[0]);
  for (V2f& uv : primitive.texcoords[1]) uv = {uv.y, 1 - uv.x};
  generate_tangents(primitive, 1);
  expect_near(xyz(primitive.tangents[0]), {0, -1, 0});
}

// An image mirrored about the middle column: u = |2x - 1|.
Primitive mirrored_in_the_middle(uint32_t n) {
  Primitive primitive = plane(n);
  for (size_t v = 0; v < primitive.positions.size(); ++v) {
    primitive.texcoords[0][v].x = std::abs(2.0f * primitive.positions[v].x - 1.0f);
  }
  return primitive;
}

TEST(Tangents, SplitVerticesAtMirrorSeam) {
  constexpr uint32_t n = 4;
  Primitive primitive = mirrored_in_the_middle(n);
  const size_t before = primitive.positions.size();
  generate_tangents(primitive, 0);
  EXPECT_EQ(primitive.positions.size(), before + n + 1); // the middle column is duplicated
  for (size_t t = 0; t < primitive.triangle_count(); ++t) {
    float center_x = 0;
    for (size_t k = 0; k < 3; ++k) center_x += primitive.positions[primitive.indices[3 * t + k]].x / 3;
    for (size_t k = 0; k < 3; ++k) {
      const V4f& tangent = primitive.tangents[primitive.indices[3 * t + k]];
      expect_near(xyz(tangent), {center_x < 0.5f ? -1.0f : 1.0f, 0, 0});
      EXPECT_EQ(tangent.w, center_x < 0.5f ? -1.0f : 1.0f);
    }
  }
}

TEST(Tangents, SplittingCopiesAllAttributes) {
  Primitive primitive = mirrored_in_the_middle(2);
  const size_t count = primitive.positions.size();
  primitive.texcoords.push_back({});
  primitive.targets.resize(2);
  for (size_t set = 0; set < 2; ++set) {
    for (size_t v = 0; v < count; ++v) {
      primitive.joints.push_back({static_cast<uint16_t>(v), static_cast<uint16_t>(set), 0, 0});
      primitive.weights.push_back(V4f(static_cast<float>(v), static_cast<float>(set), 0, 0));
    }
  }
  for (size_t v = 0; v < count; ++v) {
    const auto f = static_cast<float>(v);
    primitive.colors.push_back({f, 0, 0, 1});
    primitive.texcoords[1].push_back({f, -f});
    primitive.targets[0].positions.push_back({f, 1, 2});
    primitive.targets[1].normals.push_back({f, 3, 4});
    primitive.targets[1].tangents.push_back({f, 5, 6});
  }
  const Primitive original = primitive;
  generate_tangents(primitive, 0);
  const size_t after = primitive.positions.size();
  ASSERT_EQ(after, count + 3);
  ASSERT_EQ(primitive.joints.size(), 2 * after);
  ASSERT_EQ(primitive.weights.size(), 2 * after);
  EXPECT_TRUE(primitive.targets[0].normals.empty());
  for (size_t c = 0; c < primitive.indices.size(); ++c) {
    const size_t now = primitive.indices[c], was = original.indices[c];
    ASSERT_LT(now, after);
    EXPECT_EQ(primitive.positions[now], original.positions[was]);
    EXPECT_EQ(primitive.normals[now], original.normals[was]);
    EXPECT_EQ(primitive.texcoords[0][now], original.texcoords[0][was]);
    EXPECT_EQ(primitive.texcoords[1][now], original.texcoords[1][was]);
    EXPECT_EQ(primitive.colors[now], original.colors[was]);
    EXPECT_EQ(primitive.targets[0].positions[now], original.targets[0].positions[was]);
    EXPECT_EQ(primitive.targets[1].normals[now], original.targets[1].normals[was]);
    EXPECT_EQ(primitive.targets[1].tangents[now], original.targets[1].tangents[was]);
    for (size_t set = 0; set < 2; ++set) {
      EXPECT_EQ(primitive.joints[set * after + now], original.joints[set * count + was]);
      EXPECT_EQ(primitive.weights[set * after + now], original.weights[set * count + was]);
    }
  }
}

TEST(Tangents, FollowParallelsOnSmoothSphere) {
  Primitive primitive = sphere(24, 48);
  const size_t before = primitive.positions.size();
  generate_tangents(primitive, 0);
  // At each pole every column of triangles is isolated, but no vertex there is shared, so none is
  // split.
  EXPECT_EQ(primitive.positions.size(), before);
  for (size_t v = 0; v < primitive.positions.size(); ++v) {
    const V3f tangent = xyz(primitive.tangents[v]);
    const V3f normal = primitive.normals[v];
    EXPECT_NEAR(tangent.length(), 1.0f, 1e-5f);
    EXPECT_NEAR(tangent.dot(normal), 0.0f, 1e-5f);
    EXPECT_EQ(primitive.tangents[v].w, 1.0f);
    if (std::abs(normal.y) > 0.99f) continue;
    // East is (cos phi, 0, -sin phi); a seam's one-sided triangles deviate by half a column, 3.75
    // degrees.
    const V3f east = V3f(normal.z, 0, -normal.x).normalized();
    EXPECT_GT(tangent.dot(east), std::cos(4.0f * kPi / 180.0f)) << "vertex " << v;
  }
}

TEST(Tangents, DuplicateVerticesGetEqualTangents) {
  // A bent strip as a triangle soup: coincident corners must agree as if they were one vertex.
  Primitive shared = plane(6);
  for (size_t v = 0; v < shared.positions.size(); ++v) {
    V3f& p = shared.positions[v];
    p.z = std::sin(3.0f * p.x) * std::cos(2.0f * p.y);
    shared.normals[v] =
        V3f(-3.0f * std::cos(3.0f * p.x) * std::cos(2.0f * p.y), 2.0f * std::sin(3.0f * p.x) * std::sin(2.0f * p.y), 1)
            .normalized();
  }
  Primitive soup;
  soup.texcoords.resize(1);
  for (const uint32_t v : shared.indices) {
    soup.indices.push_back(static_cast<uint32_t>(soup.positions.size()));
    soup.positions.push_back(shared.positions[v]);
    soup.normals.push_back(shared.normals[v]);
    soup.texcoords[0].push_back(shared.texcoords[0][v]);
  }
  generate_tangents(shared, 0);
  generate_tangents(soup, 0);
  EXPECT_EQ(shared.positions.size(), 49u);
  EXPECT_EQ(soup.positions.size(), soup.indices.size());
  for (size_t c = 0; c < soup.indices.size(); ++c)
    EXPECT_EQ(soup.tangents[soup.indices[c]], shared.tangents[shared.indices[c]]);
}

TEST(Tangents, TrianglesSharingOnlyAVertexAreNotAveraged) {
  // Two triangles share one vertex; their images are rotated against each other by 90 degrees.
  Primitive primitive;
  primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  primitive.normals.assign(5, V3f(0, 0, 1));
  primitive.texcoords = {{{0, 0}, {1, 0}, {0, -1}, {0, 1}, {1, 0}}};
  primitive.indices = {0, 1, 2, 0, 3, 4};
  generate_tangents(primitive, 0);
  ASSERT_EQ(primitive.positions.size(), 6u);
  EXPECT_EQ(primitive.indices, (std::vector<uint32_t>{0, 1, 2, 5, 3, 4}));
  expect_near(xyz(primitive.tangents[0]), {1, 0, 0});
  expect_near(xyz(primitive.tangents[5]), {0, -1, 0});
}

TEST(Tangents, DegenerateTexcoordsGiveFiniteOrthogonalTangents) {
  for (const V3f& normal : {V3f(0, 0, 1), V3f(1, 0, 0), V3f(0, 1, 0), V3f(-1, 0, 0)}) {
    Primitive primitive = plane(3);
    primitive.normals.assign(primitive.positions.size(), normal);
    primitive.texcoords[0].assign(primitive.positions.size(), V2f(0.25f, 0.25f));
    generate_tangents(primitive, 0);
    EXPECT_EQ(primitive.positions.size(), 16u);
    for (const V4f& tangent : primitive.tangents) {
      EXPECT_NEAR(xyz(tangent).length(), 1.0f, 1e-5f);
      EXPECT_NEAR(xyz(tangent).dot(normal), 0.0f, 1e-5f);
      EXPECT_EQ(std::abs(tangent.w), 1.0f);
    }
  }
}

TEST(Tangents, ZeroUvAreaTrianglesJoinNeighbors) {
  // The middle quad of three in a row has one texture coordinate per column: zero area. Its corners
  // join the groups beside it.
  Primitive primitive;
  primitive.texcoords.resize(1);
  for (const float x : {0.0f, 1.0f, 2.0f, 3.0f}) {
    for (const float y : {0.0f, 1.0f}) {
      primitive.positions.push_back({x, y, 0});
      primitive.normals.push_back({0, 0, 1});
      primitive.texcoords[0].push_back({x < 1.5f ? x : x - 1, 1 - y});
    }
  }
  primitive.indices = {0, 2, 3, 0, 3, 1, 2, 4, 5, 2, 5, 3, 4, 6, 7, 4, 7, 5};
  generate_tangents(primitive, 0);
  EXPECT_EQ(primitive.positions.size(), 8u); // no vertex is split
  for (const V4f& tangent : primitive.tangents) {
    expect_near(xyz(tangent), {1, 0, 0});
    EXPECT_EQ(tangent.w, 1.0f);
  }
}

TEST(Tangents, DegenerateTrianglesCopyVertexTangent) {
  Primitive primitive = plane(1);
  for (V2f& uv : primitive.texcoords[0]) uv = {uv.y, 1 - uv.x};
  for (const uint32_t v : {0u, 0u, 1u, 3u, 3u, 3u}) primitive.indices.push_back(v);
  generate_tangents(primitive, 0);
  EXPECT_EQ(primitive.positions.size(), 4u);
  for (const V4f& tangent : primitive.tangents) expect_near(xyz(tangent), {0, -1, 0});
}

TEST(Tangents, MissingNormalsGiveFlatFaces) {
  // Two faces of a box that share the edge x = 1.
  Primitive primitive;
  primitive.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, -1}, {1, 1, -1}};
  primitive.texcoords = {{{0, 1}, {1, 1}, {1, 0}, {0, 0}, {2, 1}, {2, 0}}};
  primitive.indices = {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2};
  MorphTarget target;
  target.positions.assign(6, V3f(0, 0, 0));
  target.positions[4] = target.positions[5] = {1, 0, 1}; // folds the second face into the plane of the first
  primitive.targets = {target};
  generate_tangents(primitive, 0);
  ASSERT_EQ(primitive.positions.size(), 12u);
  ASSERT_EQ(primitive.normals.size(), 12u);
  ASSERT_EQ(primitive.targets[0].normals.size(), 12u);
  for (size_t c = 0; c < 12; ++c) {
    EXPECT_EQ(primitive.indices[c], c);
    expect_near(primitive.normals[c], c < 6 ? V3f(0, 0, 1) : V3f(1, 0, 0));
    expect_near(xyz(primitive.tangents[c]), c < 6 ? V3f(1, 0, 0) : V3f(0, 0, -1));
    expect_near(primitive.normals[c] + primitive.targets[0].normals[c], {0, 0, 1});
  }
}

TEST(Tangents, HandleInvalidInput) {
  Primitive empty;
  generate_tangents(empty, 0);
  EXPECT_TRUE(empty.tangents.empty());
  Primitive no_texcoords = plane(2);
  no_texcoords.texcoords.clear();
  generate_tangents(no_texcoords, 0);
  EXPECT_EQ(no_texcoords.tangents.size(), 9u);
  Primitive huge = plane(2);
  for (V3f& p : huge.positions) p *= 3e38f;
  generate_tangents(huge, 0);
  Primitive tiny = plane(2);
  for (V3f& p : tiny.positions) p *= 1e-30f;
  generate_tangents(tiny, 0);
  for (const Primitive* primitive : {&no_texcoords, &huge, &tiny}) {
    for (const V4f& tangent : primitive->tangents) EXPECT_NEAR(xyz(tangent).length(), 1.0f, 1e-5f);
  }
}

TEST(Tangents, AreDeterministic) {
  Primitive a = mirrored_in_the_middle(20), b = a;
  generate_tangents(a, 0);
  generate_tangents(b, 0);
  EXPECT_EQ(a.indices, b.indices);
  EXPECT_EQ(a.tangents, b.tangents);
  EXPECT_EQ(a.positions, b.positions);
}

TEST(Tangents, CrowdedVerticesAndEdgesAreSubquadratic) {
  // 200000 triangles at one vertex, all on one edge in the same direction; testing pairs would take
  // 4e10 steps.
  constexpr uint32_t kTriangles = 200000;
  Primitive primitive;
  primitive.texcoords.resize(1);
  const auto add = [&](const V3f& p, const V2f& uv) {
    primitive.positions.push_back(p);
    primitive.normals.push_back({0, 0, 1});
    primitive.texcoords[0].push_back(uv);
  };
  add({0, 0, 0}, {0, 0});
  add({1, 0, 0}, {1, 0});
  for (uint32_t t = 0; t < kTriangles; ++t) {
    const float f = static_cast<float>(t) / kTriangles;
    add({f, 1, 0}, {0.5f * f, -1 - f});
    for (const uint32_t v : {0u, 1u, t + 2}) primitive.indices.push_back(v);
  }
  generate_tangents(primitive, 0);
  EXPECT_EQ(primitive.tangents.size(), primitive.positions.size());
  EXPECT_GT(primitive.positions.size(), kTriangles); // no two triangles are neighbors
}

} // namespace
} // namespace kindling
