// Glass at random, one by one and in lanes, for tests that compare both.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/bsdf/layered_bsdf.h"
#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/random.h"

#include <algorithm>
#include <cmath>

namespace kindling::test {

// The boundary of a volume of glass, as it is seen from one direction.
struct AnyGlass {
  BsdfParameters base;
  LayerParameters layers;
  V3f wo;

  // Draws any color and any view; the caller sets roughness and index of refraction. Glass of kind
  // 0 absorbs all light that it does not reflect totally, and kinds 0 and 1 reflect no other light.
  // Kind 2 is seen from the horizon, and kind 3 transmits diffuse light through a base that is not
  // there.
  AnyGlass(Random& random, uint64_t kind) {
    base.base_color = kind == 0 ? Rgb(0.0f) : Rgb{random.next_1d(), 1.0f, 1.2f * random.next_1d()};
    base.metallic = 0.0f;
    base.specular = kind <= 1 ? 0.0f : std::min(2.0f * random.next_1d(), 1.0f);
    base.specular_color = Rgb{1.0f, 30.0f * random.next_1d(), random.next_1d()};
    layers.transmission = 1.0f;
    layers.thin_walled = false;
    layers.diffuse_transmission = kind == 3 ? 0.5f : 0.0f;
    wo = random_direction(random);
    wo.z = kind == 2 ? 0.0f : std::abs(wo.z);
  }
};

// Eight of them, parameter by parameter.
struct GlassInLanes {
  LaneVectors base_color, specular_color, wo;
  LaneNumbers roughness, specular, eta, odds;

  void set(size_t lane, const AnyGlass& glass) {
    base_color.set(lane, glass.base.base_color), specular_color.set(lane, glass.base.specular_color);
    roughness[lane] = glass.base.roughness, specular[lane] = glass.base.specular;
    eta[lane] = glass.layers.eta, odds[lane] = glass.layers.reflection_odds;
    wo.set(lane, glass.wo);
  }
  [[nodiscard]] BsdfParametersOf<Lanes> parameters() const {
    return {base_color.load(), 0.0f, roughness.load(), 1.5f, specular.load(), specular_color.load()};
  }
};

} // namespace kindling::test
