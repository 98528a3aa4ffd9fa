// Benchmark of light sampling, hit densities and tree builds by the number of emitters.
// It also measures the environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/image.h"
#include "renderer/light/light_set.h"
#include "renderer/sampling/sampler.h"
#include "renderer/sampling/warp.h"

#include <benchmark/benchmark.h>

#include <cstring>
#include <map>
#include <vector>

namespace kindling {
namespace {

// Bulbs of 20 triangles at random positions in a hall that grows with their number, so that the
// neighborhood is constant.
LightSetInput bulbs(size_t triangles) {
  const float g = 0.5f * (1.0f + std::sqrt(5.0f)); // icosahedron
  const V3f vertices[12] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                            {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  const uint8_t faces[20][3] = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  LightSetInput input;
  for (uint32_t i = 0; i < 8; ++i) {
    const V2f u = Sampler::sample_2d(7, i, 0);
    input.emissions.push_back({Rgb(1.0f + 20.0f * u.x, 10.0f, 1.0f + 20.0f * u.y), nullptr, true});
  }
  const float side = 4.0f * std::sqrt(static_cast<float>(triangles) / 20.0f);
  input.scene_radius_m = side;
  for (uint32_t bulb = 0; input.triangles.size() < triangles; ++bulb) {
    const V2f u = Sampler::sample_2d(3, bulb, 0);
    const V3f center(side * (u.x - 0.5f), 1.0f + 3.0f * Sampler::sample_1d(3, bulb, 1), side * (u.y - 0.5f));
    const float size = 0.02f + 0.1f * Sampler::sample_1d(3, bulb, 2);
    for (uint32_t i = 0; i < 20 && input.triangles.size() < triangles; ++i) {
      const auto corner = [&](uint32_t k) { return center + vertices[faces[i][k]] * size; };
      input.triangles.push_back({corner(0), corner(1), corner(2), bulb & 7U});
    }
  }
  return input;
}

struct Query {
  V3f point;
  V3f normal;
  float u_light;
  V2f u;
  uint32_t triangle = 0; // sampled triangle, as if a bounce had hit it
  V3f wi{0.0f, 1.0f, 0.0f};
  float distance = 1.0f;
};

struct Prepared {
  LightSetInput input;
  std::unique_ptr<LightSet> lights;
  std::vector<Query> queries;
};

// Points on the floor, too many for the first caches. Built once for each size.
const Prepared& prepared(size_t triangles) {
  static std::map<size_t, Prepared> all;
  Prepared& p = all[triangles];
  if (p.lights) return p;
  p.input = bulbs(triangles);
  p.lights = std::make_unique<LightSet>(p.input);
  p.queries.resize(16384);
  const float side = p.input.scene_radius_m;
  for (uint32_t i = 0; i < p.queries.size(); ++i) {
    Query& q = p.queries[i];
    const V2f u = Sampler::sample_2d(11, i, 0);
    q.point = {side * (u.x - 0.5f), 0.0f, side * (u.y - 0.5f)};
    q.normal = sample_cosine_hemisphere(Sampler::sample_2d(11, i, 1));
    std::swap(q.normal.y, q.normal.z);
    q.u_light = Sampler::sample_1d(11, i, 2);
    q.u = Sampler::sample_2d(11, i, 3);
    const auto centroid = [&](uint32_t t) {
      const EmissiveTriangle& e = p.input.triangles[t];
      return (e.p0 + e.p1 + e.p2) * (1.0f / 3.0f);
    };
    // The nearest of a few approximates a ray's hit.
    float nearest = kInfinity;
    for (uint32_t k = 0; k < 8; ++k) {
      const auto t = static_cast<uint32_t>(Sampler::sample_1d(13 + k, i, 4) * static_cast<float>(triangles));
      const float distance = (centroid(t) - q.point).length();
      if (distance > nearest) continue;
      nearest = distance;
      q.triangle = t;
    }
    q.distance = nearest;
    q.wi = (centroid(q.triangle) - q.point) * (1.0f / nearest);
  }
  return p;
}

void sample_light(benchmark::State& state) {
  const Prepared& p = prepared(static_cast<size_t>(state.range(0)));
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = p.queries[i++ & 16383];
    benchmark::DoNotOptimize(p.lights->sample(q.point, q.normal, q.u_light, q.u));
  }
  state.counters["bytes/emitter"] =
      static_cast<double>(p.lights->memory_bytes()) / static_cast<double>(p.input.triangles.size());
}

void density_of_hit(benchmark::State& state) {
  const Prepared& p = prepared(static_cast<size_t>(state.range(0)));
  size_t i = 0;
  for (auto _ : state) {
    const Query& q = p.queries[i++ & 16383];
    benchmark::DoNotOptimize(p.lights->pdf_triangle(q.triangle, q.point, q.normal, q.wi, q.distance));
  }
}

void build(benchmark::State& state) {
  const Prepared& p = prepared(static_cast<size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(LightSet(p.input).light_count);
}

BENCHMARK(sample_light)->Arg(2)->Arg(10)->Arg(1000)->Arg(80'000)->Arg(1'000'000);
BENCHMARK(density_of_hit)->Arg(2)->Arg(10)->Arg(1000)->Arg(80'000)->Arg(1'000'000);
BENCHMARK(build)->Arg(1000)->Arg(80'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

// A sky of noise with a sun.
const Environment& sky() {
  static const Environment environment = [] {
    auto image = std::make_shared<Image>();
    image->width = 1024;
    image->height = 512;
    image->channels = 3;
    image->type = PixelType::f32;
    image->pixels.resize(image->byte_count());
    for (uint32_t i = 0; i < 1024 * 512; ++i) {
      const float level = i == 140 * 1024 + 300 ? 2e4f : 0.05f + Sampler::sample_1d(17, i, 0);
      const Rgb c(level, level, 1.2f * level);
      std::memcpy(image->pixels.data() + size_t{i} * 12, c.getValue(), 12);
    }
    return Environment(image, 0.3f, 1.0f);
  }();
  return environment;
}

void environment_sample(benchmark::State& state) {
  const Environment& environment = sky();
  uint32_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(environment.sample(Sampler::sample_2d(19, i++, 0)));
}
BENCHMARK(environment_sample);

void environment_eval(benchmark::State& state) {
  const Environment& environment = sky();
  std::vector<V3f> directions(16384);
  for (uint32_t i = 0; i < directions.size(); ++i) directions[i] = sample_uniform_sphere(Sampler::sample_2d(23, i, 0));
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(environment.eval(directions[i++ & 16383]));
}
BENCHMARK(environment_eval);

} // namespace
} // namespace kindling

BENCHMARK_MAIN();
