// Benchmark of one mesh size as CSV: build time, memory, and rays per second.
// ../accel_scaling.py runs it for many sizes, and fits and plots the results.
//
// bench_scaling SHAPE TRIANGLES [REPEAT]: SHAPE is hall, sphere or soup; REPEAT is the number of
// interleaved rounds of traversal [3]. Builds repeat as often, but not if one takes more than 20 s.
// Times on one thread are CPU time, of the process for builds, of the thread for traversal;
// build_all_s is wall time on all threads that TBB finds.
// SPDX-License-Identifier: Apache-2.0
#include "bench/accel/bench_meshes.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string_view>

namespace kindling::accel::bench {
namespace {

constexpr size_t kBatch = 256;
constexpr size_t kGroup = 64; // camera rays per block
constexpr double kLongBuild_s = 20.0;

double now_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

struct Contestant {
  const char* name;
  Kind kind;
  Quality quality;
  bool robust;
  std::unique_ptr<Accelerator> built{};
  std::vector<double> build_1_s{}, build_all_s{};
  std::vector<std::vector<double>> times_s{}; // indexed by measurement
};

// Rays to trace, and a call for `chunk` of them at a time.
struct Measurement {
  const char* name;
  const std::vector<Ray>* rays;
  std::function<void(const Accelerator&, std::span<const Ray>, std::span<Hit>, std::span<uint8_t>)> call;
  size_t chunk;
};

void build(Contestant& c, const BuildInput& input, int threads) {
  BuildOptions options;
  options.quality = c.quality;
  options.robust = c.robust;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  tbb::task_arena arena(threads);
  c.built.reset();
  const clockid_t clock = threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC;
  const double start = now_s(clock);
  c.built = arena.execute([&] { return make_accelerator(c.kind, input, options); });
  (threads == 1 ? c.build_1_s : c.build_all_s).push_back(now_s(clock) - start);
}

int run(Shape shape, size_t triangles, int repeat) {
  const auto scene = make_scene(shape, triangles);
  std::vector<Contestant> contestants;
  contestants.push_back({"kdtree", Kind::kdtree, Quality::balanced, true});
  contestants.push_back({"embree medium robust", Kind::embree, Quality::balanced, true});
  contestants.push_back({"embree medium", Kind::embree, Quality::balanced, false});
  contestants.push_back({"embree high", Kind::embree, Quality::best, false});
  const int threads = tbb::info::default_concurrency();
  for (int round = 0; round < repeat; ++round)
    for (Contestant& c : contestants) {
      if (round > 0 && c.build_1_s.front() > kLongBuild_s) continue;
      build(c, scene->input(), threads);
      build(c, scene->input(), 1);
    }

  const auto trace = [&](const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    contestants[1].built->intersect(rays, hits);
    return hits;
  };
  const std::vector<Ray> camera = camera_rays(*scene, 320, 184);
  const std::vector<Ray> bounce1 = diffuse_rays(*scene, camera, trace(camera));
  const std::vector<Ray> bounce2 = diffuse_rays(*scene, bounce1, trace(bounce1));
  const std::vector<Ray> ambient = shortened(*scene, bounce1, 0.1f);
  const auto single = [](const Accelerator& a, auto rays, auto hits, auto) { hits[0] = a.intersect(rays[0]); };
  const auto batch = [](const Accelerator& a, auto rays, auto hits, auto) { a.intersect(rays, hits); };
  const auto coherent = [](const Accelerator& a, auto rays, auto hits, auto) { a.intersect_coherent(rays, hits); };
  const auto any = [](const Accelerator& a, auto rays, auto, auto blocked) { a.occluded(rays, blocked); };
  const std::vector<Measurement> measurements{
      {"camera_single", &camera, single, 1},   {"camera_coherent", &camera, coherent, kGroup},
      {"bounce1_single", &bounce1, single, 1}, {"bounce1_batch", &bounce1, batch, kBatch},
      {"bounce2_single", &bounce2, single, 1}, {"bounce2_batch", &bounce2, batch, kBatch},
      {"ambient_batch", &ambient, any, kBatch}};

  std::vector<Hit> hits(camera.size());
  std::vector<uint8_t> blocked(camera.size());
  for (Contestant& c : contestants) c.times_s.resize(measurements.size());
  for (int round = -1; round < repeat; ++round) // the first round warms up
    for (size_t m = 0; m < measurements.size(); ++m)
      for (Contestant& c : contestants) {
        const std::span<const Ray> rays(*measurements[m].rays);
        const double start = now_s(CLOCK_THREAD_CPUTIME_ID);
        for (size_t first = 0; first < rays.size(); first += measurements[m].chunk) {
          const size_t count = std::min(measurements[m].chunk, rays.size() - first);
          measurements[m].call(*c.built, rays.subspan(first, count), std::span(hits).subspan(first, count),
                               std::span(blocked).subspan(first, count));
        }
        if (round >= 0) c.times_s[m].push_back(now_s(CLOCK_THREAD_CPUTIME_ID) - start);
      }

  std::printf("shape,triangles,accelerator,build_1_thread_s,build_threads,build_all_s,memory_bytes");
  for (const Measurement& m : measurements) std::printf(",%s_mrays_s", m.name);
  std::printf("\n");
  for (const Contestant& c : contestants) {
    std::printf("%s,%zu,%s,%.6g,%d,%.6g,%zu", shape_name(shape).c_str(), scene->triangle_count(), c.name,
                median(c.build_1_s), threads, median(c.build_all_s), c.built->statistics().memory_bytes);
    for (size_t m = 0; m < measurements.size(); ++m) {
      const double time_s = median(c.times_s[m]);
      const size_t rays = measurements[m].rays->size();
      if (rays < kBatch || time_s <= 0.0)
        std::printf(","); // too few rays reach this bounce
      else
        std::printf(",%.6g", 1e-6 * static_cast<double>(rays) / time_s);
    }
    std::printf("\n");
  }
  return 0;
}

template <typename T>
bool parse(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

} // namespace
} // namespace kindling::accel::bench

int main(int argc, char** argv) {
  using namespace kindling::accel::bench;
  size_t triangles = 0;
  int repeat = 3;
  const Shape* shape = nullptr;
  if (argc == 3 || argc == 4)
    for (const Shape& candidate : kShapes)
      if (shape_name(candidate) == argv[1]) shape = &candidate;
  if (shape == nullptr || !parse(argv[2], triangles) || triangles == 0 || (argc == 4 && !parse(argv[3], repeat)) ||
      repeat < 1) {
    std::fprintf(stderr, "usage: bench_scaling hall|sphere|soup TRIANGLES [REPEAT]\n");
    return 2;
  }
  return run(*shape, triangles, repeat);
}
