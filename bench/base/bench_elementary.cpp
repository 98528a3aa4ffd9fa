// Benchmark of the elementary functions beside those of the C library.
//
// `single` calls a function for one number at a time, `chain` adds zero times the last result to
// the next number, so that it measures latency (and that of a product and a sum); `loop` computes
// an array, which compilers turn into vector code where they can. To compare in pairs:
// --benchmark_enable_random_interleaving=true --benchmark_repetitions=9.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/elementary.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

namespace kindling {
namespace {

constexpr size_t kCount = 1024;

// Values from low to high in no order.
std::vector<float> arguments(float low, float high, size_t stride) {
  std::vector<float> values(kCount);
  for (size_t i = 0; i < kCount; ++i)
    values[i] = low + (high - low) * (static_cast<float>(i * stride % kCount) + 0.5f) / static_cast<float>(kCount);
  return values;
}

template <typename F>
void add(const std::string& name, float low, float high, const F& f) {
  benchmark::RegisterBenchmark(("single/" + name).c_str(), [=](benchmark::State& state) {
    const std::vector<float> x = arguments(low, high, 389), y = arguments(0.1f, 3.0f, 601);
    size_t i = 0;
    for (auto _ : state) {
      benchmark::DoNotOptimize(f(x[i % kCount], y[i % kCount]));
      ++i;
    }
  });
  benchmark::RegisterBenchmark(("chain/" + name).c_str(), [=](benchmark::State& state) {
    const std::vector<float> x = arguments(low, high, 389), y = arguments(0.1f, 3.0f, 601);
    const volatile float unknown = 0.0f;
    const float zero = unknown;
    float last = 0.0f;
    size_t i = 0;
    for (auto _ : state) {
      last = f(x[i % kCount] + zero * last, y[i % kCount]);
      ++i;
    }
    benchmark::DoNotOptimize(last);
  });
  benchmark::RegisterBenchmark(("loop/" + name).c_str(), [=](benchmark::State& state) {
    const std::vector<float> x = arguments(low, high, 389), y = arguments(0.1f, 3.0f, 601);
    std::vector<float> result(kCount);
    for (auto _ : state) {
      for (size_t i = 0; i < kCount; ++i) result[i] = f(x[i], y[i]);
      benchmark::DoNotOptimize(result.data());
      benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kCount));
  });
}

#define ADD_PAIR(NAME, LOW, HIGH)                                                                                      \
  add(#NAME "/kindling", LOW, HIGH, [](float x, float) { return elementary::NAME(x); });                               \
  add(#NAME "/libm", LOW, HIGH, [](float x, float) { return std::NAME(x); })
#define ADD_PAIR_OF_TWO(NAME, LOW, HIGH)                                                                               \
  add(#NAME "/kindling", LOW, HIGH, [](float x, float y) { return elementary::NAME(x, y); });                          \
  add(#NAME "/libm", LOW, HIGH, [](float x, float y) { return std::NAME(x, y); })

void add_all() {
  ADD_PAIR(exp, -10.0f, 2.0f);
  ADD_PAIR(exp2, -10.0f, 2.0f);
  ADD_PAIR(log, 0.0f, 4.0f);
  ADD_PAIR(log2, 0.0f, 4.0f);
  ADD_PAIR(sin, -6.0f, 6.0f);
  ADD_PAIR(cos, -6.0f, 6.0f);
  ADD_PAIR(tan, -1.5f, 1.5f);
  ADD_PAIR(asin, -1.0f, 1.0f);
  ADD_PAIR(acos, -1.0f, 1.0f);
  ADD_PAIR(atan, -4.0f, 4.0f);
  ADD_PAIR_OF_TWO(pow, 0.0f, 2.0f);
  ADD_PAIR_OF_TWO(atan2, -3.0f, 3.0f);
}

} // namespace
} // namespace kindling

int main(int argc, char** argv) {
  kindling::add_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
