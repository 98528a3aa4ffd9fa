// Random materials and directions for the tests of LayeredBsdf.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/sampling/random.h"

#include "renderer/bsdf/layered_bsdf.h"
#include "renderer/sampling/warp.h"

#include <cmath>
#include <string>

namespace kindling::test {

struct LayeredMaterial {
  BsdfParameters base;
  LayerParameters layers;
};

inline V3f view(float mu, float azimuth_turns) {
  const SinCos phi = sincos_turns(azimuth_turns);
  const float sin_theta = std::sqrt(std::max(1.0f - mu * mu, 0.0f));
  return {sin_theta * phi.cos, sin_theta * phi.sin, mu};
}

// The ends of the range are as frequent as the interior.
inline float pick(Random& random) { return saturate(2.0f * random.next_1d() - 0.5f); }
inline Rgb color(Random& random) {
  const float r = random.next_1d();
  const float g = random.next_1d();
  return {r, g, random.next_1d()};
}

// Returns a random direction above the surface, at least 0.01 degrees from it.
inline V3f random_direction(Random& random) {
  V3f w = sample_uniform_hemisphere(random.next_2d());
  w.z = std::max(w.z, 2e-4f);
  return w.normalized();
}

// All parameters are random; the roughness of base and coat is at least min_roughness.
inline LayeredMaterial random_material(Random& random, float min_roughness) {
  const auto rough = [&] { return std::max(pick(random), min_roughness); };
  LayeredMaterial m;
  m.base.base_color = color(random);
  m.base.metallic = random.next_1d() < 0.5f ? 0.0f : pick(random);
  m.base.roughness = rough();
  m.base.ior = 1.0f + 1.5f * random.next_1d();
  m.base.specular = pick(random);
  m.base.specular_color = color(random) * 2.0f;
  LayerParameters& l = m.layers;
  l.clearcoat = pick(random);
  l.clearcoat_roughness = rough();
  const V2f tilt = random.next_2d();
  l.clearcoat_normal = view(0.8f + 0.2f * tilt.x, tilt.y);
  const float sheen = pick(random);
  l.sheen_color = sheen * color(random);
  l.sheen_roughness = random.next_1d();
  l.anisotropy = pick(random);
  l.iridescence = pick(random);
  l.iridescence_ior = 1.0f + random.next_1d();
  l.iridescence_thickness_nm = 1000.0f * random.next_1d();
  l.transmission = pick(random);
  l.thin_walled = random.next_1d() < 0.5f;
  l.eta = random.next_1d() < 0.5f ? m.base.ior : 1.0f / m.base.ior;
  l.diffuse_transmission = pick(random);
  l.diffuse_transmission_color = color(random);
  return m;
}

// Sets every color to 1, so that a furnace reveals each loss.
inline LayeredMaterial whitened(LayeredMaterial m) {
  m.base.base_color = m.base.specular_color = m.layers.diffuse_transmission_color = Rgb(1.0f);
  if (max_component(m.layers.sheen_color) > 0.0f) m.layers.sheen_color = Rgb(max_component(m.layers.sheen_color));
  return m;
}

inline std::string describe(const LayeredMaterial& m, float mu) {
  const auto number = [](const char* name, float x) { return std::string(" ") + name + " " + std::to_string(x); };
  const auto rgb = [&](const char* name, const Rgb& c) {
    return number(name, c.x) + "," + std::to_string(c.y) + "," + std::to_string(c.z);
  };
  const LayerParameters& l = m.layers;
  return number("mu", mu) + rgb("base_color", m.base.base_color) + number("metallic", m.base.metallic) +
         number("roughness", m.base.roughness) + number("ior", m.base.ior) + number("specular", m.base.specular) +
         rgb("specular_color", m.base.specular_color) + number("clearcoat", l.clearcoat) +
         number("its roughness", l.clearcoat_roughness) + number("normal.z", l.clearcoat_normal.z) +
         rgb("sheen", l.sheen_color) + number("its roughness", l.sheen_roughness) + number("anisotropy", l.anisotropy) +
         number("iridescence", l.iridescence) + number("its ior", l.iridescence_ior) +
         number("nm", l.iridescence_thickness_nm) + number("transmission", l.transmission) +
         (l.thin_walled ? " thin" : " thick") + number("eta", l.eta) +
         number("diffuse transmission", l.diffuse_transmission);
}

// Mean weight of sample(): the albedo without straight transmission.
struct MeanWeight {
  Rgb value{0.0f};
  Rgb error{0.0f}; // standard errors
};
inline MeanWeight mean_weight(const LayeredBsdf& bsdf, uint64_t seed, int samples) {
  Random random(seed);
  double sum[3] = {0.0, 0.0, 0.0};
  double squares[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < samples; ++i) {
    const float u = random.next_1d();
    const auto s = bsdf.sample(u, random.next_2d());
    if (!s) continue;
    for (int c = 0; c < 3; ++c) {
      const auto w = static_cast<double>(s->weight[c]);
      sum[c] += w;
      squares[c] += w * w;
    }
  }
  MeanWeight result;
  for (int c = 0; c < 3; ++c) {
    const double mean = sum[c] / samples;
    result.value[c] = static_cast<float>(mean);
    result.error[c] = static_cast<float>(std::sqrt(std::max(squares[c] / samples - mean * mean, 0.0) / samples));
  }
  return result;
}

} // namespace kindling::test
