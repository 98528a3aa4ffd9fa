// Decisions from the view of an image: the built-in studio, and backs of single-sided faces.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/back_faces.h"
#include "renderer/facade/render_stage.h"
#include "renderer/facade/scene_light.h"
#include "tests/integrator/test_scenes.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <string>
#include <vector>

namespace kindling::test {
namespace {

class Warnings final : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override { messages.emplace_back(message); }
  void on_info(std::string_view) override {}
  std::vector<std::string> messages;
};

struct Built {
  std::unique_ptr<RenderScene> scene;
  RenderStage stage;
  std::vector<std::string> warnings;
};

PlacedCamera camera_at(const V3f& eye, const V3f& target) {
  PlacedCamera placed;
  placed.camera.yfov_rad = 0.8f;
  placed.camera_to_world = look_at(eye, target);
  return placed;
}

ImageSettings image_from(const V3f& eye, const V3f& target = V3f(0.0f)) {
  ImageSettings image;
  image.size_px = V2i(96, 64);
  image.spp = 4;
  image.own_camera = camera_at(eye, target);
  return image;
}

RenderStage stage_of(RenderScene& scene, const ImageSettings& image, Warnings& warnings) {
  Result<PosedImage> posed = pose_image(scene, image);
  EXPECT_TRUE(posed.ok()) << posed.error().message;
  Result<RenderStage> stage = build_stage(scene, std::move(posed).value(), image, true, nullptr, warnings);
  EXPECT_TRUE(stage.ok()) << stage.error().message;
  return std::move(stage).value();
}

Built build(Scene scene, const ImageSettings& image, const WorldSettings& world = {}) {
  Built built;
  Result<std::unique_ptr<RenderScene>> taken = take_render_scene(std::move(scene), world);
  EXPECT_TRUE(taken.ok());
  built.scene = std::move(taken).value();
  Warnings warnings;
  built.stage = stage_of(*built.scene, image, warnings);
  built.warnings = warnings.messages;
  return built;
}

// A gray sphere on a floor below a lamp of this side, three meters above the floor.
Scene sphere_and_lamp(float side) {
  return make_scene({diffuse_material(Rgb(0.5f)), emissive_material(Rgb(10.0f))},
                    {sphere(V3f(0.0f), 1.0f, 32, 0), quad(V3f(-3, -1, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0),
                     quad(V3f(-0.5f * side, 2, -0.5f * side), V3f(side, 0, 0), V3f(0, 0, side), 1)});
}

const V3f kEye(2.0f, 1.5f, 5.0f);

bool mentions(const std::vector<std::string>& messages, std::string_view text) {
  return std::any_of(messages.begin(), messages.end(),
                     [&](const std::string& message) { return message.find(text) != std::string::npos; });
}

TEST(StudioDecision, SmallLampsLeaveTheStudioOn) {
  const Built built = build(sphere_and_lamp(0.01f), image_from(kEye));
  EXPECT_TRUE(built.stage.light.studio);
  ASSERT_TRUE(built.stage.light.lit_share);
  EXPECT_LT(*built.stage.light.lit_share, 0.02);
  EXPECT_TRUE(built.stage.world->lights.has_environment);
  EXPECT_TRUE(mentions(built.warnings, "--studio off")) << testing::PrintToString(built.warnings);
}

TEST(StudioDecision, LampsThatLightTheViewSuffice) {
  const Built built = build(sphere_and_lamp(1.5f), image_from(kEye));
  EXPECT_FALSE(built.stage.light.studio);
  ASSERT_TRUE(built.stage.light.lit_share);
  EXPECT_GT(*built.stage.light.lit_share, 0.8);
  EXPECT_FALSE(built.stage.world->lights.has_environment);
  EXPECT_FALSE(mentions(built.warnings, "studio"));
}

TEST(StudioDecision, SettingsOverrideIt) {
  WorldSettings on, off;
  on.studio = Studio::on;
  off.studio = Studio::off;
  EXPECT_TRUE(build(sphere_and_lamp(1.5f), image_from(kEye), on).stage.world->lights.has_environment);
  EXPECT_FALSE(build(sphere_and_lamp(0.01f), image_from(kEye), off).stage.world->lights.has_environment);
  Scene dark = make_scene({diffuse_material(Rgb(0.5f))}, {sphere(V3f(0.0f), 1.0f, 16, 0)});
  EXPECT_FALSE(build(dark, image_from(kEye), off).stage.world->lights.has_environment);
  EXPECT_TRUE(build(dark, image_from(kEye)).stage.world->lights.has_environment);
}

TEST(StudioDecision, AddedStudioHasTheBitsOfOneFromTheStart) {
  WorldSettings on;
  on.studio = Studio::on;
  const ImageSettings image = image_from(kEye);
  const Built measured = build(sphere_and_lamp(0.01f), image), asked = build(sphere_and_lamp(0.01f), image, on);
  const auto pixels = [&](const Built& built) {
    return render(*built.stage.world, *built.stage.camera, to_render_settings(image, built.stage.size_px), nullptr,
                  nullptr)
        .value()
        .film.resolve_rgba();
  };
  EXPECT_EQ(pixels(measured), pixels(asked));
}

TEST(StudioDecision, ThreadsAndAcceleratorsAgree) {
  std::vector<double> shares;
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    WorldSettings world;
    world.accelerator = kind;
    double first = -1.0;
    for (const int threads : {1, 3}) {
      tbb::task_arena arena(threads);
      const Built built = arena.execute([&] { return build(sphere_and_lamp(0.5f), image_from(kEye), world); });
      ASSERT_TRUE(built.stage.light.lit_share);
      if (first < 0.0) first = *built.stage.light.lit_share;
      EXPECT_EQ(*built.stage.light.lit_share, first);
    }
    shares.push_back(first);
  }
  // Rounding moves few of some 2000 pixels across the threshold.
  EXPECT_NEAR(shares[1], shares[0], 0.005);
}

TEST(StudioDecision, TurntablesAreLitAlike) {
  Scene scene = sphere_and_lamp(0.5f);
  scene.meshes[1].primitives[0] = quad(V3f(-3, -1, -3), V3f(6, 0, 0), V3f(0, 6, 0), 0); // a wall behind
  std::optional<double> first;
  for (const float theta_deg : {0.0f, 17.0f, 90.0f, 181.0f}) {
    ImageSettings image;
    image.size_px = V2i(96, 64);
    image.orbit = V3f(theta_deg, 70.0f, 6.0f);
    const Built built = build(scene, image);
    ASSERT_TRUE(built.stage.light.lit_share);
    if (!first) first = built.stage.light.lit_share;
    EXPECT_EQ(built.stage.light.lit_share, first) << theta_deg;
  }
}

TEST(StudioDecision, FramesAreLitAsTheSceneAtRest) {
  Scene scene = sphere_and_lamp(1.5f);
  AnimationChannel away;
  away.node = 2;
  away.times_s = {0.0f, 1.0f};
  away.values = {0.0f, 0.0f, 0.0f, 0.0f, 100.0f, 0.0f};
  scene.animations.push_back({"away", {away}});
  ImageSettings image = image_from(kEye);
  const Built rest = build(scene, image);
  EXPECT_FALSE(rest.stage.light.studio);
  image.time_s = 1.0;
  const Built later = build(scene, image);
  EXPECT_EQ(later.stage.light.lit_share, rest.stage.light.lit_share);
  EXPECT_FALSE(later.stage.world->lights.has_environment);
  // At that time alone the lamp would not be enough.
  scene.nodes[2].local.translation = V3f(0.0f, 100.0f, 0.0f);
  scene.animations.clear();
  image.time_s.reset();
  EXPECT_TRUE(build(scene, image).stage.light.studio);
}

// A closed box around the origin whose faces look inwards or outwards, with a sphere in it.
Scene room(bool inwards) {
  Material wall = diffuse_material(Rgb(0.7f));
  wall.double_sided = false;
  std::vector<Primitive> walls;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-2.0f, 2.0f}) {
      V3f corner(-2.0f), u(0.0f), v(0.0f);
      corner[axis] = side;
      u[(axis + 1) % 3] = 4.0f;
      v[(axis + 2) % 3] = 4.0f; // u x v points along +axis
      if ((side > 0.0f) == inwards) std::swap(u, v);
      walls.push_back(quad(corner, u, v, 0));
    }
  walls.push_back(sphere(V3f(0.0f), 0.5f, 16, 0));
  return make_scene({wall}, std::move(walls));
}

TEST(BackFaces, RoomsSeenFromOutsideAreOpened) {
  const ImageSettings outside = image_from(V3f(3.0f, 4.0f, 6.0f));
  const Built built = build(room(true), outside);
  EXPECT_TRUE(built.stage.world->hides_backs);
  EXPECT_TRUE(mentions(built.warnings, "--backfaces show")) << testing::PrintToString(built.warnings);

  ImageSettings cull = outside;
  cull.backfaces = Backfaces::cull;
  const Built asked = build(room(true), cull);
  EXPECT_FALSE(mentions(asked.warnings, "--backfaces"));
  const auto depths = [&](const Built& b) {
    RenderSettings settings = to_render_settings(outside, b.stage.size_px);
    settings.aovs.insert(Aov::depth);
    return render(*b.stage.world, *b.stage.camera, settings, nullptr, nullptr).value().film.resolve(Aov::depth);
  };
  EXPECT_EQ(depths(built), depths(asked));

  ImageSettings show = outside;
  show.backfaces = Backfaces::show;
  const Built shown = build(room(true), show);
  EXPECT_FALSE(shown.stage.world->hides_backs);
  EXPECT_NE(depths(shown), depths(asked));
}

TEST(BackFaces, LightEntersWhereTheCameraLooksThrough) {
  const V3f eye(3.0f, 4.0f, 6.0f);
  const Built built = build(room(true), image_from(eye)); // lit by the studio around it
  const World& world = *built.stage.world;
  const auto meets_wall = [&](const V3f& direction) { // from beside the sphere
    const accel::Ray ray{.origin = V3f(1.0f, 1.0f, 1.0f), .direction = direction, .t_max = kInfinity};
    const bool hit = world.accelerator().intersect(ray).is_hit();
    EXPECT_EQ(world.accelerator().occluded(ray), hit);
    return hit;
  };
  for (const V3f& towards_camera : {V3f(1, 0, 0), V3f(0, 1, 0), V3f(0, 0, 1)}) EXPECT_FALSE(meets_wall(towards_camera));
  for (const V3f& away : {V3f(-1, 0, 0), V3f(0, -1, 0), V3f(0, 0, -1)}) EXPECT_TRUE(meets_wall(away));
  // The far side of the sphere turns its back to the camera, too, but is behind its near side.
  const V3f axis = eye.normalized();
  const accel::Ray far_side{.origin = axis * -1.0f, .direction = axis, .t_max = 1.0f};
  const accel::Hit hit = world.accelerator().intersect(far_side);
  ASSERT_TRUE(hit.is_hit());
  EXPECT_NEAR(hit.t, 0.5f, 0.02f);
  const RenderSettings settings = to_render_settings(image_from(eye), built.stage.size_px);
  const std::vector<float> rgb =
      render(world, *built.stage.camera, settings, nullptr, nullptr).value().film.resolve(Aov::beauty);
  const size_t middle = 3 * static_cast<size_t>(32 * 96 + 48); // on the sphere
  EXPECT_GT(rgb[middle], 0.1f);
}

TEST(BackFaces, OtherViewsShowBacks) {
  const auto hidden = [](Scene scene, const V3f& eye, const V3f& target) {
    return build(std::move(scene), image_from(eye, target)).stage.world->hides_backs;
  };
  EXPECT_FALSE(hidden(room(true), V3f(0.0f, 1.0f, 1.5f), V3f(0.0f)));  // a room from inside
  EXPECT_FALSE(hidden(room(false), V3f(0.0f, 1.0f, 1.5f), V3f(0.0f))); // a shell from inside: only nothing is behind
  EXPECT_FALSE(hidden(room(false), V3f(3.0f, 4.0f, 6.0f), V3f(0.0f))); // a closed box
}

TEST(BackFaces, OneSceneFollowsItsCamera) {
  Built built = build(room(true), image_from(V3f(3.0f, 4.0f, 6.0f)));
  EXPECT_TRUE(built.stage.world->hides_backs);
  Warnings warnings;
  EXPECT_TRUE(stage_of(*built.scene, image_from(V3f(-3.0f, -4.0f, -6.0f)), warnings).world->hides_backs);
  EXPECT_FALSE(stage_of(*built.scene, image_from(V3f(0.0f, 1.0f, 1.5f)), warnings).world->hides_backs);
  EXPECT_TRUE(stage_of(*built.scene, image_from(V3f(3.0f, 4.0f, 6.0f)), warnings).world->hides_backs);
}

// A room with a camera that flies from outside into it, from time 0 to 1, and starts outside.
Scene room_with_flight() {
  Scene scene = room(true);
  scene.cameras.emplace_back();
  scene.cameras[0].yfov_rad = 0.8f;
  Node camera;
  camera.camera = 0;
  camera.local.translation = V3f(0.0f, 0.0f, 8.0f);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  AnimationChannel flight;
  flight.node = static_cast<int>(scene.nodes.size());
  flight.times_s = {0.0f, 1.0f};
  flight.values = {0.0f, 0.0f, 8.0f, 0.0f, 0.0f, 1.5f};
  scene.nodes.push_back(camera);
  scene.animations.push_back({"flight", {flight}});
  return scene;
}

ImageSettings frame_at(double time_s) {
  ImageSettings image;
  image.size_px = V2i(96, 64);
  image.time_s = time_s;
  return image;
}

TEST(BackFaces, FramesDecideAsTheSceneAtRest) {
  Built first = build(room_with_flight(), frame_at(0.0));
  EXPECT_TRUE(first.stage.world->hides_backs);
  EXPECT_TRUE(mentions(first.warnings, "--backfaces show"));
  Warnings later;
  EXPECT_TRUE(stage_of(*first.scene, frame_at(1.0), later).world->hides_backs);
  EXPECT_FALSE(mentions(later.messages, "--backfaces")) << "reported again";
  // A frame by itself, as another process renders it.
  EXPECT_TRUE(build(room_with_flight(), frame_at(1.0)).stage.world->hides_backs);

  // From inside outwards, and with walls that move away: the scene at rest decides.
  Scene scene = room_with_flight();
  scene.nodes.back().local.translation = V3f(0.0f, 0.0f, 1.5f);
  Built inside = build(scene, frame_at(0.0));
  EXPECT_FALSE(inside.stage.world->hides_backs);
  Scene moving = room_with_flight();
  AnimationChannel away;
  away.node = 5; // the wall towards the camera
  away.times_s = {0.0f, 1.0f};
  away.values = {0.0f, 0.0f, 0.0f, 0.0f, 50.0f, 0.0f};
  moving.animations[0].channels = {away};
  EXPECT_TRUE(build(moving, frame_at(1.0)).stage.world->hides_backs);
  moving.animations.clear();
  moving.nodes[5].local.translation = V3f(0.0f, 50.0f, 0.0f);
  EXPECT_FALSE(build(moving, frame_at(1.0)).stage.world->hides_backs) << "the wall makes no difference";
}

TEST(BackFaces, TurntablesDecideAlike) {
  Scene scene = room(true);
  scene.scenes[0].nodes = {5, 6}; // one wall, towards +z, and the sphere
  scene.meshes[5].primitives[0] = quad(V3f(2, -2, 1), V3f(-4, 0, 0), V3f(0, 4, 0), 0);
  std::optional<bool> hidden;
  for (const float theta_deg : {0.0f, 45.0f, 90.0f, 180.0f}) {
    ImageSettings image;
    image.size_px = V2i(96, 64);
    image.orbit = V3f(theta_deg, 80.0f, 8.0f);
    const bool hides = build(scene, image).stage.world->hides_backs;
    if (!hidden) hidden = hides;
    EXPECT_EQ(hides, *hidden) << theta_deg;
  }
}

TEST(SharedExposure, FramesHaveThatOfTheSceneAtRest) {
  // The lamp that lights the sphere flies away.
  Scene scene = sphere_and_lamp(1.5f);
  scene.cameras.emplace_back();
  Node camera;
  camera.camera = 0;
  camera.local.translation = V3f(0.0f, 0.0f, 6.0f);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(camera);
  AnimationChannel away;
  away.node = 2;
  away.times_s = {0.0f, 1.0f};
  away.values = {0.0f, 0.0f, 0.0f, 0.0f, 100.0f, 0.0f};
  scene.animations.push_back({"away", {away}});
  const auto stops = [&](std::optional<double> time_s, bool wanted) {
    auto taken = take_render_scene(scene, {}).value();
    taken->shares_exposure = wanted;
    ImageSettings image;
    image.size_px = V2i(96, 64);
    image.time_s = time_s;
    Warnings warnings;
    return stage_of(*taken, image, warnings).exposure_stops;
  };
  const std::optional<double> first = stops(0.0, true);
  ASSERT_TRUE(first);
  EXPECT_LT(*first, 3.0); // without the lamp the image is black
  EXPECT_EQ(stops(1.0, true), first);
  EXPECT_FALSE(stops(1.0, false));
  EXPECT_FALSE(stops(std::nullopt, true)) << "one image has an exposure of its own";
}

} // namespace
} // namespace kindling::test
