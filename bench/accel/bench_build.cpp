// Benchmark of build time, memory and references per triangle, by size and quality.
//
// Names are shape/accelerator/quality/triangles. Uses all threads that TBB finds; limit them with
// `taskset`.
// SPDX-License-Identifier: Apache-2.0
#include "bench/accel/bench_meshes.h"

#include <benchmark/benchmark.h>

#include <string_view>

namespace kindling::accel::bench {
namespace {

struct QualityName {
  Quality quality;
  std::string_view name;
};
constexpr QualityName kQualities[] = {
    {Quality::fast, "fast"}, {Quality::balanced, "balanced"}, {Quality::best, "best"}};

void build(benchmark::State& state, Shape shape, Kind kind, Quality quality) {
  const auto scene = make_scene(shape, static_cast<size_t>(state.range(0)));
  BuildOptions options;
  options.quality = quality;
  Statistics statistics;
  for (auto _ : state) {
    const auto accelerator = make_accelerator(kind, scene->input(), options);
    statistics = accelerator->statistics();
  }
  const auto triangles = static_cast<double>(scene->triangle_count());
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations()) * static_cast<int64_t>(scene->triangle_count()));
  state.counters["bytes_per_triangle"] = static_cast<double>(statistics.memory_bytes) / triangles;
  if (statistics.reference_count != 0)
    state.counters["references_per_triangle"] = static_cast<double>(statistics.reference_count) / triangles;
}

void register_all() {
  for (const Shape shape : kShapes)
    for (const Kind kind : {Kind::embree, Kind::kdtree, Kind::brute_force})
      for (const QualityName& quality : kQualities) {
        if (kind == Kind::brute_force && quality.quality != Quality::balanced) continue;
        const std::string name =
            shape_name(shape) + '/' + std::string(kind_name(kind)) + '/' + std::string(quality.name);
        benchmark::RegisterBenchmark(name.c_str(),
                                     [=](benchmark::State& state) { build(state, shape, kind, quality.quality); })
            ->Arg(1000)
            ->Arg(20000)
            ->Arg(400000)
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime()
            ->MinTime(0.1);
      }
}

} // namespace
} // namespace kindling::accel::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  kindling::accel::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
