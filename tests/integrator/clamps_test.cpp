// --clamp-direct and --clamp-indirect, checked on single samples.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

#include <algorithm>

namespace kindling::test {
namespace {

// Two walls and a colored lamp, which the camera sees as well.
std::unique_ptr<const World> corner_world() {
  return make_world(make_scene({diffuse_material(Rgb(0.8f, 0.6f, 0.4f)), emissive_material(Rgb(30.0f, 20.0f, 10.0f))},
                               {quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), 0),
                                quad(V3f(-2, 0, -2), V3f(4, 0, 0), V3f(0, 4, 0), 0),
                                quad(V3f(-0.5f, 1, -1), V3f(1, 0, 0), V3f(0, 0.3f, 0.3f), 1)}),
                    accel::Kind::embree);
}

constexpr Aov kParts[] = {Aov::emission, Aov::direct, Aov::indirect};

// Renders one sample per pixel.
Film render_corner(const World& world, float clamp_direct, float clamp_indirect) {
  const Camera camera(SceneCamera{}, look_at(V3f(0, 2, 5), V3f(0, 1, 0)), V2i(32, 32));
  RenderSettings settings = small_render(V2i(32, 32), 1);
  for (const Aov part : kParts) settings.aovs.insert(part);
  settings.integrator.clamp_direct = clamp_direct;
  settings.integrator.clamp_indirect = clamp_indirect;
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value().film;
}

TEST(Clamps, EachPartOfASampleIsScaledToItsLimit) {
  const auto world = corner_world();
  const Film full = render_corner(*world, kInfinity, kInfinity);
  const float limits[] = {kInfinity, 0.5f, 0.1f}; // by kParts; emission seen by the camera has no limit
  const Film clamped = render_corner(*world, limits[1], limits[2]);
  for (size_t part = 0; part < 3; ++part) {
    const std::vector<float> before = full.resolve(kParts[part]), after = clamped.resolve(kParts[part]);
    int scaled = 0, unchanged = 0;
    for (size_t i = 0; i < before.size(); i += 3) {
      const float peak = std::max({before[i], before[i + 1], before[i + 2]});
      const float scale = peak > limits[part] ? limits[part] / peak : 1.0f;
      if (peak > 0.0f) ++(scale < 1.0f ? scaled : unchanged);
      // The indirect part is a difference of sums and has the rounding errors of all three.
      for (size_t c = i; c < i + 3; ++c) EXPECT_NEAR(after[c], before[c] * scale, 1e-6f + 1e-5f * before[c] * scale);
    }
    EXPECT_GT(unchanged, 10);
    EXPECT_EQ(scaled > 10, part > 0) << scaled;
  }
}

TEST(Clamps, HighLimitsChangeNothing) {
  const auto world = corner_world();
  EXPECT_EQ(render_corner(*world, 1e6f, 1e6f).resolve_rgba(),
            render_corner(*world, kInfinity, kInfinity).resolve_rgba());
}

} // namespace
} // namespace kindling::test
