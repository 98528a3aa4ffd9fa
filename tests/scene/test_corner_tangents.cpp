// Tests of corner tangents of random meshes against a slow double-precision oracle.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/corner_tangents.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <numeric>
#include <random>

namespace kindling {
namespace {

struct RandomMesh {
  std::vector<V3f> positions;
  std::vector<V3f> normals;
  std::vector<V2f> texcoords;
  std::vector<uint32_t> indices;

  [[nodiscard]] TangentInput input() const { return {positions, normals, texcoords, indices}; }
};

// Returns a bumpy grid with holes, seams in uv and normals, mirrored patches and duplicate
// vertices.
RandomMesh random_mesh(uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  const auto chance = [&](float probability) { return uniform(random) * 0.5f + 0.5f < probability; };
  constexpr int n = 7;
  V3f grid[n + 1][n + 1];
  V3f normal[n + 1][n + 1];
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      grid[j][i] = V3f(static_cast<float>(i), static_cast<float>(j), 0.0f) +
                   V3f{uniform(random), uniform(random), uniform(random)} * 0.3f;
      normal[j][i] = V3f{uniform(random) * 0.5f, uniform(random) * 0.5f, 1.0f}.normalized();
    }
  }
  RandomMesh mesh;
  std::vector<std::pair<uint32_t, V3f>> known;
  const auto corner = [&](int i, int j, const V2f& uv, const V3f& n_at) {
    // Reuses an existing equal vertex most of the time, else adds a duplicate.
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
      if (mesh.positions[v] == grid[j][i] && mesh.normals[v] == n_at && mesh.texcoords[v] == uv && !chance(0.3f))
        return v;
    }
    mesh.positions.push_back(grid[j][i]);
    mesh.normals.push_back(n_at);
    mesh.texcoords.push_back(uv);
    return static_cast<uint32_t>(mesh.positions.size() - 1);
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      if (chance(0.1f)) continue;   // a hole
      const bool mirrored = i >= 4; // u runs backwards from the column i = 4 on: shared uv, mirrored
      const V2f shift = j >= 5 ? V2f(3.0f, 7.0f) : V2f(0.0f); // a seam in uv
      const bool tilted = j < 2;                              // a seam in normals
      const auto uv = [&](int x, int y) {
        const float u = static_cast<float>(mirrored ? 8 - x : x);
        // A mild shear makes the tangents of neighbors differ.
        return V2f(u + 0.2f * static_cast<float>(y * y % 3), -static_cast<float>(y)) + shift;
      };
      const auto at = [&](int x, int y) {
        return corner(x, y, uv(x, y), tilted ? V3f(0.0f, 0.0f, 1.0f) : normal[y][x]);
      };
      const uint32_t a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
      if (chance(0.5f)) {
        mesh.indices.insert(mesh.indices.end(), {a, b, d, a, d, c});
      } else {
        mesh.indices.insert(mesh.indices.end(), {b, d, c, c, a, b});
      }
    }
  }
  return mesh;
}

// The literal definition: tests each pair of corners for a connection, in O(n^2); tangents in
// double precision.
struct Oracle {
  explicit Oracle(const RandomMesh& m) : mesh(m), parent(m.indices.size()) {
    std::iota(parent.begin(), parent.end(), size_t{0});
    for (size_t a = 0; a < parent.size(); ++a) {
      for (size_t b = 0; b < a; ++b) {
        if (joined(a, b)) parent[root(a)] = root(b);
      }
    }
  }

  static size_t next(size_t c) { return c - c % 3 + (c + 1) % 3; }
  static size_t previous(size_t c) { return c - c % 3 + (c + 2) % 3; }
  V3d p(size_t c) const { return V3d(mesh.positions[mesh.indices[c]]); }
  V3d n(size_t c) const { return V3d(mesh.normals[mesh.indices[c]]); }
  V2f uv(size_t c) const { return mesh.texcoords[mesh.indices[c]]; }
  bool equal(size_t a, size_t b) const { return p(a) == p(b) && n(a) == n(b) && uv(a) == uv(b); }

  double uv_area(size_t c) const {
    const size_t base = c - c % 3;
    const V2f t1 = uv(base + 1) - uv(base), t2 = uv(base + 2) - uv(base);
    return static_cast<double>(t1.x) * t2.y - static_cast<double>(t1.y) * t2.x;
  }

  // True for corners at the same vertex, with the same orientation, and with an edge at that vertex
  // which the two triangles traverse in opposite directions.
  bool joined(size_t a, size_t b) const {
    if (a / 3 == b / 3 || !equal(a, b) || (uv_area(a) > 0) != (uv_area(b) > 0)) return false;
    return equal(next(a), previous(b)) || equal(previous(a), next(b));
  }

  size_t root(size_t c) {
    while (parent[c] != c) c = parent[c];
    return c;
  }

  V3d triangle_tangent(size_t c) const {
    const size_t base = c - c % 3;
    const V2f t1 = uv(base + 1) - uv(base), t2 = uv(base + 2) - uv(base);
    const V3d d1 = p(base + 1) - p(base), d2 = p(base + 2) - p(base);
    const V3d t = d1 * static_cast<double>(t2.y) - d2 * static_cast<double>(t1.y);
    return (uv_area(c) > 0 ? t : -t).normalized();
  }

  // Returns the unnormalized sum of a corner's group: its length shows how well the direction is
  // defined.
  V3d group_sum(size_t corner) {
    V3d sum(0.0);
    for (size_t c = 0; c < parent.size(); ++c) {
      if (root(c) != root(corner)) continue;
      const V3d normal = n(c);
      const auto project = [&](const V3d& v) { return (v - normal * normal.dot(v)).normalized(); };
      const double cosine = project(p(previous(c)) - p(c)).dot(project(p(next(c)) - p(c)));
      sum += project(triangle_tangent(c)) * std::acos(std::clamp(cosine, -1.0, 1.0));
    }
    return sum;
  }

  const RandomMesh& mesh;
  std::vector<size_t> parent;
};

TEST(CornerTangents, MatchTheDefinitionOnRandomMeshes) {
  size_t mirrored = 0, upright = 0;
  for (uint32_t seed = 1; seed <= 25; ++seed) {
    const RandomMesh mesh = random_mesh(seed);
    const std::vector<V4f> tangents = corner_tangents(mesh.input());
    ASSERT_EQ(tangents.size(), mesh.indices.size());
    Oracle oracle(mesh);
    for (size_t c = 0; c < tangents.size(); ++c) {
      const V3d sum = oracle.group_sum(c);
      // Single precision loses about 1e-6 per term, and acos near 0 and pi up to 5e-4; cancellation
      // magnifies both.
      const double tolerance = 1e-3 / std::max(sum.length(), 1e-2);
      const V3d found(tangents[c].x, tangents[c].y, tangents[c].z);
      EXPECT_LT((found - sum.normalized()).length(), tolerance) << "seed " << seed << ", corner " << c;
      EXPECT_EQ(tangents[c].w, oracle.uv_area(c) > 0 ? -1.0f : 1.0f) << "seed " << seed << ", corner " << c;
      ++(tangents[c].w < 0 ? mirrored : upright);
    }
  }
  EXPECT_GT(mirrored, 500u); // both orientations occur
  EXPECT_GT(upright, 500u);
}

TEST(CornerTangents, GroupMembersAreBitwiseEqual) {
  const RandomMesh mesh = random_mesh(99);
  const std::vector<V4f> tangents = corner_tangents(mesh.input());
  Oracle oracle(mesh);
  for (size_t c = 0; c < tangents.size(); ++c) EXPECT_EQ(tangents[c], tangents[oracle.root(c)]);
}

TEST(CornerTangents, AreIndependentOfVertexNumbering) {
  const RandomMesh mesh = random_mesh(7);
  RandomMesh reversed = mesh;
  const auto last = static_cast<uint32_t>(mesh.positions.size() - 1);
  std::reverse(reversed.positions.begin(), reversed.positions.end());
  std::reverse(reversed.normals.begin(), reversed.normals.end());
  std::reverse(reversed.texcoords.begin(), reversed.texcoords.end());
  for (uint32_t& index : reversed.indices) index = last - index;
  EXPECT_EQ(corner_tangents(mesh.input()), corner_tangents(reversed.input()));
}

TEST(CornerTangents, PairNonManifoldEdgesInOrder) {
  // Three triangles share the edge 0-1: the two that traverse it forwards compete for the one that
  // runs backwards, and the first wins.
  RandomMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 2, 0}};
  mesh.normals.assign(5, V3f(0, 0, 1));
  mesh.texcoords = {{0, 0}, {1, 0.25f}, {0.5f, -1}, {0, 1}, {-1, -1}};
  mesh.indices = {0, 1, 2, 0, 1, 4, 1, 0, 3};
  const std::vector<V4f> tangents = corner_tangents(mesh.input());
  EXPECT_EQ(tangents[0], tangents[7]); // vertex 0: first and third
  EXPECT_EQ(tangents[1], tangents[6]);
  EXPECT_NE(tangents[3], tangents[7]); // the second is unmatched
  EXPECT_NE(tangents[4], tangents[6]);
}

// Returns many small meshes side by side; some triangles have no uv area (they join any group, in
// order) and some are degenerate.
RandomMesh large_mesh() {
  RandomMesh all;
  for (uint32_t seed = 0; seed < 300; ++seed) {
    RandomMesh mesh = random_mesh(seed);
    for (size_t t = seed % 7; t < mesh.indices.size() / 3; t += 11) {
      const uint32_t* corner = &mesh.indices[3 * t];
      if (seed % 3 == 0) mesh.texcoords[corner[0]] = mesh.texcoords[corner[1]] = mesh.texcoords[corner[2]];
      if (seed % 3 == 1) mesh.positions[corner[0]] = mesh.positions[corner[1]];
    }
    const auto first = static_cast<uint32_t>(all.positions.size());
    for (const uint32_t index : mesh.indices) all.indices.push_back(first + index);
    for (V3f& p : mesh.positions) p.z += 10.0f * static_cast<float>(seed / 2); // meshes overlap in pairs
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
    all.texcoords.insert(all.texcoords.end(), mesh.texcoords.begin(), mesh.texcoords.end());
  }
  return all;
}

TEST(CornerTangents, AreIndependentOfThreadCount) {
  const RandomMesh mesh = large_mesh();
  const auto run = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return corner_tangents(mesh.input());
  };
  const std::vector<V4f> one = run(1);
  for (int i = 0; i < 5; ++i) {
    const std::vector<V4f> four = run(4);
    ASSERT_EQ(std::memcmp(one.data(), four.data(), one.size() * sizeof(V4f)), 0) << i;
  }
}

// A mesh has the same tangents alone and beside other meshes.
TEST(CornerTangents, AreIndependentOfOtherMeshes) {
  RandomMesh all;
  std::vector<V4f> alone;
  for (uint32_t seed = 0; seed < 200; ++seed) {
    RandomMesh mesh = random_mesh(seed);
    for (size_t t = 0; t < mesh.indices.size() / 3; t += 9) { // no uv area
      const uint32_t* corner = &mesh.indices[3 * t];
      mesh.texcoords[corner[0]] = mesh.texcoords[corner[1]] = mesh.texcoords[corner[2]];
    }
    for (V3f& p : mesh.positions) p.z += 16.0f * static_cast<float>(seed);
    const std::vector<V4f> tangents = corner_tangents(mesh.input());
    alone.insert(alone.end(), tangents.begin(), tangents.end());
    const auto first = static_cast<uint32_t>(all.positions.size());
    for (const uint32_t index : mesh.indices) all.indices.push_back(first + index);
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
    all.texcoords.insert(all.texcoords.end(), mesh.texcoords.begin(), mesh.texcoords.end());
  }
  const std::vector<V4f> together = corner_tangents(all.input());
  ASSERT_EQ(together.size(), alone.size());
  EXPECT_EQ(std::memcmp(together.data(), alone.data(), alone.size() * sizeof(V4f)), 0);
}

} // namespace
} // namespace kindling
