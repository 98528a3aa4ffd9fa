// Benchmark of the dielectric interface, the thin film and wavelength sampling, per hit.
// SPDX-License-Identifier: Apache-2.0
#include "bench/bsdf/bsdf_timing.h"
#include "renderer/bsdf/dielectric_lobe.h"
#include "renderer/bsdf/dispersion.h"
#include "renderer/bsdf/thin_film.h"
#include "renderer/sampling/sampler.h"
#include "renderer/sampling/warp.h"

#include <vector>

namespace kindling {
namespace {

enum class Interface { smooth, rough, thin_smooth, thin_rough, film };

struct Hit {
  DielectricParameters parameters;
  V3f wo;
  V3f light;
  float u_lobe;
  V2f u;
};

std::vector<Hit> make_hits(Interface kind) {
  std::vector<Hit> hits(1024);
  for (uint32_t i = 0; i < hits.size(); ++i) {
    Hit& h = hits[i];
    const V2f a = Sampler::sample_2d(1, i, 0);
    const V2f b = Sampler::sample_2d(1, i, 1);
    const bool smooth = kind == Interface::smooth || kind == Interface::thin_smooth;
    h.parameters.alpha_x = h.parameters.alpha_y = smooth ? 0.0f : square(0.05f + 0.95f * b.y);
    h.parameters.eta = a.x < 0.5f ? 1.5f : 1.0f / 1.5f;
    h.parameters.thin_walled = kind == Interface::thin_smooth || kind == Interface::thin_rough;
    h.parameters.tint = {a.x, a.y, b.x};
    h.parameters.iridescence = kind == Interface::film ? 1.0f : 0.0f;
    h.wo = sample_cosine_hemisphere(Sampler::sample_2d(1, i, 2));
    h.light = sample_uniform_sphere(Sampler::sample_2d(1, i, 3));
    h.u_lobe = Sampler::sample_1d(1, i, 4);
    h.u = Sampler::sample_2d(1, i, 5);
  }
  return hits;
}

void set_up(benchmark::State& state, Interface kind) {
  bench::for_hits_in_turn(state, make_hits(kind),
                          [](const Hit& h) { benchmark::DoNotOptimize(DielectricLobe(h.parameters, h.wo)); });
}
void set_up_eval_and_sample(benchmark::State& state, Interface kind) {
  bench::set_up_eval_and_sample(state, make_hits(kind),
                                [](const Hit& h) { return DielectricLobe(h.parameters, h.wo); });
}

void thin_film(benchmark::State& state) {
  bench::for_hits_in_turn(state, make_hits(Interface::film), [](const Hit& h) {
    benchmark::DoNotOptimize(thin_film_fresnel(h.wo.z, 1.0f, 1.3f, h.parameters.tint, 400.0f));
  });
}

void wavelength(benchmark::State& state) {
  bench::for_hits_in_turn(state, make_hits(Interface::smooth), [](const Hit& h) {
    WavelengthSample s = sample_wavelength(h.u_lobe);
    benchmark::DoNotOptimize(dispersed_ior(1.5f, 0.3f, s.nm));
    benchmark::DoNotOptimize(s);
  });
}

BENCHMARK_CAPTURE(set_up, smooth, Interface::smooth);
BENCHMARK_CAPTURE(set_up, rough, Interface::rough);
BENCHMARK_CAPTURE(set_up, thin_smooth, Interface::thin_smooth);
BENCHMARK_CAPTURE(set_up, thin_rough, Interface::thin_rough);
BENCHMARK_CAPTURE(set_up, film, Interface::film);
BENCHMARK_CAPTURE(set_up_eval_and_sample, smooth, Interface::smooth);
BENCHMARK_CAPTURE(set_up_eval_and_sample, rough, Interface::rough);
BENCHMARK_CAPTURE(set_up_eval_and_sample, thin_smooth, Interface::thin_smooth);
BENCHMARK_CAPTURE(set_up_eval_and_sample, thin_rough, Interface::thin_rough);
BENCHMARK_CAPTURE(set_up_eval_and_sample, film, Interface::film);
BENCHMARK(thin_film);
BENCHMARK(wavelength);

} // namespace
} // namespace kindling

BENCHMARK_MAIN();
