// Compares the light groups and passes of renders that find light in different ways.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/render_session.h"
#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"
#include "tests/sampling/estimate.h"
#include "tests/session/split_film.h"

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace kindling::test {

inline void divide_light(RenderSettings& settings) {
  settings.integrator.light_groups = LightGrouping::name;
  for (const AovInfo& info : kAovs)
    if (is_light_pass(info.aov) || info.aov == Aov::direct || info.aov == Aov::indirect) settings.aovs.insert(info.aov);
}

// Lamps and a sun over glass, before and behind a leaf, and over a glossy floor.
inline std::unique_ptr<const World> leaf_world() {
  Material leaf = diffuse_material(Rgb(0.6f, 0.8f, 0.3f));
  leaf.diffuse_transmission_factor = 0.5f;
  leaf.diffuse_transmission_color_factor = Rgb(0.7f, 0.9f, 0.2f);
  Material square = emissive_material(Rgb(12.0f, 10.0f, 8.0f));
  square.name = "square";
  Scene scene =
      make_scene({glossy_material(Rgb(0.6f, 0.5f, 0.4f), 0.3f), glass_material(0.1f), square, leaf},
                 {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(-0.7f, 1.2f, -0.6f), 0.6f, 32, 1),
                  sphere(V3f(0.9f, 0.8f, -0.4f), 0.5f, 32, 1), quad(V3f(-1, 3.5f, -1), V3f(2, 0, 0), V3f(0, 0, 2), 2),
                  quad(V3f(-1.2f, 0.1f, 0.9f), V3f(1.4f, 0, 0), V3f(0, 1, 0), 3)});
  PunctualLight globe{.name = "globe", .intensity = 20.0f};
  globe.radius_m = 0.6f;
  place_light(scene, globe, look_at(V3f(-0.8f, 2.6f, -3.5f), V3f(0.0f)));
  PunctualLight sun{.name = "sun", .kind = PunctualLight::Kind::directional, .intensity = 2.0f};
  sun.angular_diameter_rad = 0.5f;
  place_light(scene, sun, look_at(V3f(2, 4, -2), V3f(0.0f)));
  return make_world(std::move(scene), accel::Kind::kdtree);
}

// Expects that all groups and passes have the same means after the change. `bias`: of what it
// finds, relative.
inline void expect_same_parts(const std::function<void(RenderSettings&)>& change, double bias) {
  const auto world = leaf_world();
  SceneCamera pinhole;
  pinhole.yfov_rad = 0.5f;
  const V2i size(24, 16);
  const Camera camera(pinhole, look_at(V3f(0, 2.5f, 7), V3f(0, 0.6f, 0)), size);
  std::map<std::string, Estimate> means[2];
  for (const bool changed : {false, true})
    for (uint32_t seed = 0; seed < 16; ++seed) {
      RenderSettings settings = small_render(size, 256);
      settings.guiding = Guiding::off;
      settings.seed = changed ? 100 + seed : seed;
      if (changed) change(settings);
      divide_light(settings);
      Result<RenderOutcome> outcome = render(*world, camera, settings, nullptr, nullptr);
      ASSERT_TRUE(outcome.ok()) << outcome.error().message;
      const Film& film = outcome.value().film;
      std::map<std::string, Estimate>& found = means[changed ? 1 : 0];
      for (size_t group = 0; group < film.light_groups().size(); ++group)
        found[film.light_groups()[group]].add(mean_luminance(film.resolve_light_group(group)));
      for (const AovInfo& info : kAovs)
        if (settings.aovs.contains(info.aov) && info.channels == 3)
          found[std::string(info.name)].add(mean_luminance(film.resolve(info.aov)));
    }
  ASSERT_EQ(means[0].size(), means[1].size());
  for (const auto& [name, without] : means[0]) {
    const Estimate& with = means[1][name];
    const double error = std::hypot(without.standard_error(), with.standard_error());
    EXPECT_NEAR(with.mean(), without.mean(), 5.5 * error + bias * without.mean() + 1e-9)
        << name; // of 15 degrees of freedom
    EXPECT_LE(error, 0.03 * without.mean()) << name;
  }
  for (const char* const name :
       {"square", "globe", "sun", "diffuse_indirect", "glossy_indirect", "transmission_indirect"})
    EXPECT_GT(means[0][name].mean(), 0.003) << name;
}

} // namespace kindling::test
