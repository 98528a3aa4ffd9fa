// Benchmark of rays per second with motion: Embree's motion blur and the kd-tree, and at rest.
//
// bench_motion [--triangles=N] [--motion=NAME] [Google Benchmark's options]; the default is 200000
// triangles and all motions. Names are motion/accelerator/ray kind; the rate is items_per_second.
// Build time, memory and references are printed first.
//   rest       a noisy sphere at rest
//   flight     translates by its own size, as a deforming mesh with two keys
//   twist      twists by half a turn from pole to pole, with five keys
//   waves      waves run over it, with nine keys
//   explode    every vertex moves in its own direction by ten edge lengths, with two keys
//   swarm      a thousand moving instances of a small sphere
//   swarm_rest the same instances at rest
// SPDX-License-Identifier: Apache-2.0
#include "bench/accel/bench_meshes.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string_view>

namespace kindling::accel::bench {
namespace {

using Imath::M44f;
using Imath::V3f;
constexpr size_t kBatch = 64;
constexpr float kPi = 3.14159265f;

// The data of one motion.
struct MotionScene {
  std::unique_ptr<BenchScene> scene;
  std::vector<std::vector<V3f>> later;
  std::vector<std::span<const V3f>> later_views;
  std::vector<std::vector<M44f>> keys;
  std::vector<std::span<const M44f>> key_views;
  std::vector<Instance> instances{Instance{}};

  [[nodiscard]] BuildInput input() const { return {{&scene->mesh, 1}, {&scene->group, 1}, instances, key_views, {}}; }
};

MotionScene deforming(size_t triangles, uint32_t keys, const std::function<V3f(const V3f&, float)>& position) {
  MotionScene out;
  out.scene = make_scene(Shape::sphere, triangles);
  const std::span<const V3f> first = out.scene->mesh.positions;
  for (uint32_t key = 1; key < keys; ++key) {
    std::vector<V3f>& later = out.later.emplace_back();
    for (const V3f& p : first) later.push_back(position(p, static_cast<float>(key) / static_cast<float>(keys - 1)));
    later.resize(first.size() + 2, V3f(0));
  }
  for (const std::vector<V3f>& later : out.later) out.later_views.push_back(std::span(later).first(first.size()));
  out.scene->mesh.later_positions = out.later_views;
  return out;
}

// Returns a 10 x 10 x 10 grid of instances that each rotate and translate.
MotionScene swarm(size_t triangles, bool moving) {
  MotionScene out;
  out.scene = make_scene(Shape::sphere, std::max<size_t>(32, triangles / 1000));
  out.instances.clear();
  std::mt19937 rng(7);
  const auto uniform = [&] { return std::uniform_real_distribution<float>(-1.0f, 1.0f)(rng); };
  for (int i = 0; i < 1000; ++i) {
    M44f place, turn;
    place.setScale(0.07f);
    turn.setTranslation(V3f(static_cast<float>(i % 10), static_cast<float>(i / 10 % 10), static_cast<float>(i / 100)) *
                            0.2f -
                        V3f(0.9f));
    const M44f first = place * turn;
    turn.setAxisAngle(V3f{uniform(), uniform(), uniform()}.normalized(), 0.3f);
    M44f second = place * turn;
    for (int k = 0; k < 3; ++k) second[3][k] = first[3][k] + 0.1f * uniform();
    if (moving) {
      out.instances.push_back({0, first, static_cast<uint32_t>(out.keys.size())});
      out.keys.push_back({first, second});
    } else {
      out.instances.push_back({0, first, kNoId});
    }
  }
  for (const std::vector<M44f>& keys : out.keys) out.key_views.emplace_back(keys);
  return out;
}

MotionScene make_motion(std::string_view name, size_t triangles) {
  if (name == "flight")
    return deforming(triangles, 2, [](const V3f& p, float t) { return p + V3f(1.2f, 0.5f, -1.4f) * t; });
  if (name == "twist")
    return deforming(triangles, 5, [](const V3f& p, float t) {
      const float angle = 0.5f * kPi * t * p.y, c = std::cos(angle), s = std::sin(angle);
      return V3f(c * p.x - s * p.z, p.y, s * p.x + c * p.z);
    });
  if (name == "waves")
    return deforming(triangles, 9, [](const V3f& p, float t) {
      return p * (1.0f + 0.05f * std::sin(9.0f * p.x + 6.0f * t) * std::sin(8.0f * p.y) -
                  0.05f * std::sin(9.0f * p.x) * std::sin(8.0f * p.y));
    });
  if (name == "explode") {
    const float reach = 10.0f * 2.0f * kPi / std::sqrt(static_cast<float>(triangles) / 2.0f);
    return deforming(triangles, 2, [reach](const V3f& p, float t) {
      return p + V3f(std::sin(917.0f * p.x + 13.0f * p.y), std::sin(811.0f * p.y + 17.0f * p.z),
                     std::sin(733.0f * p.z + 11.0f * p.x)) *
                     (reach * t);
    });
  }
  if (name == "swarm") return swarm(triangles, true);
  if (name == "swarm_rest") return swarm(triangles, false);
  return deforming(triangles, 1, nullptr);
}
constexpr const char* kMotions[] = {"rest", "flight", "twist", "waves", "explode", "swarm_rest", "swarm"};

struct RaySets {
  std::vector<Ray> camera, diffuse, any_hit;
};

RaySets make_rays(const MotionScene& motion, const Accelerator& accelerator) {
  RaySets sets;
  sets.camera = camera_rays(*motion.scene, 320, 184);
  std::mt19937 rng(11);
  for (Ray& ray : sets.camera) ray.time = std::uniform_real_distribution<float>(0.0f, 1.0f)(rng);
  // Directions need not follow normals: rays only have to leave from all over the surface.
  std::vector<Hit> hits(sets.camera.size());
  accelerator.intersect(sets.camera, hits);
  std::vector<float> times;
  for (size_t i = 0; i < hits.size(); ++i)
    if (hits[i].is_hit()) {
      Ray ray = sets.camera[i];
      ray.origin += ray.direction * (hits[i].t * 0.999f);
      do
        ray.direction = V3f(std::normal_distribution<float>()(rng), std::normal_distribution<float>()(rng),
                            std::normal_distribution<float>()(rng));
      while (ray.direction.length() < 1e-3f);
      ray.direction.normalize();
      ray.t_min = 1e-3f;
      ray.t_max = std::numeric_limits<float>::infinity();
      sets.diffuse.push_back(ray);
    }
  sets.any_hit = shortened(*motion.scene, sets.diffuse, 0.3f);
  return sets;
}

struct Case {
  std::shared_ptr<const MotionScene> motion;
  std::shared_ptr<const RaySets> rays;
  std::shared_ptr<const Accelerator> accelerator;
};

enum class Query { single, batch, coherent, any };

void run(benchmark::State& state, const Case& c, const std::vector<Ray>& rays, Query query) {
  std::vector<Hit> hits(rays.size());
  std::vector<uint8_t> blocked(rays.size());
  for (auto _ : state) {
    if (query == Query::single) {
      for (const Ray& ray : rays) benchmark::DoNotOptimize(c.accelerator->intersect(ray));
      continue;
    }
    for (size_t first = 0; first < rays.size(); first += kBatch) {
      const size_t size = std::min(kBatch, rays.size() - first);
      const std::span<const Ray> in(&rays[first], size);
      if (query == Query::any)
        c.accelerator->occluded(in, {&blocked[first], size});
      else if (query == Query::coherent)
        c.accelerator->intersect_coherent(in, {&hits[first], size});
      else
        c.accelerator->intersect(in, {&hits[first], size});
    }
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations()) * static_cast<int64_t>(rays.size()));
}

void register_all(size_t triangles, std::string_view only) {
  for (const char* name : kMotions) {
    if (!only.empty() && only != name) continue;
    Case c;
    c.motion = std::make_shared<MotionScene>(make_motion(name, triangles));
    for (const Kind kind : {Kind::embree, Kind::kdtree}) {
      c.accelerator = make_accelerator(kind, c.motion->input());
      if (c.rays == nullptr) c.rays = std::make_shared<RaySets>(make_rays(*c.motion, *c.accelerator));
      const Statistics s = c.accelerator->statistics();
      std::printf("%-12s %-8s built in %6.3f s, %7.1f MB, %.2f references per triangle\n", name,
                  std::string(kind_name(kind)).c_str(), s.build_s, static_cast<double>(s.memory_bytes) * 1e-6,
                  static_cast<double>(s.reference_count) / static_cast<double>(c.motion->scene->triangle_count()));
      const std::string prefix = std::string(name) + '/' + std::string(kind_name(kind)) + '/';
      const auto add = [&](const char* what, auto benchmark) {
        benchmark::RegisterBenchmark((prefix + what).c_str(), benchmark)->Unit(benchmark::kMillisecond)->MinTime(0.1);
      };
      add("camera", [c](benchmark::State& s2) { run(s2, c, c.rays->camera, Query::single); });
      add("camera_coherent", [c](benchmark::State& s2) { run(s2, c, c.rays->camera, Query::coherent); });
      add("diffuse_batch", [c](benchmark::State& s2) { run(s2, c, c.rays->diffuse, Query::batch); });
      add("any_hit_batch", [c](benchmark::State& s2) { run(s2, c, c.rays->any_hit, Query::any); });
    }
  }
}

} // namespace
} // namespace kindling::accel::bench

int main(int argc, char** argv) {
  size_t triangles = 200000;
  std::string_view only;
  constexpr std::string_view kTriangles = "--triangles=", kMotion = "--motion=";
  int remaining = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with(kTriangles)) {
      std::from_chars(argument.data() + kTriangles.size(), argument.data() + argument.size(), triangles);
    } else if (argument.starts_with(kMotion)) {
      only = argument.substr(kMotion.size());
    } else {
      argv[remaining++] = argv[i];
    }
  }
  argc = remaining;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  kindling::accel::bench::register_all(triangles, only);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
