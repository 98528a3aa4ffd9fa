// Benchmark of single draws: sampler, warps, pixel filter and tabulated distributions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/alias_table.h"
#include "renderer/sampling/distribution_2d.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/sampling/sampler.h"
#include "renderer/sampling/spherical_triangle.h"
#include "renderer/sampling/warp.h"

#include <benchmark/benchmark.h>

#include <vector>

namespace kindling {
namespace {

void sample_1d(benchmark::State& state) {
  uint32_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Sampler::sample_1d(i * 0x9e3779b9U, i, i & 31U));
    ++i;
  }
}
BENCHMARK(sample_1d);

void sample_2d(benchmark::State& state) {
  uint32_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(Sampler::sample_2d(i * 0x9e3779b9U, i, i & 31U));
    ++i;
  }
}
BENCHMARK(sample_2d);

void pixel_key(benchmark::State& state) {
  int i = 0;
  const Sampler sampler(7);
  for (auto _ : state) {
    benchmark::DoNotOptimize(sampler.pixel_key({i & 1023, i >> 10}));
    ++i;
  }
}
BENCHMARK(pixel_key);

// The benchmarks below use prepared points, which excludes the sampler's time.
std::vector<V2f> make_points() {
  std::vector<V2f> points(4096);
  for (uint32_t i = 0; i < points.size(); ++i) points[i] = Sampler::sample_2d(3, i, 0);
  return points;
}

template <typename Warp>
void warp(benchmark::State& state, const Warp& f) {
  const std::vector<V2f> points = make_points();
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(f(points[i++ & 4095]));
}

void cosine_hemisphere(benchmark::State& state) {
  warp(state, [](const V2f& u) { return sample_cosine_hemisphere(u); });
}
BENCHMARK(cosine_hemisphere);

void spherical_triangle(benchmark::State& state) {
  warp(state, [](const V2f& u) {
    const SphericalTriangle triangle({1, 0, 3}, {-2, 1, 2}, {u.x, 2, 4}, {0, 0, u.y});
    return triangle.sample(u).direction * triangle.pdf();
  });
}
BENCHMARK(spherical_triangle);

void pixel_filter(benchmark::State& state) {
  const PixelFilter filter;
  warp(state, [&](const V2f& u) { return filter.sample(u); });
}
BENCHMARK(pixel_filter);

void environment_2k(benchmark::State& state) {
  std::vector<float> weights(2048 * 1024);
  for (uint32_t i = 0; i < weights.size(); ++i) weights[i] = 0.01f + square(Sampler::sample_1d(5, i, 0));
  weights[300 * 2048 + 700] = 1e6f;
  const Distribution2D distribution(weights, 2048, 1024);
  warp(state, [&](const V2f& u) { return distribution.sample(u); });
}
BENCHMARK(environment_2k);

void environment_2k_build(benchmark::State& state) {
  const std::vector<float> weights(2048 * 1024, 1.0f);
  for (auto _ : state) benchmark::DoNotOptimize(Distribution2D(weights, 2048, 1024));
}
BENCHMARK(environment_2k_build)->Unit(benchmark::kMillisecond);

void alias_table_80k(benchmark::State& state) {
  std::vector<float> weights(80000);
  for (uint32_t i = 0; i < weights.size(); ++i) weights[i] = Sampler::sample_1d(5, i, 0);
  const AliasTable table(weights);
  warp(state, [&](const V2f& u) { return table.sample(u); });
}
BENCHMARK(alias_table_80k);

} // namespace
} // namespace kindling

BENCHMARK_MAIN();
