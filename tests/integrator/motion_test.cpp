// Motion blur compared with analytic coverage, the mean of static images, and a furnace.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/motion_scenes.h"

#include <algorithm>

namespace kindling::test {
namespace {

const PoseOptions kShutter{.shutter = Shutter{0.0, 1.0}};

Camera open_beam(const V3f& eye, const V3f& target, float side_m, const V2i& size_px) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = side_m * 0.5f;
  return {camera, look_at(eye, target), size_px, CameraMotion{.shutter_open = true}};
}

// --- closed forms --------------------------------------------------------------------------------

class MotionBlur : public testing::TestWithParam<accel::Kind> {};

// Returns the fraction of a pixel from x0 to x0 + 1, over the time from 0 to 1, that [left(t),
// right(t)] covers. Both ends move linearly.
double coverage(double x0, double left0, double left1, double right0, double right1) {
  double sum = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) / kSteps;
    const double left = left0 + (left1 - left0) * t, right = right0 + (right1 - right0) * t;
    sum += std::max(0.0, std::min(x0 + 1.0, right) - std::max(x0, left));
  }
  return sum / kSteps;
}

// Checks the columns of an image of an emissive plate on black, with 8 x 8 pixels of 1 m and a box
// filter of one pixel.
void expect_coverage(Scene scene, accel::Kind kind, double left0, double left1, double right0, double right1) {
  const auto world = make_posed_world(std::move(scene), kShutter, kind);
  const Camera camera = open_beam(V3f(0, 0, 10), V3f(0.0f), 8.0f, V2i(8, 8));
  RenderSettings settings = small_render(V2i(8, 8), 512);
  settings.filter = PixelFilter({.kind = FilterKind::box, .width = 1.0f});
  const Result<RenderOutcome> outcome = render(*world, camera, settings, nullptr, nullptr);
  ASSERT_TRUE(outcome.ok());
  const std::vector<float> beauty = outcome.value().film.resolve(Aov::beauty);
  for (size_t x = 0; x < 8; ++x) {
    double mean = 0.0;
    for (size_t y = 0; y < 8; ++y) mean += beauty[(y * 8 + x) * 3] / 8.0;
    const double expected = coverage(static_cast<double>(x) - 4.0, left0, left1, right0, right1);
    // Standard error of independent samples, an upper bound for the stratified ones.
    const double error = std::sqrt(expected * (1.0 - expected) / (512 * 8));
    EXPECT_NEAR(mean, expected, 4.0 * error + 1e-6) << "column " << x;
  }
}

TEST_P(MotionBlur, AMovingEdgeCoversPixelsForItsTime) {
  Scene scene = make_scene({emissive_material(Rgb(1.0f))}, {quad(V3f(-1, -9, 0), V3f(2, 0, 0), V3f(0, 18, 0), 0)});
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {-2.3f, 0, 0, 2.1f, 0, 0});
  expect_coverage(std::move(scene), GetParam(), -3.3, 1.1, -1.3, 3.1);
}

TEST_P(MotionBlur, ADeformingEdgeCoversPixelsForItsTime) {
  Scene scene = make_scene({emissive_material(Rgb(1.0f))}, {quad(V3f(-3.4f, -9, 0), V3f(1, 0, 0), V3f(0, 18, 0), 0)});
  add_morph(scene, 0, [](const V3f& p) { return V3f(p.x < -3.0f ? 1.0f : 5.7f, 0, 0); });
  expect_coverage(std::move(scene), GetParam(), -3.4, -2.4, -2.4, 3.3);
}

// White on white is invisible, unless rounding of the motion causes self-shadowing. Direct light
// alone.
TEST_P(MotionBlur, AMovingWhiteSphereVanishesInAFurnace) {
  for (const float scale : {1e-3f, 1.0f, 1e4f}) {
    for (const float offset : {0.0f, 20.0f}) {
      for (const bool deforms : {false, true}) {
        Scene scene = make_scene({diffuse_material(Rgb(1.0f))}, {sphere(V3f(0.0f), scale, 16, 0, false)});
        if (deforms) add_morph(scene, 0, [&](const V3f& p) { return V3f(-0.3f * p.x, 0.2f * p.y, 0.5f * scale); });
        const V3f at = V3f(offset, -offset, 0.5f * offset) * scale;
        animate(scene, 0, AnimatedProperty::translation, {0, 1},
                {at.x - scale, at.y, at.z, at.x + scale, at.y + 0.5f * scale, at.z});
        animate_turn(scene, 0, V3f(0, 0.6f, 0.8f), 130.0f);
        animate(scene, 0, AnimatedProperty::scale, {0, 1}, {1, 1, 1, 1.3f, 0.7f, 1});
        const auto world =
            make_posed_world(std::move(scene), kShutter, GetParam(), std::make_shared<Environment>(Rgb(1.0f)));
        const V2i size(16, 16);
        const Camera camera = open_beam(at + V3f(0, 0, 5) * scale, at, 5.0f * scale, size);
        RenderSettings settings = small_render(size, 16);
        settings.integrator.max_bounces = 0;
        const Mean mean = render_mean(*world, camera, settings);
        EXPECT_NEAR(mean.luminance, 1.0, 4.5 * mean.standard_error + 1e-4)
            << "scale " << scale << ", offset " << offset << ", deforms " << deforms;
      }
    }
  }
}

// Camera and plate are on the same turning arm, so the plate is static in the image, up to the
// keys' approximation of arcs.
TEST_P(MotionBlur, ObjectMovingWithTheCameraIsSharp) {
  Scene scene =
      make_scene({emissive_material(Rgb(1.0f))}, {quad(V3f(-0.7f, -0.6f, -4), V3f(1, 0, 0), V3f(0, 1.4f, 0), 0)});
  Node arm, eye;
  arm.children = {0, 2};
  arm.local.translation = V3f(2, 1, 0);
  eye.camera = 0;
  scene.cameras.emplace_back();
  scene.nodes.push_back(arm);
  scene.nodes.push_back(eye);
  scene.scenes[0].nodes = {1};
  animate_turn(scene, 1, V3f(0.6f, 0, 0.8f), 50.0f);
  const V2i size(16, 16);
  const auto image = [&](const PoseOptions& options) {
    const PosedScene posed = pose_scene(scene, options).value();
    const PosedCamera& placed = posed.cameras.at(0);
    const auto world = make_posed_world(scene, options, GetParam());
    const Camera camera(SceneCamera{}, placed.camera_to_world, size,
                        CameraMotion{placed.later_transforms, world->has_motion});
    const Result<RenderOutcome> outcome = render(*world, camera, small_render(size, 64), nullptr, nullptr);
    return outcome.value().film.resolve(Aov::beauty);
  };
  const std::vector<float> moving = image(kShutter), static_image = image({.time_s = 0.0});
  double covered = 0.0;
  for (size_t i = 0; i < static_image.size(); i += 3) {
    EXPECT_NEAR(moving[i], static_image[i], 0.05f) << "pixel " << i / 3; // three of 64 samples
    covered += static_image[i];
  }
  EXPECT_GT(covered, 20.0);
}

INSTANTIATE_TEST_SUITE_P(Accelerators, MotionBlur, testing::ValuesIn(kAllKinds), [](const auto& param) {
  return std::string(accel::kind_name(param.param) == "brute-force" ? "brute_force" : accel::kind_name(param.param));
});

// --- static images -------------------------------------------------------------------------------

// A floor and a lamp. The tests add moving objects.
Scene stage() {
  return make_scene(
      {diffuse_material(Rgb(0.7f)), emissive_material(Rgb(9.0f)), diffuse_material(Rgb(0.9f, 0.3f, 0.2f))},
      {quad(V3f(-4, -1, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0),
       quad(V3f(-0.7f, 4, -0.7f), V3f(1.4f, 0, 0), V3f(0, 0, 1.4f), 1)});
}
int add_thing(Scene& scene, Primitive primitive) {
  Node node;
  node.mesh = static_cast<int>(scene.meshes.size());
  scene.meshes.push_back({.primitives = {std::move(primitive)}});
  const auto index = static_cast<int>(scene.nodes.size());
  scene.scenes[0].nodes.push_back(index);
  scene.nodes.push_back(node);
  return index;
}

// A turning blade that carries a thin wall, and a sphere of cloudy glass that moves through the
// light.
Scene turning_blade() {
  Scene scene = stage();
  const int hub = add_thing(scene, quad(V3f(-0.2f, -0.8f, 0), V3f(0.4f, 0, 0), V3f(0, 2.4f, 0), 2));
  Material thin_wall;
  thin_wall.metallic_factor = thin_wall.roughness_factor = 0.0f;
  thin_wall.transmission_factor = 1.0f;
  thin_wall.base_color_factor = V4f(0.2f, 0.6f, 0.9f, 1.0f);
  Material cloudy = thin_wall;
  cloudy.roughness_factor = 0.4f;
  cloudy.thickness_factor = 1.0f;
  cloudy.attenuation_distance_m = 0.5f;
  cloudy.attenuation_color = Rgb(0.9f, 0.7f, 0.4f);
  cloudy.multiscatter_color = Rgb(0.4f, 0.3f, 0.2f);
  scene.materials.push_back(thin_wall);
  scene.materials.push_back(cloudy);
  const int glass = add_thing(scene, quad(V3f(0.3f, 0.2f, 0.4f), V3f(1.2f, 0, 0), V3f(0, 0.2f, -1.2f), 3));
  scene.scenes[0].nodes.pop_back();
  scene.nodes[static_cast<size_t>(hub)].children = {glass};
  animate_turn(scene, hub, V3f(0, 0, 1), 100.0f);
  const int globe = add_thing(scene, sphere(V3f(-1.6f, -0.3f, 1), 0.6f, 16, 4));
  animate(scene, globe, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 0.9f, 0.5f, 0});
  return scene;
}
Scene bending_and_swelling() {
  Scene scene = stage();
  scene.materials[2].roughness_factor = 0.4f; // shows normals
  scene.materials[2].metallic_factor = 1.0f;
  const int strip = add_thing(scene, jointed_strip(12, 2));
  add_bending_skin(scene, strip, V3f(0.6f, 0, 0.8f), 120.0f);
  const int globe = add_thing(scene, sphere(V3f(1.5f, -0.2f, 0.5f), 0.6f, 16, 2));
  add_morph(scene, globe, [](const V3f& p) { return V3f(0.5f * p.y, 0.4f + 0.5f * p.y, 0); });
  return scene;
}

// The stage with a moving lamp and a growing emissive sphere. Both are sampled as lights.
Scene moving_lamps() {
  Scene scene = stage();
  animate(scene, 1, AnimatedProperty::translation, {0, 1}, {-2, 0, 0, 2, -1, 0.5f});
  animate_turn(scene, 1, V3f(0, 0, 1), 60.0f);
  const int globe = add_thing(scene, sphere(V3f(1.5f, -0.5f, 1), 0.2f, 8, 1));
  add_morph(scene, globe, [](const V3f& p) { return (p - V3f(1.5f, -0.5f, 1)) * 1.5f; });
  add_thing(scene, sphere(V3f(-0.4f, -0.2f, 0), 0.8f, 16, 2));
  return scene;
}

struct Blur {
  const char* name;
  Scene (*scene)();
  IntegratorKind integrator;
};

class MeanOfStaticImages : public testing::TestWithParam<Blur> {};

// Compares blocks of 6 x 6 pixels of the blurred image with the mean of static images at jittered
// times.
TEST_P(MeanOfStaticImages, MatchesTheBlurredImage) {
  constexpr int kPoses = 96, kSide = 24, kBlock = 6;
  constexpr size_t kBlocks = (kSide / kBlock) * (kSide / kBlock);
  const V2i size(kSide, kSide);
  const auto environment = std::make_shared<Environment>(Rgb(0.15f, 0.2f, 0.25f));
  SceneCamera pinhole;
  pinhole.yfov_rad = 0.7f;
  const M44f placed = look_at(V3f(0.5f, 1.5f, 7), V3f(0, 0.6f, 0));
  struct Blocks {
    std::array<double, kBlocks> mean{}, variance{};
  };
  const auto render_blocks = [&](const World& world, uint32_t spp, uint32_t seed, bool open) {
    const Camera camera(pinhole, placed, size, CameraMotion{.shutter_open = open});
    RenderSettings settings = small_render(size, spp);
    settings.integrator.kind = GetParam().integrator;
    settings.integrator.max_bounces = 3;
    settings.integrator.ao_distance_m = 2.0f;
    settings.seed = seed;
    const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
    EXPECT_TRUE(outcome.ok());
    const std::vector<float> beauty = outcome.value().film.resolve(Aov::beauty);
    const std::vector<float> variance = outcome.value().film.resolve(Aov::variance);
    Blocks blocks;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto pixel = static_cast<size_t>(y * kSide + x);
        const auto block = static_cast<size_t>(y / kBlock * (kSide / kBlock) + x / kBlock);
        blocks.mean[block] += luminance(Rgb(beauty[pixel * 3], beauty[pixel * 3 + 1], beauty[pixel * 3 + 2])) / 36.0;
        blocks.variance[block] += variance[pixel] / (36.0 * 36.0);
      }
    return blocks;
  };
  const Blocks blurred =
      render_blocks(*make_posed_world(GetParam().scene(), kShutter, accel::Kind::embree, environment), 384, 1, true);
  Blocks static_mean, open, closed;
  for (int i = 0; i < kPoses; ++i) {
    const double time = (i + to_unit_float(hash_u32(static_cast<uint32_t>(i) + 77U))) / kPoses;
    const auto world = make_posed_world(GetParam().scene(), {.time_s = time}, accel::Kind::embree, environment);
    const Blocks static_image = render_blocks(*world, 8, static_cast<uint32_t>(i) + 2U, false);
    for (size_t b = 0; b < kBlocks; ++b) {
      static_mean.mean[b] += static_image.mean[b] / kPoses;
      static_mean.variance[b] += static_image.variance[b] / (kPoses * kPoses);
    }
    if (i == 0) open = static_image;
  }
  double changed = 0.0;
  for (size_t b = 0; b < kBlocks; ++b) {
    // Between neighboring poses a block changes by about 1/96 of its whole change. That bounds the
    // error from the jitter of each pose, and the errors of all poses are independent.
    const double jitter = std::abs(open.mean[b] - blurred.mean[b]) / (kPoses * std::sqrt(kPoses));
    const double error = std::sqrt(blurred.variance[b] + static_mean.variance[b]) + jitter;
    EXPECT_NEAR(blurred.mean[b], static_mean.mean[b], 4.5 * error + 2e-3 * static_mean.mean[b]) << "block " << b;
    changed = std::max(changed, std::abs(open.mean[b] - blurred.mean[b]) / (error + 1e-3));
  }
  EXPECT_GT(changed, 10.0); // the motion is visible
}

INSTANTIATE_TEST_SUITE_P(Scenes, MeanOfStaticImages,
                         testing::Values(Blur{"turning_blade", turning_blade, IntegratorKind::path},
                                         Blur{"bending_and_swelling", bending_and_swelling, IntegratorKind::path},
                                         Blur{"moving_lamps", moving_lamps, IntegratorKind::path},
                                         Blur{"occlusion_by_a_blade", turning_blade, IntegratorKind::ambient_occlusion},
                                         Blur{"normals_of_bending", bending_and_swelling, IntegratorKind::normal}),
                         [](const auto& param) { return std::string(param.param.name); });

} // namespace
} // namespace kindling::test
