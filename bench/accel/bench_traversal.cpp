// Benchmark of rays per second: camera, diffuse and any-hit rays, singly and in batches of 64.
//
// bench_traversal [--triangles=N] [Google Benchmark's options]; the default is 200000. Names are
// shape/accelerator/ray kind; the rate is items_per_second. Brute force is left out, since it would
// take hours. kdtree_portable and kdtree_compact are single rays through one tree, by plain loops
// and by the compact queries for GPUs.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/compact/queries.h"
#include "accel/kdtree/kdtree_accelerator.h"
#include "bench/accel/bench_meshes.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <string_view>

namespace kindling::accel::bench {
namespace {

constexpr size_t kBatch = 64;

struct RaySets {
  std::vector<Ray> camera, diffuse1, diffuse2, ambient_occlusion;
};

struct Case {
  std::shared_ptr<const BenchScene> scene;
  std::shared_ptr<const RaySets> rays;
  std::shared_ptr<const Accelerator> accelerator;
  std::shared_ptr<const kd::StructureTables> tables; // of a kd-tree's compact queries
};

RaySets make_rays(const BenchScene& scene, const Accelerator& accelerator) {
  RaySets sets;
  const auto trace = [&](const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    accelerator.intersect(rays, hits);
    return hits;
  };
  sets.camera = camera_rays(scene, 320, 184);
  sets.diffuse1 = diffuse_rays(scene, sets.camera, trace(sets.camera));
  sets.diffuse2 = diffuse_rays(scene, sets.diffuse1, trace(sets.diffuse1));
  sets.ambient_occlusion = shortened(scene, sets.diffuse1, 0.1f);
  return sets;
}

void count(benchmark::State& state, const std::vector<Ray>& rays) {
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations()) * static_cast<int64_t>(rays.size()));
}

void single_nearest(benchmark::State& state, const Case& c, const std::vector<Ray>& rays) {
  for (auto _ : state)
    for (const Ray& ray : rays) benchmark::DoNotOptimize(c.accelerator->intersect(ray));
  count(state, rays);
}

void single_any(benchmark::State& state, const Case& c, const std::vector<Ray>& rays) {
  for (auto _ : state)
    for (const Ray& ray : rays) benchmark::DoNotOptimize(c.accelerator->occluded(ray));
  count(state, rays);
}

void compact_nearest(benchmark::State& state, const Case& c, const std::vector<Ray>& rays) {
  for (auto _ : state)
    for (const Ray& ray : rays)
      benchmark::DoNotOptimize(kd::compact::intersect(c.tables->view(), ray, kd::compact::AcceptAll()));
  count(state, rays);
}

void compact_any(benchmark::State& state, const Case& c, const std::vector<Ray>& rays) {
  for (auto _ : state)
    for (const Ray& ray : rays)
      benchmark::DoNotOptimize(kd::compact::occluded(c.tables->view(), ray, kd::compact::AcceptAll()));
  count(state, rays);
}

void batch_nearest(benchmark::State& state, const Case& c, const std::vector<Ray>& rays, bool coherent) {
  std::vector<Hit> hits(rays.size());
  for (auto _ : state)
    for (size_t first = 0; first < rays.size(); first += kBatch) {
      const size_t size = std::min(kBatch, rays.size() - first);
      const std::span<const Ray> in(&rays[first], size);
      const std::span<Hit> out(&hits[first], size);
      coherent ? c.accelerator->intersect_coherent(in, out) : c.accelerator->intersect(in, out);
    }
  count(state, rays);
}

void batch_any(benchmark::State& state, const Case& c, const std::vector<Ray>& rays) {
  std::vector<uint8_t> blocked(rays.size());
  for (auto _ : state)
    for (size_t first = 0; first < rays.size(); first += kBatch) {
      const size_t size = std::min(kBatch, rays.size() - first);
      c.accelerator->occluded({&rays[first], size}, {&blocked[first], size});
    }
  count(state, rays);
}

template <class Run>
void add_benchmark(const std::string& name, const Run& run) {
  benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond)->MinTime(0.2);
}

void register_case(const std::string& name, const Case& c) {
  const auto add = [&](const char* what, auto run) { add_benchmark(name + '/' + what, run); };
  add("camera", [c](benchmark::State& s) { single_nearest(s, c, c.rays->camera); });
  add("camera_coherent", [c](benchmark::State& s) { batch_nearest(s, c, c.rays->camera, true); });
  if (c.rays->diffuse1.size() < kBatch) return;
  add("diffuse1", [c](benchmark::State& s) { single_nearest(s, c, c.rays->diffuse1); });
  add("diffuse1_batch", [c](benchmark::State& s) { batch_nearest(s, c, c.rays->diffuse1, false); });
  if (c.rays->diffuse2.size() >= kBatch) {
    add("diffuse2", [c](benchmark::State& s) { single_nearest(s, c, c.rays->diffuse2); });
    add("diffuse2_batch", [c](benchmark::State& s) { batch_nearest(s, c, c.rays->diffuse2, false); });
  }
  add("ambient_occlusion", [c](benchmark::State& s) { single_any(s, c, c.rays->ambient_occlusion); });
  add("ambient_occlusion_batch", [c](benchmark::State& s) { batch_any(s, c, c.rays->ambient_occlusion); });
}

// Registers single rays by plain loops and by the compact queries, in turn.
void register_compact(const std::string& name, Case c) {
  BuildOptions options;
  options.simd = SimdTarget::portable;
  c.accelerator = make_accelerator(Kind::kdtree, c.scene->input(), options);
  c.tables = view_of(*c.accelerator);
  const auto add = [&](const char* what, auto portable, auto compact, std::vector<Ray> RaySets::*rays) {
    add_benchmark(name + "/kdtree_portable/" + what, [=](benchmark::State& s) { portable(s, c, (*c.rays).*rays); });
    add_benchmark(name + "/kdtree_compact/" + what, [=](benchmark::State& s) { compact(s, c, (*c.rays).*rays); });
  };
  add("camera", single_nearest, compact_nearest, &RaySets::camera);
  add("diffuse1", single_nearest, compact_nearest, &RaySets::diffuse1);
  add("ambient_occlusion", single_any, compact_any, &RaySets::ambient_occlusion);
}

void register_all(size_t triangles) {
  for (const Shape shape : kShapes) {
    Case c;
    c.scene = make_scene(shape, triangles);
    for (const Kind kind : {Kind::embree, Kind::kdtree})
      for (const bool robust : {true, false}) {
        if (kind == Kind::kdtree && !robust) continue; // the kd-tree is always robust
        BuildOptions options;
        options.robust = robust;
        c.accelerator = make_accelerator(kind, c.scene->input(), options);
        if (c.rays == nullptr) c.rays = std::make_shared<RaySets>(make_rays(*c.scene, *c.accelerator));
        register_case(shape_name(shape) + '/' + std::string(kind_name(kind)) + (robust ? "" : "_not_robust"), c);
      }
    register_compact(shape_name(shape), c);
  }
}

} // namespace
} // namespace kindling::accel::bench

int main(int argc, char** argv) {
  size_t triangles = 200000;
  constexpr std::string_view kTriangles = "--triangles=";
  int remaining = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with(kTriangles)) {
      std::from_chars(argument.data() + kTriangles.size(), argument.data() + argument.size(), triangles);
    } else {
      argv[remaining++] = argv[i];
    }
  }
  argc = remaining;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  kindling::accel::bench::register_all(triangles);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
