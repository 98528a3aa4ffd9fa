// Several directions in the lanes of vectors have the bits of each direction alone.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/film_layer.h"
#include "renderer/bsdf/gltf_bsdf.h"
#include "renderer/bsdf/layered_bsdf.h"

#include "tests/base/same_bits.h"
#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kindling {
namespace {

using test::LayeredMaterial;
using test::pick;
using test::Random;
using test::random_direction;
using test::random_material;
using test::same_bits;

// Directions of all kinds, also at and below the horizon.
std::vector<V3f> random_directions(size_t count, Random& random) {
  std::vector<V3f> directions;
  for (; count > 0; --count) {
    V3f wi = random_direction(random);
    const float u = random.next_1d();
    if (u < 0.2f) wi.z = -wi.z;
    if (u > 0.9f) wi = V3f(wi.x, wi.y, 0.0f).normalized();
    directions.push_back(wi);
  }
  return directions;
}

template <typename Bsdf>
void expect_bits_of_each(const Bsdf& bsdf, const std::string& material, Random& random) {
  const std::vector<V3f> directions = random_directions(random.next_u64() % (kEvalsTogether + 1), random);
  BsdfEvals together;
  bsdf.eval(EvalDirections(directions), together);
  for (size_t n = 0; n < directions.size(); ++n) {
    const BsdfEval alone = bsdf.eval(directions[n]);
    ASSERT_TRUE(same_bits(together.value(n), alone.value))
        << together.value(n) << alone.value << directions[n] << material;
    ASSERT_TRUE(same_bits(together.pdfs[n], alone.pdf)) << directions[n] << material;
    ASSERT_TRUE(same_bits(together.reflection_pdfs[n], alone.reflection_pdf)) << directions[n] << material;
  }
}

TEST(EvalsTogether, HaveTheBitsOfGltfBsdf) {
  Random random(9);
  for (int i = 0; i < 50'000; ++i) {
    BsdfParameters p = random_material(random, 0.0f).base;
    if (i % 7 == 0) p.metallic = p.specular = 0.0f; // Lambert
    expect_bits_of_each(GltfBsdf(p, random_direction(random)), ", roughness " + std::to_string(p.roughness), random);
  }
}

// All layers at random, and each of them left out now and then.
TEST(EvalsTogether, HaveTheBitsOfLayeredBsdf) {
  Random random(10);
  for (int i = 0; i < 100'000; ++i) {
    LayeredMaterial m = random_material(random, 0.0f);
    const uint64_t without = random.next_u64();
    if (without & 1) m.layers.clearcoat = 0.0f;
    if (without & 2) m.layers.sheen_color = Rgb(0.0f);
    if (without & 4) m.layers.anisotropy = 0.0f;
    if (without & 8) m.layers.iridescence = 0.0f;
    if (without & 16) m.layers.transmission = 0.0f;
    if (without & 32) m.layers.diffuse_transmission = 0.0f;
    if ((without & 448) == 0) m.base.metallic = m.base.specular = 0.0f; // Lambert
    const V3f wo = random_direction(random);
    expect_bits_of_each(LayeredBsdf(m.base, m.layers, wo), describe(m, wo.z), random);
  }
}

// Films as thin as the one that fades, under a coat and not, from angles that are reflected totally
// too.
TEST(EvalsTogether, HaveTheBitsOfFilms) {
  Random random(11);
  for (int i = 0; i < 20'000; ++i) {
    LayerParameters layers = random_material(random, 0.0f).layers;
    if (i % 5 == 0) layers.iridescence_thickness_nm *= 5e-5f;
    if (i % 2 == 0) layers.clearcoat = 0.0f;
    const FilmLayer film(layers, test::color(random));
    LaneNumbers cosines;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) cosines[lane] = pick(random);
    LaneVectors together;
    together.store(film.fresnel(cosines.load()));
    for (size_t lane = 0; lane < Lanes::kCount; ++lane)
      ASSERT_TRUE(same_bits(together[lane], film.fresnel(cosines[lane]))) << cosines[lane];
  }
}

} // namespace
} // namespace kindling
