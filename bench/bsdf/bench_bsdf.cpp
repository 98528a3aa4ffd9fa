// Benchmark of the BSDF per hit: set-up, evaluation for a light, sampling of a bounce.
// Materials vary from hit to hit.
// SPDX-License-Identifier: Apache-2.0
#include "bench/bsdf/bsdf_timing.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/sampling/sampler.h"
#include "renderer/sampling/warp.h"

#include <vector>

namespace kindling {
namespace {

enum class Material { lambert, dielectric, metal, blend };

struct Hit {
  BsdfParameters parameters;
  V3f wo;
  V3f light;
  float u_lobe;
  V2f u;
};

std::vector<Hit> make_hits(Material material) {
  std::vector<Hit> hits(1024);
  for (uint32_t i = 0; i < hits.size(); ++i) {
    Hit& h = hits[i];
    const V2f a = Sampler::sample_2d(1, i, 0);
    const V2f b = Sampler::sample_2d(1, i, 1);
    h.parameters.base_color = {a.x, a.y, b.x};
    h.parameters.roughness = b.y;
    h.parameters.metallic = material == Material::metal ? 1.0f : material == Material::blend ? a.x : 0.0f;
    h.parameters.specular = material == Material::lambert ? 0.0f : 1.0f;
    h.wo = sample_cosine_hemisphere(Sampler::sample_2d(1, i, 2));
    h.light = sample_uniform_hemisphere(Sampler::sample_2d(1, i, 3));
    h.u_lobe = Sampler::sample_1d(1, i, 4);
    h.u = Sampler::sample_2d(1, i, 5);
  }
  return hits;
}

void set_up(benchmark::State& state, Material material) {
  bench::for_hits_in_turn(state, make_hits(material),
                          [](const Hit& h) { benchmark::DoNotOptimize(GltfBsdf(h.parameters, h.wo)); });
}
void set_up_and_eval(benchmark::State& state, Material material) {
  bench::for_hits_in_turn(state, make_hits(material),
                          [](const Hit& h) { benchmark::DoNotOptimize(GltfBsdf(h.parameters, h.wo).eval(h.light)); });
}
void set_up_eval_and_sample(benchmark::State& state, Material material) {
  bench::set_up_eval_and_sample(state, make_hits(material), [](const Hit& h) { return GltfBsdf(h.parameters, h.wo); });
}

BENCHMARK_CAPTURE(set_up, lambert, Material::lambert);
BENCHMARK_CAPTURE(set_up, dielectric, Material::dielectric);
BENCHMARK_CAPTURE(set_up, metal, Material::metal);
BENCHMARK_CAPTURE(set_up, blend, Material::blend);
BENCHMARK_CAPTURE(set_up_and_eval, lambert, Material::lambert);
BENCHMARK_CAPTURE(set_up_and_eval, dielectric, Material::dielectric);
BENCHMARK_CAPTURE(set_up_and_eval, metal, Material::metal);
BENCHMARK_CAPTURE(set_up_and_eval, blend, Material::blend);
BENCHMARK_CAPTURE(set_up_eval_and_sample, lambert, Material::lambert);
BENCHMARK_CAPTURE(set_up_eval_and_sample, dielectric, Material::dielectric);
BENCHMARK_CAPTURE(set_up_eval_and_sample, metal, Material::metal);
BENCHMARK_CAPTURE(set_up_eval_and_sample, blend, Material::blend);

} // namespace
} // namespace kindling

BENCHMARK_MAIN();
