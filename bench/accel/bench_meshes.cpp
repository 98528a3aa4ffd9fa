// Generates meshes and rays for the accelerator benchmarks.
// SPDX-License-Identifier: Apache-2.0
#include "bench/accel/bench_meshes.h"

#include <ImathBox.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace kindling::accel::bench {
namespace {

using Imath::V3f;
using Rng = std::mt19937;
constexpr float kPi = 3.14159265f;

float uniform(Rng& rng) { return std::uniform_real_distribution<float>(0.0f, 1.0f)(rng); }

V3f uniform_direction(Rng& rng) {
  const float z = 2.0f * uniform(rng) - 1.0f, phi = 2.0f * kPi * uniform(rng);
  const float s = std::sqrt(std::max(0.0f, 1.0f - z * z));
  return {s * std::cos(phi), s * std::sin(phi), z};
}

// Adds a surface over [0, 1]^2 with columns x rows quads.
void add_patch(BenchScene& scene, int columns, int rows, const std::function<V3f(float, float)>& point) {
  const auto base = static_cast<uint32_t>(scene.positions.size());
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x <= columns; ++x)
      scene.positions.push_back(
          point(static_cast<float>(x) / static_cast<float>(columns), static_cast<float>(y) / static_cast<float>(rows)));
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const auto a = base + static_cast<uint32_t>(y * (columns + 1) + x), c = a + static_cast<uint32_t>(columns) + 1;
      scene.indices.insert(scene.indices.end(), {a, c, a + 1, a + 1, c, c + 1});
    }
}

void add_sphere(BenchScene& scene, size_t triangles) {
  const int n = std::max(4, static_cast<int>(std::sqrt(static_cast<double>(triangles) / 2.0)));
  add_patch(scene, n, n, [](float u, float v) {
    const float theta = kPi * v, phi = 2.0f * kPi * u;
    const float r =
        1.0f + 0.02f * std::sin(37.0f * phi) * std::sin(41.0f * theta) + 0.1f * std::sin(5.0f * phi) * std::sin(theta);
    return V3f(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)) * r;
  });
  scene.eye = {1.6f, 0.9f, 2.2f};
  scene.target = V3f(0.0f);
}

void add_hall(BenchScene& scene, size_t triangles) {
  // Half of the triangles are in the floor, a few in the walls, the rest in 24 columns.
  const int floor = std::max(4, static_cast<int>(std::sqrt(static_cast<double>(triangles) / 4.0)));
  const auto bump = [](float u, float v) { return 0.05f * std::sin(61.0f * u) * std::cos(53.0f * v + 7.0f * u); };
  add_patch(scene, floor, floor, [&](float u, float v) { return V3f(20.0f * u, bump(u, v), 10.0f * v); });
  add_patch(scene, 8, 8, [](float u, float v) { return V3f(20.0f * u, 4.0f, 10.0f * v); });
  for (const float side : {0.0f, 1.0f}) {
    add_patch(scene, 8, 4, [&](float u, float v) { return V3f(20.0f * u, 4.1f * v - 0.1f, 10.0f * side); });
    add_patch(scene, 4, 8, [&](float u, float v) { return V3f(20.0f * side, 4.1f * u - 0.1f, 10.0f * v); });
  }
  const int column = std::max(3, static_cast<int>(std::sqrt(static_cast<double>(triangles) / 2.0 / 24.0 / 2.0)));
  for (int i = 0; i < 24; ++i) {
    const V3f foot(1.5f + 1.55f * static_cast<float>(i / 2), 0.0f, i % 2 == 0 ? 2.5f : 7.5f);
    add_patch(scene, column, column, [&](float u, float v) {
      const float r = 0.3f + 0.04f * std::sin(24.0f * kPi * u) + 0.05f * std::cos(9.0f * v);
      return foot + V3f(r * std::cos(2.0f * kPi * u), 4.0f * v, r * std::sin(2.0f * kPi * u));
    });
  }
  scene.eye = {0.7f, 1.7f, 5.2f};
  scene.target = {15.0f, 1.0f, 4.4f};
}

void add_soup(BenchScene& scene, size_t triangles) {
  Rng rng(1);
  for (size_t i = 0; i < triangles; ++i) {
    const V3f center{uniform(rng), uniform(rng), uniform(rng)};
    const float size = std::pow(10.0f, -1.0f - uniform(rng)) * std::cbrt(1000.0f / static_cast<float>(triangles));
    for (int k = 0; k < 3; ++k) {
      scene.indices.push_back(static_cast<uint32_t>(scene.positions.size()));
      scene.positions.push_back(center + uniform_direction(rng) * size);
    }
  }
  scene.eye = {1.7f, 1.2f, 1.9f};
  scene.target = V3f(0.5f);
}

} // namespace

std::string shape_name(Shape shape) {
  switch (shape) {
  case Shape::hall: return "hall";
  case Shape::sphere: return "sphere";
  case Shape::soup: return "soup";
  }
  return {};
}

std::unique_ptr<BenchScene> make_scene(Shape shape, size_t triangles) {
  auto scene = std::make_unique<BenchScene>();
  switch (shape) {
  case Shape::hall: add_hall(*scene, triangles); break;
  case Shape::sphere: add_sphere(*scene, triangles); break;
  case Shape::soup: add_soup(*scene, triangles); break;
  }
  scene->vertex_count = scene->positions.size();
  scene->positions.resize(scene->vertex_count + 2, V3f(0.0f));
  scene->mesh = {std::span<const V3f>(scene->positions).first(scene->vertex_count), scene->indices, true};
  return scene;
}

std::vector<Ray> camera_rays(const BenchScene& scene, int width, int height) {
  Rng rng(2);
  const V3f forward = (scene.target - scene.eye).normalized();
  const V3f right = forward.cross(V3f(0, 1, 0)).normalized(), up = right.cross(forward);
  std::vector<Ray> rays;
  for (int by = 0; by < height; by += 8)
    for (int bx = 0; bx < width; bx += 8)
      for (int y = by; y < by + 8; ++y)
        for (int x = bx; x < bx + 8; ++x) {
          const float px = (2.0f * (static_cast<float>(x) + uniform(rng)) / static_cast<float>(width) - 1.0f) *
                           static_cast<float>(width) / static_cast<float>(height);
          const float py = 1.0f - 2.0f * (static_cast<float>(y) + uniform(rng)) / static_cast<float>(height);
          Ray ray;
          ray.origin = scene.eye;
          ray.direction = (forward + (right * px + up * py) * 0.5f).normalized();
          ray.t_max = std::numeric_limits<float>::infinity();
          rays.push_back(ray);
        }
  return rays;
}

std::vector<Ray> diffuse_rays(const BenchScene& scene, const std::vector<Ray>& rays, const std::vector<Hit>& hits) {
  Rng rng(3);
  std::vector<Ray> out;
  for (size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i].is_hit()) continue;
    const uint32_t* corner = &scene.indices[3 * static_cast<size_t>(hits[i].triangle)];
    const V3f a = scene.positions[corner[0]];
    V3f normal = (scene.positions[corner[1]] - a).cross(scene.positions[corner[2]] - a).normalized();
    if (normal.dot(rays[i].direction) > 0.0f) normal = -normal;
    Ray ray;
    ray.origin = rays[i].origin + rays[i].direction * hits[i].t + normal * 1e-4f;
    ray.direction = (normal + uniform_direction(rng) * 0.999f).normalized();
    ray.t_max = std::numeric_limits<float>::infinity();
    out.push_back(ray);
  }
  return out;
}

std::vector<Ray> shortened(const BenchScene& scene, std::vector<Ray> rays, float fraction) {
  Imath::Box3f box;
  for (size_t i = 0; i < scene.vertex_count; ++i) box.extendBy(scene.positions[i]);
  for (Ray& ray : rays) ray.t_max = fraction * (box.max - box.min).length();
  return rays;
}

} // namespace kindling::accel::bench
