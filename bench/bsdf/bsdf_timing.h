// Loops over 1024 hits, shared by the benchmarks of BSDFs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <benchmark/benchmark.h>

#include <cstddef>
#include <vector>

namespace kindling::bench {

// Calls `work(hit)` for one hit after the other.
template <typename Hit, typename Work>
void for_hits_in_turn(benchmark::State& state, const std::vector<Hit>& hits, const Work& work) {
  size_t i = 0;
  for (auto _ : state) work(hits[i++ & 1023]);
}

// Measures the cost per hit of a path: make(hit) gives the BSDF, then one light (hit.light) and one
// bounce (hit.u_lobe, hit.u).
template <typename Hit, typename Make>
void set_up_eval_and_sample(benchmark::State& state, const std::vector<Hit>& hits, const Make& make) {
  for_hits_in_turn(state, hits, [&](const Hit& h) {
    const auto bsdf = make(h);
    benchmark::DoNotOptimize(bsdf.eval(h.light));
    benchmark::DoNotOptimize(bsdf.sample(h.u_lobe, h.u));
  });
}

} // namespace kindling::bench
