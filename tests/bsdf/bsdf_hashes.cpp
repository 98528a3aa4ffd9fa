// Prints hashes of BSDFs, warps and pixel filters, for compare_compilers.py.
//
// It includes the sources themselves, so that it needs no library but Imath's headers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/anisotropic_interface.cpp"
#include "renderer/bsdf/anisotropic_tables.cpp"
#include "renderer/bsdf/base_lobes.cpp"
#include "renderer/bsdf/dielectric_albedo.cpp"
#include "renderer/bsdf/dielectric_lobe.cpp"
#include "renderer/bsdf/dielectric_tables.cpp"
#include "renderer/bsdf/dispersion.cpp"
#include "renderer/bsdf/film_layer.cpp"
#include "renderer/bsdf/film_tables.cpp"
#include "renderer/bsdf/ggx_tables.cpp"
#include "renderer/bsdf/gltf_bsdf.cpp"
#include "renderer/bsdf/layered_bsdf.cpp"
#include "renderer/bsdf/sheen_lobe.cpp"
#include "renderer/bsdf/sheen_tables.cpp"
#include "renderer/bsdf/thin_film.cpp"
#include "renderer/bsdf/wavelength_tables.cpp"
#include "renderer/sampling/pixel_filter.cpp"
#include "renderer/sampling/spherical_triangle.h"
#include "tests/base/result_hash.h"

namespace {

using namespace kindling;
using test::ResultHash;

struct Draws : test::Inputs {
  // Parameters and directions are special where those of test::Inputs are.
  float pick() {
    const float usual = Inputs::pick();
    const float drawn = any(0.0f, 1.0f);
    return special ? drawn : usual;
  }
  Rgb color(float scale) { return any_3d(0.0f, 1.0f) * scale; }
  V3f direction() {
    const V3f usual = sample_uniform_hemisphere(random.next_2d());
    const V3f drawn = any_3d(-1.0f, 1.0f);
    return special && number() < 0.125f ? drawn : usual;
  }
};

BsdfParameters base_of(Draws& draws) {
  BsdfParameters p;
  p.base_color = draws.color(1.0f);
  p.metallic = draws.pick();
  p.roughness = draws.pick();
  p.ior = draws.any(1.0f, 2.5f);
  p.specular = draws.pick();
  p.specular_color = draws.color(2.0f);
  return p;
}

LayerParameters layers_of(Draws& draws, float ior, const V3f& wo) {
  LayerParameters l;
  l.clearcoat = draws.pick();
  l.clearcoat_roughness = draws.pick();
  const V3f normal = (draws.direction() + V3f(0.0f, 0.0f, 2.0f)).normalized();
  if (normal.dot(wo) > 0.01f) l.clearcoat_normal = normal;
  l.sheen_color = draws.color(1.0f);
  l.sheen_roughness = draws.any(0.0f, 1.0f);
  l.anisotropy = draws.pick();
  l.iridescence = draws.pick();
  l.iridescence_ior = draws.any(1.0f, 2.0f);
  l.iridescence_thickness_nm = draws.any(0.0f, 1000.0f);
  l.transmission = draws.pick();
  l.thin_walled = draws.number() < 0.5f;
  l.eta = draws.number() < 0.5f ? ior : 1.0f / ior;
  l.diffuse_transmission = draws.pick();
  l.diffuse_transmission_color = draws.color(1.0f);
  return l;
}

template <typename Bsdf>
void add(ResultHash& hash, const Bsdf& bsdf, Draws& draws) {
  hash.add(bsdf.albedo());
  for (int i = 0; i < 4; ++i) {
    V3f wi = draws.direction();
    if (i == 3) wi.z = -wi.z;
    const BsdfEval eval = bsdf.eval(wi);
    hash.add(eval.value);
    hash.add(eval.pdf);
    const float u_lobe = draws.number();
    const auto sample = bsdf.sample(u_lobe, draws.random.next_2d());
    if (!sample) continue;
    hash.add(sample->wi);
    hash.add(sample->weight);
    hash.add(sample->pdf);
  }
}

void print_bsdfs(bool special, int count) {
  Draws draws{{test::Random(1), special}};
  ResultHash gltf, layered;
  for (int i = 0; i < count; ++i) {
    const BsdfParameters base = base_of(draws);
    const V3f wo = draws.direction();
    const LayerParameters layers = layers_of(draws, base.ior, wo);
    add(gltf, GltfBsdf(base, wo), draws);
    add(layered, LayeredBsdf(base, layers, wo), draws);
  }
  gltf.print(special ? "GltfBsdf-special" : "GltfBsdf");
  layered.print(special ? "LayeredBsdf-special" : "LayeredBsdf");
}

void print_warps(int count) {
  Draws draws{{test::Random(2)}};
  ResultHash hash;
  for (int i = 0; i < count; ++i) {
    const V2f u = draws.random.next_2d();
    hash.add(sample_cosine_hemisphere(u));
    hash.add(sample_uniform_sphere(u));
    hash.add(sample_henyey_greenstein(u, draws.between(-0.99f, 0.99f)));
    const V3f p0 = draws.color(4.0f), p1 = draws.color(4.0f), p2 = draws.color(4.0f), from = draws.color(4.0f);
    const SphericalTriangle triangle(p0, p1, p2, from);
    hash.add(triangle.solid_angle());
    if (triangle.solid_angle() > 0.0f) hash.add(triangle.sample(u).direction);
  }
  hash.print("warps");
}

void print_filters(int count) {
  Draws draws{{test::Random(3)}};
  ResultHash hash;
  for (const FilterKind kind :
       {FilterKind::blackman_harris, FilterKind::gaussian, FilterKind::box, FilterKind::mitchell}) {
    const PixelFilter filter({.kind = kind, .width = 2.5f});
    for (int i = 0; i < count / 4; ++i) {
      const auto sample = filter.sample(draws.random.next_2d());
      hash.add(sample.offset.x);
      hash.add(sample.offset.y);
      hash.add(sample.weight);
    }
  }
  hash.print("filters");
}

} // namespace

int main(int argc, char** argv) {
  const int count = test::input_count(argc, argv, 20000);
  print_bsdfs(false, count);
  print_bsdfs(true, count);
  print_warps(10 * count);
  print_filters(10 * count);
  return 0;
}
