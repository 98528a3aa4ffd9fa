// Test meshes, scenes and ray generators for the accelerator tests.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/accel_scenes.h"

#include "tests/accel/compact_copy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kPi = 3.14159265f;

bool is_finite(const V3f& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

} // namespace

Box3f Mesh::bounds() const {
  Box3f box;
  for (const V3f& p : positions)
    if (is_finite(p)) box.extendBy(p);
  return box;
}

uint32_t TestScene::add_group(std::vector<Mesh> meshes) {
  groups_.push_back({static_cast<uint32_t>(meshes_.size()), static_cast<uint32_t>(meshes.size())});
  for (Mesh& mesh : meshes) {
    // keeps 16 bytes readable after the last position
    const auto pad = [](std::vector<V3f>& p) { p.resize(p.size() + 2), p.resize(p.size() - 2); };
    pad(mesh.positions);
    for (std::vector<V3f>& positions : mesh.later) pad(positions);
    meshes_.push_back(std::move(mesh));
    const Mesh& stored = meshes_.back();
    later_views_.emplace_back(stored.later.begin(), stored.later.end());
    views_.push_back({stored.positions, stored.indices, stored.opaque, later_views_.back()});
  }
  return static_cast<uint32_t>(groups_.size() - 1);
}

Box3f TestScene::bounds() const {
  Box3f box;
  for (const Instance& instance : instances_)
    for (uint32_t m = 0; m < groups_[instance.group].mesh_count; ++m)
      for (const V3f& p : meshes_[groups_[instance.group].first_mesh + m].positions)
        if (is_finite(p)) box.extendBy(p * instance.object_to_world);
  return box;
}

float uniform(Rng& rng, float low, float high) { return std::uniform_real_distribution<float>(low, high)(rng); }

V3f uniform_in(Rng& rng, const Box3f& box) {
  const float x = uniform(rng), y = uniform(rng), z = uniform(rng);
  return box.min + (box.max - box.min) * V3f(x, y, z);
}

V3f uniform_direction(Rng& rng) {
  const float z = uniform(rng, -1.0f, 1.0f), phi = uniform(rng, 0.0f, 2.0f * kPi);
  const float s = std::sqrt(std::max(0.0f, 1.0f - z * z));
  return {s * std::cos(phi), s * std::sin(phi), z};
}

Mesh sphere(int rings, int segments, float radius, const V3f& center) {
  Mesh mesh;
  const uint32_t north = mesh.add(center + V3f(0, 0, radius));
  for (int r = 1; r < rings; ++r)
    for (int s = 0; s < segments; ++s) {
      const float theta = kPi * static_cast<float>(r) / static_cast<float>(rings);
      const float phi = 2.0f * kPi * static_cast<float>(s) / static_cast<float>(segments);
      mesh.add(center +
               V3f(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)) * radius);
    }
  const uint32_t south = mesh.add(center - V3f(0, 0, radius));
  const auto at = [&](int r, int s) { return static_cast<uint32_t>(1 + (r - 1) * segments + s % segments); };
  for (int s = 0; s < segments; ++s) {
    mesh.indices.insert(mesh.indices.end(), {north, at(1, s), at(1, s + 1)});
    mesh.indices.insert(mesh.indices.end(), {south, at(rings - 1, s + 1), at(rings - 1, s)});
    for (int r = 1; r < rings - 1; ++r) {
      mesh.indices.insert(mesh.indices.end(), {at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      mesh.indices.insert(mesh.indices.end(), {at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  return mesh;
}

Mesh gridded_box(int cells, const V3f& low, const V3f& high) {
  Mesh mesh;
  const auto point = [&](int side, int axis, int i, int j) {
    V3f f;
    f[axis] = static_cast<float>(side);
    f[(axis + 1) % 3] = static_cast<float>(i) / static_cast<float>(cells);
    f[(axis + 2) % 3] = static_cast<float>(j) / static_cast<float>(cells);
    // All faces use one expression, so that shared vertices are equal bit for bit.
    return low + (high - low) * f;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
          const V3f a = point(side, axis, i, j), b = point(side, axis, i + 1, j), c = point(side, axis, i + 1, j + 1),
                    d = point(side, axis, i, j + 1);
          mesh.add_triangle(a, b, c);
          mesh.add_triangle(a, c, d);
        }
  return mesh;
}

Mesh triangle_soup(Rng& rng, int count, float extent, float size) {
  Mesh mesh;
  const Box3f box(V3f(-extent), V3f(extent));
  for (int i = 0; i < count; ++i) {
    const V3f p = uniform_in(rng, box);
    const V3f c = p + uniform_direction(rng) * size, b = p + uniform_direction(rng) * size;
    mesh.add_triangle(p + uniform_direction(rng) * size, b, c);
  }
  return mesh;
}

Mesh terrain(int cells, float extent, float height) {
  Mesh mesh;
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(cells),
                  v = static_cast<float>(y) / static_cast<float>(cells);
      mesh.add(
          {(u - 0.5f) * extent, height * std::sin(17.0f * u) * std::cos(23.0f * v + 5.0f * u), (v - 0.5f) * extent});
    }
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const auto a = static_cast<uint32_t>(y * (cells + 1) + x), c = a + static_cast<uint32_t>(cells) + 1;
      mesh.indices.insert(mesh.indices.end(), {a, c, a + 1, a + 1, c, c + 1});
    }
  return mesh;
}

Mesh slivers(Rng& rng, int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const V3f p = uniform_direction(rng), d = uniform_direction(rng);
    const float width = std::pow(10.0f, uniform(rng, -6.0f, -1.0f));
    const V3f aside = uniform_direction(rng) * width;
    mesh.add_triangle(p, p + d * 2.0f, p + d * uniform(rng) + aside);
  }
  return mesh;
}

Mesh coplanar_pile(Rng& rng, int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    V3f p[3];
    for (V3f& q : p) q = {uniform(rng, -1.0f, 1.0f), 0.25f, uniform(rng, -1.0f, 1.0f)};
    mesh.add_triangle(p[0], p[1], p[2]);
  }
  return mesh;
}

Mesh duplicates(int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) mesh.add_triangle({-1, -1, 0.5f}, {1, -1, 0.25f}, {0, 1, 0.125f});
  return mesh;
}

Mesh degenerate(Rng& rng, int count) {
  Mesh mesh;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < count; ++i) {
    const V3f a = uniform_direction(rng), b = uniform_direction(rng), c = uniform_direction(rng);
    switch (i % 6) {
    case 0: mesh.add_triangle(a, a, a); break;
    case 1: mesh.add_triangle(a, a, b); break;
    case 2: mesh.add_triangle(a, b, a); break;
    case 3: mesh.add_triangle(a, b, {c.x, nan, c.z}); break;
    case 4: mesh.add_triangle(a, {kInfinity, b.y, b.z}, c); break;
    default: // three collinear points whose coordinates and products are exact
      mesh.add_triangle({-1.0f, 0.5f, 0.25f}, {0.0f, 0.75f, 0.25f}, {1.0f, 1.0f, 0.25f});
      break;
    }
  }
  return mesh;
}

Mesh scaled(Mesh mesh, float factor) {
  for (V3f& p : mesh.positions) p *= factor;
  return mesh;
}

std::deque<NamedScene> adversarial_scenes() {
  Rng rng(7);
  std::deque<NamedScene> scenes;
  const auto add = [&](const char* name, Mesh mesh) { scenes.push_back({name, TestScene(std::move(mesh))}); };
  add("soup", triangle_soup(rng, 1500, 1.0f, 0.15f));
  add("large triangles", triangle_soup(rng, 300, 1.0f, 1.5f));
  add("sphere", sphere(24, 48, 1.0f, V3f(0.1f, 0.2f, 0.3f)));
  add("box", gridded_box(8, V3f(-1), V3f(1)));
  add("terrain", terrain(32, 4.0f, 0.3f));
  add("slivers", slivers(rng, 500));
  add("coplanar pile", coplanar_pile(rng, 300));
  add("duplicates", duplicates(200));
  add("degenerate", degenerate(rng, 120));
  Mesh mixed = sphere(12, 24, 1.0f, V3f(0));
  const Mesh broken = degenerate(rng, 60);
  for (uint32_t i = 0; i < broken.indices.size() / 3; ++i)
    mixed.add_triangle(broken.corner(i, 0), broken.corner(i, 1), broken.corner(i, 2));
  add("sphere and degenerate", mixed);
  add("huge", scaled(triangle_soup(rng, 800, 1.0f, 0.2f), 1e5f));
  add("tiny", scaled(triangle_soup(rng, 800, 1.0f, 0.2f), 1e-3f));
  Mesh far = sphere(16, 32, 1.0f, V3f(0));
  for (V3f& p : far.positions) p += V3f(1000.0f, -2000.0f, 500.0f);
  add("far from the origin", far);
  Mesh one;
  one.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  add("one triangle", one);
  add("none", Mesh());
  scenes.push_back({"no meshes", TestScene()});
  return scenes;
}

std::vector<Ray> random_rays(Rng& rng, const Box3f& box, int count) {
  const Box3f inner = box.isEmpty() ? Box3f(V3f(-1), V3f(1)) : box;
  const V3f size = inner.max - inner.min;
  const Box3f outer(inner.min - V3f(size.length()), inner.max + V3f(size.length()));
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    Ray ray;
    ray.origin = uniform_in(rng, i % 3 == 0 ? inner : outer);
    ray.direction = uniform_in(rng, inner) - ray.origin;
    if (ray.direction.length() == 0.0f) ray.direction = {0, 0, 1};
    if (i % 2 == 0) ray.direction.normalize();
    ray.t_max = kInfinity;
    if (i % 5 == 0) {
      ray.t_min = uniform(rng, 0.0f, 0.5f) * size.length() / ray.direction.length();
      ray.t_max = ray.t_min + uniform(rng, 0.0f, 2.0f) * size.length() / ray.direction.length();
    }
    ray.key = static_cast<uint32_t>(i);
    rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> axis_parallel_rays(Rng& rng, const TestScene& scene, int count) {
  const Box3f bounds = scene.bounds();
  const Box3f box = bounds.isEmpty() ? Box3f(V3f(-1), V3f(1)) : bounds;
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    Ray ray;
    const int axis = i % 3;
    V3f target = uniform_in(rng, box);
    if (!scene.instances().empty() && !scene.mesh(0).indices.empty() && i % 2 == 0) {
      const Mesh& mesh = scene.mesh(0);
      const V3f p = mesh.positions[rng() % mesh.positions.size()];
      if (is_finite(p)) target = p;
    }
    const float sign = (i / 3) % 2 == 0 ? 1.0f : -1.0f;
    ray.direction = V3f((i / 6) % 2 == 0 ? 0.0f : -0.0f);
    ray.direction[axis] = sign;
    ray.origin = target;
    ray.origin[axis] =
        (sign > 0 ? box.min : box.max)[axis] - sign * (i % 4 == 0 ? 0.0f : 1.0f) * (box.max - box.min).length();
    ray.t_max = kInfinity;
    rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> grazing_rays(Rng& rng, const TestScene& scene, int count) {
  std::vector<Ray> rays;
  if (scene.instances().empty() || scene.mesh(0).indices.empty()) return rays;
  const Mesh& mesh = scene.mesh(0);
  const float size = (scene.bounds().max - scene.bounds().min).length();
  while (static_cast<int>(rays.size()) < count) {
    const auto triangle = static_cast<uint32_t>(rng() % (mesh.indices.size() / 3));
    const V3f a = mesh.corner(triangle, 0), b = mesh.corner(triangle, 1), c = mesh.corner(triangle, 2);
    Ray ray;
    ray.t_max = kInfinity;
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) {
      ray.origin = V3f(size);
      ray.direction = uniform_direction(rng);
    } else if (rays.size() % 3 == 0) { // in the plane of the triangle, or close to it
      const float u = uniform(rng), v = uniform(rng) * (1.0f - u);
      const V3f inside = a + (b - a) * u + (c - a) * v;
      const V3f across = (c - a) * uniform(rng, -1.0f, 1.0f);
      ray.direction = (b - a) * uniform(rng, -1.0f, 1.0f) + across;
      const float length = ray.direction.length();
      if (length == 0.0f) ray.direction = uniform_direction(rng);
      ray.origin = inside - ray.direction * (size / std::max(length, 1e-20f));
      const float shift = std::pow(10.0f, uniform(rng, -8.0f, -3.0f));
      ray.origin += uniform_direction(rng) * size * shift;
    } else { // at a vertex, or at a point of an edge
      const V3f target = rays.size() % 3 == 1 ? a : a + (b - a) * uniform(rng);
      const float distance = uniform(rng, 0.1f, 1.0f);
      ray.origin = target + uniform_direction(rng) * size * distance;
      ray.direction = target - ray.origin;
    }
    if (ray.direction.length() > 0.0f) rays.push_back(ray);
  }
  return rays;
}

std::string kind_label(const ::testing::TestParamInfo<Kind>& info) {
  switch (info.param) {
  case Kind::brute_force: return "BruteForce";
  case Kind::embree: return "Embree";
  case Kind::kdtree: return "KdTree";
  }
  return {};
}

std::string simd_label(const ::testing::TestParamInfo<SimdTarget>& info) {
  std::string name(simd_target_name(info.param));
  std::erase(name, '.'); // "sse4.2": test names cannot contain a dot
  return name;
}

std::vector<Kernels> all_kernels() {
  std::vector<Kernels> kernels = {{Kind::brute_force, std::nullopt}};
  for (const SimdTarget simd : embree_simd_targets()) kernels.push_back({Kind::embree, simd});
  kernels.push_back({Kind::kdtree, std::nullopt, true});
  for (const SimdTarget simd : simd_targets()) kernels.push_back({Kind::kdtree, simd});
  return kernels;
}

std::string kernels_label(const ::testing::TestParamInfo<Kernels>& info) {
  const std::string kind = kind_label({info.param.kind, info.index});
  if (info.param.compact) return kind + "_compact";
  return info.param.simd ? kind + "_" + simd_label({*info.param.simd, info.index}) : kind;
}

std::unique_ptr<Accelerator> build(Kind kind, const TestScene& scene, BuildOptions options) {
  return make_accelerator(kind, scene.input(), options);
}

std::unique_ptr<Accelerator> build(const Kernels& kernels, const TestScene& scene, BuildOptions options) {
  options.simd = kernels.simd;
  auto accelerator = make_accelerator(kernels.kind, scene.input(), options);
  return kernels.compact ? with_compact_queries(std::move(accelerator)) : std::move(accelerator);
}

} // namespace kindling::accel::testing
