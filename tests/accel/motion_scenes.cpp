// Builds the moving and deforming scenes of the motion tests.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/motion_scenes.h"

#include "accel/motion.h"
#include "accel/triangle.h"
#include "tests/accel/fuzz_scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling::accel::testing {
namespace {

constexpr uint32_t kKeyCounts[] = {2, 3, 17, 129};

bool accept_by_hash(const void*, const Ray& ray, const Hit& hit) {
  return (hit.triangle * 0x9e3779b1U ^ hit.mesh * 0x85ebca6bU ^ ray.key) >> 16 & 1U;
}

} // namespace

void TestScene::add_instance(uint32_t group, std::vector<M44f> keys) {
  instances_.push_back({group, keys.front(), static_cast<uint32_t>(motions_.size())});
  motions_.push_back(std::move(keys));
  motion_views_.emplace_back(motions_.back());
}

TestScene TestScene::posed(float time) const {
  TestScene out;
  for (const MeshGroup& group : groups_) {
    std::vector<Mesh> meshes;
    for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) {
      Mesh mesh = meshes_[m];
      const PositionsAt positions(views_[m], time);
      for (uint32_t i = 0; i < mesh.positions.size(); ++i) mesh.positions[i] = positions[i];
      for (size_t i = 0; i < mesh.indices.size() && !mesh.later.empty(); i += 3) {
        const auto is_finite_at = [&](const std::vector<V3f>& key) {
          return std::all_of(&mesh.indices[i], &mesh.indices[i] + 3,
                             [&](uint32_t k) { return accel::is_finite(key[k]); });
        };
        if (!is_finite_at(meshes_[m].positions) || !std::all_of(mesh.later.begin(), mesh.later.end(), is_finite_at))
          mesh.indices[i] = mesh.indices[i + 1];
      }
      mesh.later.clear();
      meshes.push_back(std::move(mesh));
    }
    out.add_group(std::move(meshes));
  }
  for (const Instance& instance : instances_) {
    const bool broken = instance.motion != kNoId && !accel::is_finite(motion_views_[instance.motion]);
    out.add_instance(instance.group, broken ? M44f(0.0f) : matrix_at(input(), instance, time));
  }
  out.set_filter(filter_);
  return out;
}

Mesh deformed(Mesh mesh, uint32_t keys, const std::function<V3f(const V3f&, float)>& position) {
  for (uint32_t key = 1; key < keys; ++key) {
    std::vector<V3f>& later = mesh.later.emplace_back();
    for (const V3f& p : mesh.positions)
      later.push_back(position(p, static_cast<float>(key) / static_cast<float>(keys - 1)));
  }
  return mesh;
}

Mesh deformed(Mesh mesh, uint32_t keys, Deformation how, float amount, uint32_t seed) {
  return deformed(std::move(mesh), keys, [&](const V3f& p, float time) -> V3f {
    const float s = amount * time;
    switch (how) {
    case Deformation::shift: return p + V3f(s, 0.5f * s, -0.25f * s * time);
    case Deformation::twist: {
      const float angle = s * (1.0f + p.z), c = std::cos(angle), n = std::sin(angle);
      return {c * p.x - n * p.y, n * p.x + c * p.y, p.z};
    }
    case Deformation::swell: return p * (1.0f + s * (1.0f + 0.5f * std::sin(3.0f * p.x)));
    case Deformation::explode: { // equal displacements for vertices at equal positions
      const V3f h = (p + V3f(static_cast<float>(seed))) * 91.7f;
      return p + V3f(std::sin(h.x + 2.0f * h.y), std::sin(h.y + 3.0f * h.z), std::sin(h.z + 5.0f * h.x)) * s;
    }
    case Deformation::fold: return {p.x, p.y, p.z * (1.0f - 2.0f * s)};
    }
    return p;
  });
}

std::vector<M44f> keys_of(uint32_t count, const M44f& start, const V3f& axis, float angle, float scale,
                          const V3f& displacement) {
  std::vector<M44f> keys;
  for (uint32_t key = 0; key < count; ++key) {
    const float time = static_cast<float>(key) / static_cast<float>(count - 1);
    const float size = 1.0f + (scale - 1.0f) * time;
    keys.push_back(start * placed(V3f(size), axis, angle * time, displacement * time));
  }
  return keys;
}

namespace {

struct Range {
  float low;
  float high;
};

M44f random_place(Rng& rng, Range sizes, float distance) {
  const float size = uniform(rng, sizes.low, sizes.high);
  const V3f axis = uniform_direction(rng);
  const float angle = uniform(rng, 0.0f, 6.0f);
  return placed(V3f(size), axis, angle, uniform_direction(rng) * distance);
}

std::vector<M44f> random_keys(Rng& rng, uint32_t max_count, const M44f& place, float max_angle, Range scales,
                              float max_displacement) {
  const auto count = 2 + static_cast<uint32_t>(rng() % (max_count - 1));
  const V3f axis = uniform_direction(rng);
  const float angle = uniform(rng, 0.0f, max_angle), scale = uniform(rng, scales.low, scales.high);
  const V3f direction = uniform_direction(rng);
  return keys_of(count, place, axis, angle, scale, direction * uniform(rng, 0.0f, max_displacement));
}

} // namespace

TestScene moving_instances() {
  Rng rng(601);
  TestScene scene;
  const uint32_t soup = scene.add_group({triangle_soup(rng, 60, 1.0f, 0.3f), sphere(6, 12, 0.5f, V3f(0))});
  const uint32_t globe = scene.add_group({sphere(8, 16, 1.0f, V3f(0))});
  const uint32_t empty = scene.add_group({});
  const uint32_t broken = scene.add_group({degenerate(rng, 12)});
  scene.add_instance(soup, M44f());
  scene.add_instance(globe, placed({0.5f, 1, 2}, {1, 2, 3}, 0.7f, {3, 0, 0}));
  scene.add_instance(globe, keys_of(2, M44f(), {0, 0, 1}, 0.0f, 1.0f, {40, -20, 10})); // far
  for (const uint32_t keys : kKeyCounts)
    scene.add_instance(soup, keys_of(keys, placed(V3f(0.7f), {1, 0, 0}, 1.0f, {2, 2, 0}), {1, 2, -1}, 5.0f, 1.5f,
                                     {-3, static_cast<float>(keys % 5), 1}));
  scene.add_instance(globe, keys_of(2, placed(V3f(0.5f), {0, 1, 0}, 0.3f, {0, 3, 0}), {0, 1, 0}, 0.0f, -1.0f, V3f(1)));
  scene.add_instance(globe, keys_of(2, M44f(), {0, 0, 1}, 3.14159265f, 1.0f, {-3, -3, 0})); // flat at the middle
  scene.add_instance(soup, {M44f(0.0f), placed(V3f(2), {0, 0, 1}, 0.5f, {-4, 0, 0}), M44f(0.0f)});
  scene.add_instance(soup, {M44f(), M44f(), M44f()}); // constant keys
  M44f not_finite;
  not_finite[1][1] = std::numeric_limits<float>::quiet_NaN();
  scene.add_instance(globe, {M44f(), not_finite, M44f()});
  scene.add_instance(empty, keys_of(3, M44f(), {0, 0, 1}, 1.0f, 1.0f, V3f(1)));
  scene.add_instance(broken, keys_of(3, M44f(), {0, 0, 1}, 1.0f, 1.0f, V3f(1)));
  for (int i = 0; i < 60; ++i) {
    const M44f place = random_place(rng, {0.1f, 0.5f}, 5.0f);
    scene.add_instance(i % 2 == 0 ? globe : soup, random_keys(rng, 5, place, 0.4f, {0.7f, 1.3f}, 2.0f));
  }
  return scene;
}

TestScene deforming_meshes() {
  Rng rng(607);
  TestScene scene;
  const auto sphere_at = [](const V3f& center) { return sphere(10, 20, 0.8f, center); };
  size_t i = 0;
  for (const Deformation how : kDeformations) {
    const auto x = static_cast<float>(i) * 2.5f - 5.0f;
    const uint32_t keys = kKeyCounts[i % 4];
    std::vector<Mesh> meshes = {deformed(sphere_at({x, 0, 0}), keys, how, 0.8f), sphere(6, 12, 0.3f, {x, 1.5f, 0}),
                                deformed(triangle_soup(rng, 50, 0.6f, 0.3f), 2 + static_cast<uint32_t>(i), how, 1.0f)};
    const uint32_t group = scene.add_group(std::move(meshes));
    scene.add_instance(group, M44f());
    scene.add_instance(group, placed({0.8f, -1, 1}, {1, 1, 0}, 0.4f, {0, 0, 3}));
    if (i % 2 == 0) scene.add_instance(group, keys_of(3, M44f(), {1, 0, 1}, 1.0f, 1.2f, {0, -3, -2}));
    ++i;
  }
  // Static except for one vertex; equal at all keys; not finite at some; flat at the first and
  // last.
  scene.add_instance(
      scene.add_group({deformed(sphere_at({0, -3, 0}), 5,
                                [](const V3f& p, float time) { return p.z < -0.79f ? p + V3f(0, 0, time) : p; }),
                       deformed(sphere_at({3, -3, 0}), 3, [](const V3f& p, float) { return p; }),
                       deformed(triangle_soup(rng, 60, 2.0f, 0.5f), 4,
                                [&](const V3f& p, float time) {
                                  const bool breaks = p.x > 0.0f && time > 0.5f;
                                  return breaks ? V3f(std::numeric_limits<float>::quiet_NaN()) : p;
                                }),
                       deformed(coplanar_pile(rng, 30), 3,
                                [](const V3f& p, float time) {
                                  return p + V3f(0, 0, std::sin(p.x * 5.0f) * time * (1.0f - time));
                                }),
                       deformed(degenerate(rng, 12), 3, [](const V3f& p, float time) { return p * time; })}),
      M44f());
  return scene;
}

TestScene random_motion(Rng& rng, int largest) {
  TestScene scene;
  const int groups = 1 + static_cast<int>(rng() % 3);
  const bool cut_outs = rng() % 3 == 0;
  if (cut_outs) scene.set_filter({accept_by_hash, nullptr});
  for (int g = 0; g < groups; ++g) {
    std::vector<Mesh> meshes;
    for (uint32_t m = 0; m < 1 + rng() % 3; ++m) {
      const int count = 1 + static_cast<int>(rng() % static_cast<uint32_t>(largest));
      Mesh mesh;
      switch (rng() % 5) {
      case 0: mesh = triangle_soup(rng, count, 1.0f, uniform(rng, 0.05f, 0.8f)); break;
      case 1: mesh = sphere(3 + count / 20, 6 + count / 20, 1.0f, V3f(0)); break;
      case 2: mesh = gridded_box(1 + count / 40, V3f(-0.5f), V3f(0.5f)); break;
      case 3: mesh = slivers(rng, count); break;
      default: mesh = shared_planes(rng, count); break;
      }
      const V3f farthest = uniform_direction(rng) * 2.0f;
      mesh = moved_by(std::move(mesh), farthest * uniform(rng));
      if (rng() % 3 != 0) {
        const uint32_t keys = rng() % 2 == 0 ? 2 : 2 + rng() % 9;
        const Deformation how = kDeformations[rng() % 5];
        const float amount = std::pow(10.0f, uniform(rng, -3.0f, 0.7f));
        mesh = deformed(std::move(mesh), keys, how, amount, rng());
      }
      mesh.opaque = !(cut_outs && rng() % 2 == 0);
      meshes.push_back(std::move(mesh));
    }
    const uint32_t group = scene.add_group(std::move(meshes));
    for (uint32_t i = 0; i < 1 + rng() % 3; ++i) {
      const M44f place = rng() % 3 == 0 ? M44f() : random_place(rng, {0.3f, 1.5f}, 2.0f);
      if (rng() % 2 == 0)
        scene.add_instance(group, place);
      else
        scene.add_instance(group, random_keys(rng, 7, place, 3.0f, {-0.5f, 2.0f}, 4.0f));
    }
  }
  return scene;
}

std::vector<float> some_times() {
  std::vector<float> times = {0.0f, 1.0f, 0.5f, 1.0f / 16.0f, 37.0f / 128.0f, 1e-6f, 1e-40f, 0.123f, 0.4999f, 0.77f};
  times.push_back(std::nextafter(1.0f, 0.0f));
  times.push_back(std::nextafter(0.5f, 0.0f));
  times.push_back(std::nextafter(0.5f, 1.0f));
  return times;
}

} // namespace kindling::accel::testing
