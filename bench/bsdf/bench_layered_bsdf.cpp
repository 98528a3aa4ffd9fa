// Benchmark of the layered BSDF by layer, beside the plain model: one light and one bounce per hit.
// SPDX-License-Identifier: Apache-2.0
#include "bench/bsdf/bsdf_timing.h"
#include "renderer/bsdf/layered_bsdf.h"
#include "renderer/sampling/sampler.h"
#include "renderer/sampling/warp.h"

#include <vector>

namespace kindling {
namespace {

enum class Layer {
  none,
  clearcoat,
  sheen,
  anisotropy,
  film_on_metal,
  film_on_dielectric,
  leaf,
  rough_glass,
  anisotropic_glass,
  glass,
  thin_wall,
  all
};

struct Hit {
  BsdfParameters parameters;
  LayerParameters layers;
  V3f wo;
  V3f light;
  float u_lobe;
  V2f u;
};

void set_layers(Layer layer, const V2f& u, Hit& h) {
  LayerParameters& l = h.layers;
  BsdfParameters& p = h.parameters;
  const bool all = layer == Layer::all;
  if (layer == Layer::clearcoat || all) {
    l.clearcoat = u.x;
    l.clearcoat_roughness = u.y;
  }
  if (layer == Layer::sheen || all) {
    l.sheen_color = {u.x, u.y, 0.5f};
    l.sheen_roughness = u.y;
  }
  if (layer == Layer::anisotropy || layer == Layer::anisotropic_glass || all) l.anisotropy = u.x;
  if (layer == Layer::film_on_metal || layer == Layer::film_on_dielectric || all) {
    l.iridescence = 1.0f;
    l.iridescence_thickness_nm = 800.0f * u.x;
  }
  if (layer == Layer::leaf || all) l.diffuse_transmission = u.y;
  if (layer == Layer::rough_glass || layer == Layer::anisotropic_glass || layer == Layer::glass ||
      layer == Layer::thin_wall || all) {
    l.transmission = all ? u.x : 1.0f;
    l.thin_walled = layer == Layer::thin_wall;
    if (layer == Layer::glass) p.roughness = 0.0f;
  }
  p.metallic = layer == Layer::film_on_metal ? 1.0f : all ? 0.5f * u.y : 0.0f;
}

std::vector<Hit> make_hits(Layer layer) {
  std::vector<Hit> hits(1024);
  for (uint32_t i = 0; i < hits.size(); ++i) {
    Hit& h = hits[i];
    const V2f a = Sampler::sample_2d(1, i, 0);
    const V2f b = Sampler::sample_2d(1, i, 1);
    h.parameters.base_color = {a.x, a.y, b.x};
    h.parameters.roughness = b.y;
    h.wo = sample_cosine_hemisphere(Sampler::sample_2d(1, i, 2));
    h.light = sample_uniform_hemisphere(Sampler::sample_2d(1, i, 3));
    h.u_lobe = Sampler::sample_1d(1, i, 4);
    h.u = Sampler::sample_2d(1, i, 5);
    set_layers(layer, Sampler::sample_2d(1, i, 6), h);
  }
  return hits;
}

void plain(benchmark::State& state) {
  bench::set_up_eval_and_sample(state, make_hits(Layer::none),
                                [](const Hit& h) { return GltfBsdf(h.parameters, h.wo); });
}
void layered(benchmark::State& state, Layer layer) {
  bench::set_up_eval_and_sample(state, make_hits(layer),
                                [](const Hit& h) { return LayeredBsdf(h.parameters, h.layers, h.wo); });
}

BENCHMARK(plain);
BENCHMARK_CAPTURE(layered, none, Layer::none);
BENCHMARK_CAPTURE(layered, clearcoat, Layer::clearcoat);
BENCHMARK_CAPTURE(layered, sheen, Layer::sheen);
BENCHMARK_CAPTURE(layered, anisotropy, Layer::anisotropy);
BENCHMARK_CAPTURE(layered, film_on_metal, Layer::film_on_metal);
BENCHMARK_CAPTURE(layered, film_on_dielectric, Layer::film_on_dielectric);
BENCHMARK_CAPTURE(layered, leaf, Layer::leaf);
BENCHMARK_CAPTURE(layered, rough_glass, Layer::rough_glass);
BENCHMARK_CAPTURE(layered, anisotropic_glass, Layer::anisotropic_glass);
BENCHMARK_CAPTURE(layered, glass, Layer::glass);
BENCHMARK_CAPTURE(layered, thin_wall, Layer::thin_wall);
BENCHMARK_CAPTURE(layered, all, Layer::all);

} // namespace
} // namespace kindling

BENCHMARK_MAIN();
