// Random collections of lights of every kind and size, valid and degenerate.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/sampling/warp.h"
#include "tests/light/light_fixtures.h"

namespace kindling::test {

inline V3f random_direction(Random& random) {
  const float z = 2.0f * random.next_1d() - 1.0f;
  const float phi = 2.0f * kPi * random.next_1d();
  const float r = safe_sqrt(1.0f - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

inline V3f random_point(Random& random, float extent) {
  const float x = random.next_1d(), y = random.next_1d(), z = random.next_1d();
  return (V3f(x, y, z) * 2.0f - V3f(1.0f)) * extent;
}

// In a cube of side 20: emissions 0 and 1 are one-sided, 2 two-sided, 3 two-sided and textured if
// `texture` is given. A third of the triangles are in a few clusters that face one way, some are
// tiny, one is huge, some have no area.
inline LightSetInput light_soup(uint32_t seed, int triangles, int points, int spots, const Texture* texture) {
  Random random(seed);
  LightSetInput input;
  input.scene_radius_m = 17.0f;
  input.emissions = {{Rgb(1.0f, 2.0f, 3.0f), nullptr, false},
                     {Rgb(40.0f, 10.0f, 10.0f), nullptr, false},
                     {Rgb(2.0f), nullptr, true},
                     {Rgb(3.0f, 1.0f, 2.0f), texture, true}};
  V3f cluster_center(0.0f);
  V3f cluster_normal(0.0f, -1.0f, 0.0f);
  for (int i = 0; i < triangles; ++i) {
    const auto emission = static_cast<uint32_t>(random.next_1d() * 4.0f);
    const float scale = i == 5 ? 6.0f : i % 7 == 0 ? 1e-3f : 0.1f + 0.4f * random.next_1d();
    V3f p0 = random_point(random, 10.0f);
    V3f a = random_direction(random) * scale;
    V3f b = random_direction(random) * scale;
    if (i % 3 == 0) {
      if (i % 30 == 0) {
        cluster_center = random_point(random, 8.0f);
        cluster_normal = random_direction(random);
      }
      p0 = cluster_center + random_point(random, 0.5f);
      if (a.cross(b).dot(cluster_normal) < 0.0f) std::swap(a, b);
    }
    if (i % 41 == 3) b = a;
    input.triangles.push_back({p0, p0 + a, p0 + b, emission});
    for (int corner = 0; corner < 3; ++corner) input.triangle_uvs.push_back(random.next_2d());
  }
  for (int i = 0; i < points; ++i) {
    input.points.push_back({random_point(random, 10.0f), Rgb(0.5f + 5.0f * random.next_1d()), {}});
    if (i % 3 == 1) input.points.back().range_m = 12.0f;
  }
  for (int i = 0; i < spots; ++i) {
    SpotLight spot;
    spot.position = random_point(random, 10.0f);
    spot.axis = random_direction(random);
    spot.intensity = Rgb(20.0f * random.next_1d());
    spot.cos_outer = std::cos(0.02f + 1.5f * random.next_1d());
    spot.cos_inner = lerp(spot.cos_outer, 1.0f, 0.5f * random.next_1d() + 0.01f);
    input.spots.push_back(spot);
  }
  return input;
}

} // namespace kindling::test
