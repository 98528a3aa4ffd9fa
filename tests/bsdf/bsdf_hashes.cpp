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
#include "tests/sampling/random.h"

#include <bit>
#include <cinttypes>
#include <cstdio>

namespace {

using namespace kindling;

class Hash {
 public:
  void add(float x) { // the sign and the bits of NaN are the processor's affair
    const uint32_t bits = x == x ? std::bit_cast<uint32_t>(x) : 0x7fc00000U;
    for (int i = 0; i < 4; ++i) value_ = (value_ ^ (bits >> (8 * i) & 0xff)) * 0x100000001b3U; // FNV-1a
  }
  void add(const V3f& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  void print(const char* name) const { std::printf("%s %016" PRIx64 "\n", name, value_); }

 private:
  uint64_t value_ = 0xcbf29ce484222325U;
};

// One number a statement: compilers choose the order of a call's arguments.
struct Draws {
  test::Random random;

  float number() { return random.next_1d(); }
  float between(float low, float high) { return low + (high - low) * random.next_1d(); }
  // The ends of the range are as frequent as the interior.
  float pick() { return std::clamp(2.0f * random.next_1d() - 0.5f, 0.0f, 1.0f); }
  Rgb color(float scale) {
    const float r = scale * random.next_1d(), g = scale * random.next_1d(), b = scale * random.next_1d();
    return {r, g, b};
  }
  V3f direction() {
    const V2f u = random.next_2d();
    return sample_uniform_hemisphere(u);
  }
};

BsdfParameters base_of(Draws& draws) {
  BsdfParameters p;
  p.base_color = draws.color(1.0f);
  p.metallic = draws.pick();
  p.roughness = draws.pick();
  p.ior = draws.between(1.0f, 2.5f);
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
  l.sheen_roughness = draws.number();
  l.anisotropy = draws.pick();
  l.iridescence = draws.pick();
  l.iridescence_ior = draws.between(1.0f, 2.0f);
  l.iridescence_thickness_nm = draws.between(0.0f, 1000.0f);
  l.transmission = draws.pick();
  l.thin_walled = draws.number() < 0.5f;
  l.eta = draws.number() < 0.5f ? ior : 1.0f / ior;
  l.diffuse_transmission = draws.pick();
  l.diffuse_transmission_color = draws.color(1.0f);
  return l;
}

template <typename Bsdf>
void add(Hash& hash, const Bsdf& bsdf, Draws& draws) {
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

void print_bsdfs() {
  Draws draws{test::Random(1)};
  Hash gltf, layered;
  for (int i = 0; i < 20000; ++i) {
    const BsdfParameters base = base_of(draws);
    const V3f wo = draws.direction();
    const LayerParameters layers = layers_of(draws, base.ior, wo);
    add(gltf, GltfBsdf(base, wo), draws);
    add(layered, LayeredBsdf(base, layers, wo), draws);
  }
  gltf.print("GltfBsdf");
  layered.print("LayeredBsdf");
}

void print_warps() {
  Draws draws{test::Random(2)};
  Hash hash;
  for (int i = 0; i < 200000; ++i) {
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

void print_filters() {
  Draws draws{test::Random(3)};
  Hash hash;
  for (const FilterKind kind :
       {FilterKind::blackman_harris, FilterKind::gaussian, FilterKind::box, FilterKind::mitchell}) {
    const PixelFilter filter({.kind = kind, .width = 2.5f});
    for (int i = 0; i < 50000; ++i) {
      const auto sample = filter.sample(draws.random.next_2d());
      hash.add(sample.offset.x);
      hash.add(sample.offset.y);
      hash.add(sample.weight);
    }
  }
  hash.print("filters");
}

} // namespace

int main() {
  print_bsdfs();
  print_warps();
  print_filters();
  return 0;
}
