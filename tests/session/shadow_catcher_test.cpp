// Shadow catchers in scenes whose shadows are known.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/shadow_catchers.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <algorithm>
#include <cmath>

namespace kindling::test {
namespace {

const V2i kCatcherSize(16, 16);

// Orthographic, from above at the square of side 4 around the origin; x to the right.
Camera top_view() {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 2.0f;
  return {camera, kindling::look_at(V3f(0, 9, 0), V3f(0.0f), V3f(0, 0, -1)), kCatcherSize};
}

Primitive floor_of(float side, int material) {
  return quad(V3f(-0.5f * side, 0, 0.5f * side), V3f(side, 0, 0), V3f(0, 0, -side), material);
}

// A world whose node 0 is a catcher.
struct CatcherScene {
  explicit CatcherScene(Scene scene, accel::Kind kind, std::shared_ptr<const Environment> sky = nullptr) {
    WorldOptions options;
    options.accelerator = kind;
    std::vector<uint8_t> nodes(scene.nodes.size(), 0);
    nodes[0] = 1;
    world = make_world(std::move(scene), kind, std::move(sky));
    catchers = ShadowCatchers::make(*world, {std::move(nodes), {}}, options, nullptr);
  }
  [[nodiscard]] Film render(const RenderSettings& settings) const {
    Result<RenderOutcome> outcome = kindling::render(*world, top_view(), settings, nullptr, nullptr);
    EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
    return std::move(outcome).value().film;
  }
  [[nodiscard]] RenderSettings settings(uint32_t spp) const {
    RenderSettings settings = small_render(kCatcherSize, spp);
    settings.integrator.transparent_background = true;
    settings.aovs.insert(Aov::shadow_catcher);
    settings.catchers = catchers;
    return settings;
  }

  std::unique_ptr<const World> world;
  std::shared_ptr<const ShadowCatchers> catchers;
};

void expect_no_color(const Film& film) {
  for (const float value : film.resolve(Aov::beauty)) EXPECT_EQ(value, 0.0f);
}

TEST(ShadowCatcher, NothingIsSeenWhereNothingShades) {
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    Scene scene = make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.8f, 0.2f, 0.1f))},
                             {floor_of(3, 0), sphere(V3f(0, -2, 0), 0.5f, 16, 1)});
    scene.lights.emplace_back().radius_m = 0.3f;
    scene.nodes[0].light = 0;
    const CatcherScene caught(std::move(scene), kind, std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
    const Film film = caught.render(caught.settings(8));
    expect_no_color(film);
    for (const float alpha : film.resolve(Aov::alpha)) EXPECT_EQ(alpha, 0.0f);
    for (const float factor : film.resolve(Aov::shadow_catcher)) EXPECT_EQ(factor, 1.0f);
  }
}

// Two copies of a floor with a sphere, which is too large to be baked, so that they share a mesh: a
// catcher by its material has no shadow of the sphere in the scene without what shades.
TEST(ShadowCatcher, MaterialsCatchWhereverTheyAre) {
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    Scene scene = make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.8f, 0.2f, 0.1f))},
                             {floor_of(1.8f, 0), sphere(V3f(0, 0.5f, 0), 0.3f, 520, 1)});
    scene.meshes[0].primitives.push_back(scene.meshes[1].primitives[0]);
    scene.nodes[1].mesh = 0;
    for (const int node : {0, 1})
      scene.nodes[static_cast<size_t>(node)].local.translation = V3f(node == 0 ? -1.0f : 1.0f, 0, 0);
    const auto world = make_world(std::move(scene), kind, std::make_shared<Environment>(Rgb(1.0f)));
    WorldOptions options;
    options.accelerator = kind;
    const auto render_with = [&](CatcherFlags flags) {
      RenderSettings settings = small_render(kCatcherSize, 16);
      settings.integrator.transparent_background = true;
      settings.aovs.insert(Aov::shadow_catcher);
      settings.catchers = ShadowCatchers::make(*world, std::move(flags), options, nullptr);
      Result<RenderOutcome> outcome = render(*world, top_view(), settings, nullptr, nullptr);
      EXPECT_TRUE(outcome.ok());
      return std::move(outcome).value().film;
    };
    const Film by_material = render_with({{}, {1, 0}});
    const std::vector<float> color = by_material.resolve(Aov::beauty), alpha = by_material.resolve(Aov::alpha);
    size_t spheres = 0, shadows = 0;
    for (size_t i = 0; i < alpha.size(); ++i) {
      spheres += color[3 * i] > 0.0f ? 1 : 0;
      shadows += color[3 * i] == 0.0f && alpha[i] > 0.02f ? 1 : 0;
    }
    EXPECT_GT(spheres, 4U);
    EXPECT_GT(shadows, 40U);
    // By node the spheres are catchers as well: nothing is left that could shade.
    const Film by_node = render_with({{1, 1}, {}});
    expect_no_color(by_node);
    for (const float value : by_node.resolve(Aov::alpha)) EXPECT_EQ(value, 0.0f);
  }
}

// A sun straight above, and a square that blocks it over a part of the floor, behind the camera.
TEST(ShadowCatcher, HardShadowsAreBlack) {
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    Scene scene = make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.5f))},
                             {floor_of(8, 0), quad(V3f(-1, 20, 1), V3f(2, 0, 0), V3f(0, 0, -2), 1)});
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::directional;
    scene.lights.push_back(sun);
    Node above;
    above.light = 0;
    above.local.rotation.setAxisAngle(V3f(1, 0, 0), -0.5f * kPi); // lights shine along -z
    scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(above);
    const CatcherScene caught(std::move(scene), kind);
    RenderSettings settings = caught.settings(4);
    settings.filter = PixelFilter({.kind = FilterKind::box});
    settings.integrator.max_bounces = 0;
    const Film film = caught.render(settings);
    expect_no_color(film);
    const std::vector<float> alpha = film.resolve(Aov::alpha), factor = film.resolve(Aov::shadow_catcher);
    for (size_t i = 0; i < alpha.size(); ++i) {
      const auto inside = [](size_t k) { return k >= 4 && k < 12; }; // the border is that of pixels
      const bool shaded = inside(i % 16) && inside(i / 16);
      EXPECT_EQ(alpha[i], shaded ? 1.0f : 0.0f) << i;
      for (size_t c = 0; c < 3; ++c) EXPECT_EQ(factor[3 * i + c], shaded ? 0.0f : 1.0f) << i;
    }
  }
}

// A black wall that hides half of an even sky: cosine-weighted, half of the light on the floor
// before it, less the further away.
TEST(ShadowCatcher, SoftShadowsAreTheShareOfHiddenLight) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.0f))},
                           {floor_of(8, 0), quad(V3f(2.0f, 0, 1000), V3f(0, 0, -2000), V3f(0, 1000, 0), 1)});
  const CatcherScene caught(std::move(scene), accel::Kind::kdtree,
                            std::make_shared<Environment>(Rgb(1.0f, 2.0f, 3.0f)));
  const Film film = caught.render(caught.settings(256));
  expect_no_color(film);
  const std::vector<float> alpha = film.resolve(Aov::alpha);
  double sum = 0.0;
  for (const float value : alpha) sum += static_cast<double>(value);
  EXPECT_NEAR(sum / static_cast<double>(alpha.size()), 0.5, 0.01); // an infinite wall hides half at any distance
}

// Over an image of the catcher without objects, the result is the render of everything.
TEST(ShadowCatcher, CompositesToTheWholeScene) {
  const auto make = [] {
    Scene scene = make_scene({diffuse_material(Rgb(0.6f, 0.5f, 0.4f)), diffuse_material(Rgb(0.8f, 0.1f, 0.1f)),
                              emissive_material(Rgb(30.0f, 28.0f, 25.0f))},
                             {floor_of(40, 0), sphere(V3f(0.3f, 0.9f, 0), 0.7f, 24, 1),
                              quad(V3f(2.3f, 3, 0.4f), V3f(0, 0, -0.8f), V3f(0.8f, 0, 0), 2)});
    return scene;
  };
  const auto sky = std::make_shared<Environment>(Rgb(0.3f, 0.4f, 0.6f));
  const CatcherScene caught(make(), accel::Kind::kdtree, sky);
  RenderSettings settings = caught.settings(64);
  const Film film = caught.render(settings);
  RenderSettings plain = settings;
  plain.aovs = {};
  plain.catchers.reset();
  const Film whole = caught.render(plain);
  // The image behind: floor and lamp, which is not in view, without the sphere.
  Scene empty = make();
  empty.scenes[0].nodes = {0, 2};
  const CatcherScene bare(std::move(empty), accel::Kind::kdtree, sky);
  const Film background = bare.render(plain);
  const std::vector<float> color = film.resolve(Aov::beauty), factor = film.resolve(Aov::shadow_catcher),
                           behind = background.resolve(Aov::beauty), expected = whole.resolve(Aov::beauty),
                           alpha = film.resolve(Aov::alpha);
  float darkest = 0.0f;
  for (size_t i = 0; i < alpha.size(); ++i) {
    const bool floor = color[3 * i] == 0.0f && factor[3 * i] > 0.0f;
    // At edges the background has the noise of more samples than the floor before it.
    const bool edge = !floor && factor[3 * i] > 0.0f;
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(color[3 * i + c] + factor[3 * i + c] * behind[3 * i + c], expected[3 * i + c],
                  (edge ? 0.1f : 1e-3f) * (1.0f + expected[3 * i + c]))
          << i;
    if (floor) darkest = std::max(darkest, alpha[i]);
  }
  EXPECT_GT(darkest, 0.3f) << "there is no shadow, so nothing is tested";
}

// Objects that are no catchers, and AOVs, are those of a render without any.
TEST(ShadowCatcher, ObjectsKeepTheirBits) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.8f, 0.1f, 0.1f))},
                           {floor_of(1, 0), sphere(V3f(1, 1, 1), 0.9f, 24, 1)});
  const CatcherScene caught(std::move(scene), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.5f)));
  RenderSettings settings = caught.settings(9);
  settings.aovs.insert(Aov::normal);
  settings.aovs.insert(Aov::object_id);
  const Film film = caught.render(settings);
  settings.aovs = {};
  settings.catchers.reset();
  settings.aovs.insert(Aov::normal);
  settings.aovs.insert(Aov::object_id);
  const Film plain = caught.render(settings);
  EXPECT_TRUE(same_bits(film.resolve(Aov::normal), plain.resolve(Aov::normal)));
  EXPECT_TRUE(same_bits(film.resolve(Aov::object_id), plain.resolve(Aov::object_id)));
  const std::vector<float> with = film.resolve_rgba(), without = plain.resolve_rgba();
  const std::vector<float> object = plain.resolve(Aov::object_id);
  size_t spheres = 0;
  for (int y = 9; y < 16; ++y)
    for (int x = 9; x < 16; ++x) { // right of the floor's corner
      const size_t i = static_cast<size_t>(16 * y + x);
      if (x < 11 && y < 11) continue;
      spheres += object[i] == 2.0f ? 1 : 0;
      for (size_t c = 0; c < 4; ++c) EXPECT_EQ(with[4 * i + c], without[4 * i + c]) << i;
    }
  EXPECT_GT(spheres, 10U);
}

std::string refusal(const CatcherScene& caught, const RenderSettings& settings) {
  const Result<RenderOutcome> outcome = render(*caught.world, top_view(), settings, nullptr, nullptr);
  EXPECT_FALSE(outcome.ok());
  return outcome.ok() ? std::string() : outcome.error().message;
}

TEST(ShadowCatcher, IsRefusedWhereItCannotBe) {
  const CatcherScene caught(make_scene({diffuse_material(Rgb(0.5f))}, {floor_of(1, 0)}), accel::Kind::kdtree,
                            std::make_shared<Environment>(Rgb(0.5f)));
  RenderSettings settings = caught.settings(1);
  settings.integrator.kind = IntegratorKind::whitted;
  EXPECT_NE(refusal(caught, settings).find("the integrator 'whitted' has none"), std::string::npos);
  settings = caught.settings(1);
  settings.device = DeviceKind::host;
  EXPECT_NE(refusal(caught, settings).find("--shadow-catcher: not on the device 'host'"), std::string::npos);
  settings = caught.settings(64);
  settings.adaptive.noise_threshold = 0.1;
  EXPECT_NE(refusal(caught, settings).find("not with --noise-threshold"), std::string::npos);
  settings = caught.settings(1);
  settings.catchers.reset();
  EXPECT_NE(refusal(caught, settings).find("there is no shadow catcher"), std::string::npos);
}

} // namespace
} // namespace kindling::test
