// Motion vectors of scenes whose motion is known.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/frame_motion.h"
#include "renderer/scene/surface_motion.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <array>
#include <cmath>
#include <functional>

namespace kindling::test {
namespace {

const V2i kVectorSize(16, 16);
constexpr float kNow = 0.5f, kStep = 0.25f; // seconds

// Orthographic, from z = 5 at the square of side 4 around the origin: 4 pixels for each meter.
Camera front_view(const V3f& shift = V3f(0.0f)) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 2.0f;
  return {camera, look_at(V3f(0, 0, 5) + shift, shift), kVectorSize};
}

struct Vectors {
  std::vector<float> object, uv, position, vector, motion;
};

RenderSettings vector_settings(std::shared_ptr<const FrameMotion> motion) {
  RenderSettings settings = small_render(kVectorSize, 4);
  settings.motion = std::move(motion);
  for (const Aov aov : {Aov::object_id, Aov::uv, Aov::position_nearest, Aov::vector, Aov::motion})
    settings.aovs.insert(aov);
  return settings;
}

Vectors vectors_of(const World& world, const Camera& camera, const RenderSettings& settings) {
  const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  const Film& film = outcome.value().film;
  return {film.resolve(Aov::object_id), film.resolve(Aov::uv), film.resolve(Aov::position_nearest),
          film.resolve(Aov::vector), film.resolve(Aov::motion)};
}

// The scene at kNow, with frames at kStep before and after.
Vectors vectors_of(Scene scene, accel::Kind kind = accel::Kind::kdtree,
                   IntegratorKind integrator = IntegratorKind::path) {
  const auto motion =
      std::make_shared<const FrameMotion>(FrameMotion{{SurfaceMotion(scene, kNow, kNow - kStep), front_view()},
                                                      {SurfaceMotion(scene, kNow, kNow + kStep), front_view()}});
  const auto world =
      make_posed_world(std::move(scene), {.time_s = kNow}, kind, std::make_shared<Environment>(Rgb(1.0f)));
  RenderSettings settings = vector_settings(motion);
  settings.integrator.kind = integrator;
  return vectors_of(*world, front_view(), settings);
}

Primitive centered_square(float side, float z, int material) {
  return quad(V3f(-0.5f * side, -0.5f * side, z), V3f(side, 0, 0), V3f(0, side, 0), material);
}

// Expects both AOVs to be that motion: pixels to the previous and to the next frame, y upwards.
void expect_vector(const Vectors& found, size_t pixel, const V2f& previous, const V2f& next, float tolerance = 1e-4f) {
  const std::array<float, 4> vector{previous.x, previous.y, -next.x, -next.y};
  const std::array<float, 4> motion{next.x, next.y, previous.x, previous.y};
  for (size_t c = 0; c < 4; ++c) {
    EXPECT_NEAR(found.vector[4 * pixel + c], vector[c], tolerance) << "pixel " << pixel << " channel " << c;
    EXPECT_NEAR(found.motion[4 * pixel + c], motion[c], tolerance) << "pixel " << pixel << " channel " << c;
  }
}

TEST(MotionVectors, MovingInstancesAndStaticOnes) {
  // Two nodes of one mesh: one moves to the right by a meter in a second, the other is static.
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {centered_square(1.0f, 0, 0)});
  Node still = scene.nodes[0];
  still.local.translation = V3f(0, -1.4f, 0);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(still);
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {-0.5f, 0, 0, 0.5f, 0, 0});
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    const Vectors found = vectors_of(scene, kind);
    size_t moving = 0, standing = 0, missed = 0;
    for (size_t i = 0; i < found.object.size(); ++i) {
      const bool moves = found.object[i] == 1.0f;
      (moves ? moving : found.object[i] == 2.0f ? standing : missed) += 1;
      expect_vector(found, i, moves ? V2f(-1, 0) : V2f(0.0f), moves ? V2f(1, 0) : V2f(0.0f), moves ? 1e-5f : 0.0f);
    }
    EXPECT_GT(moving, 12U);
    EXPECT_GT(standing, 12U);
    EXPECT_GT(missed, 100U);
  }
}

TEST(MotionVectors, OtherIntegratorsHaveThem) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {centered_square(1.0f, 0, 0)});
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {0, -0.5f, 0, 0, 0.5f, 0});
  const Vectors path = vectors_of(scene);
  for (const IntegratorKind kind : {IntegratorKind::whitted, IntegratorKind::ambient_occlusion, IntegratorKind::uv}) {
    const Vectors found = vectors_of(scene, accel::Kind::kdtree, kind);
    EXPECT_TRUE(same_bits(found.vector, path.vector)) << integrator_name(kind);
    EXPECT_TRUE(same_bits(found.motion, path.motion)) << integrator_name(kind);
  }
  expect_vector(path, 8 * 16 + 8, V2f(0, -1), V2f(0, 1));
}

TEST(MotionVectors, TurningAndScaledParents) {
  // A square at x = 1 m of a node that turns about z by 120 degrees in a second: all points keep
  // their distance to the center.
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {centered_square(0.8f, 0, 0)});
  Node parent;
  parent.children = {0};
  parent.local.scale = V3f(0.5f);
  scene.nodes[0].local.translation = V3f(2, 0, 0);
  scene.nodes[0].local.scale = V3f(2.0f);
  scene.scenes[0].nodes = {1};
  scene.nodes.push_back(parent);
  animate_turn(scene, 1, V3f(0, 0, 1), 120.0f);
  const Vectors found = vectors_of(scene);
  size_t hits = 0;
  for (size_t i = 0; i < found.object.size(); ++i) {
    if (found.object[i] == 0.0f) continue;
    ++hits;
    const V2f at(found.position[3 * i], found.position[3 * i + 1]);
    // Rotations are interpolated along the arc, so a quarter of a second is 30 degrees.
    const auto turned = [&](float degrees) {
      const float angle = degrees * kPi / 180.0f;
      return V2f(at.x * std::cos(angle) - at.y * std::sin(angle), at.x * std::sin(angle) + at.y * std::cos(angle));
    };
    expect_vector(found, i, (turned(-30) - at) * 4.0f, (turned(30) - at) * 4.0f, 2e-4f);
  }
  EXPECT_GT(hits, 5U);
}

TEST(MotionVectors, MorphTargets) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.1f))},
                           {centered_square(1.0f, 0, 0), centered_square(4.0f, -1, 1)});
  scene.nodes[0].local.scale = V3f(2, 2, 1);
  add_morph(scene, 0, [](const V3f& p) { return V3f(0, p.x, 0); }); // shears it
  const Vectors found = vectors_of(scene);
  size_t hits = 0;
  for (size_t i = 0; i < found.object.size(); ++i) {
    const bool morphs = found.object[i] == 1.0f;
    hits += morphs ? 1 : 0;
    const float rise = morphs ? 4.0f * kStep * found.position[3 * i] : 0.0f;
    expect_vector(found, i, V2f(0, -rise), V2f(0, rise));
  }
  EXPECT_GT(hits, 40U);
}

TEST(MotionVectors, SkinsFollowTheirJoints) {
  Primitive strip = jointed_strip(8, 0);
  strip.texcoords[0].clear(); // the place of a point in the rest pose
  for (const V3f& p : strip.positions) strip.texcoords[0].emplace_back(p.x, p.y);
  const Primitive rest = strip;
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {std::move(strip)});
  scene.nodes[0].local.translation = V3f(9, 9, 9); // has no meaning for a skinned mesh
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {9, 9, 9, -9, 9, 9});
  add_bending_skin(scene, 0, V3f(0, 0, 1), 90.0f);
  const auto pose_at = [&](double time_s) {
    Result<PosedScene> posed = pose_scene(scene, {.time_s = time_s});
    EXPECT_TRUE(posed.ok());
    return posed.value().meshes[0].deformed[0].positions;
  };
  const std::vector<V3f> before = pose_at(kNow - kStep), now = pose_at(kNow), after = pose_at(kNow + kStep);
  const Vectors found = vectors_of(scene);
  size_t hits = 0;
  for (size_t i = 0; i < found.object.size(); ++i) {
    if (found.object[i] == 0.0f) continue;
    ++hits;
    const V2f at(found.uv[3 * i], found.uv[3 * i + 1]);
    std::optional<std::array<V3f, 3>> places;
    for (size_t t = 0; t + 2 < rest.indices.size() && !places; t += 3) {
      const auto corner = [&](size_t c) {
        const V3f& p = rest.positions[rest.indices[t + c]];
        return V2f(p.x, p.y);
      };
      const V2f u = corner(1) - corner(0), v = corner(2) - corner(0), d = at - corner(0);
      const float area = u.x * v.y - u.y * v.x;
      const float b1 = (d.x * v.y - d.y * v.x) / area, b2 = (u.x * d.y - u.y * d.x) / area;
      if (b1 < -1e-4f || b2 < -1e-4f || b1 + b2 > 1.0001f) continue;
      const auto between = [&](const std::vector<V3f>& p) {
        return p[rest.indices[t]] * (1.0f - b1 - b2) + p[rest.indices[t + 1]] * b1 + p[rest.indices[t + 2]] * b2;
      };
      places = {between(before), between(now), between(after)};
    }
    ASSERT_TRUE(places.has_value());
    const V3f back = ((*places)[0] - (*places)[1]) * 4.0f, forth = ((*places)[2] - (*places)[1]) * 4.0f;
    expect_vector(found, i, V2f(back.x, back.y), V2f(forth.x, forth.y), 1e-3f);
  }
  EXPECT_GT(hits, 8U);
}

TEST(MotionVectors, TheCameraMovesSurfacesAndTheBackground) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {centered_square(1.0f, 0, 0)});
  const auto world = make_world(std::move(scene), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(1.0f)));
  // To the right and up: static surfaces move to the left and down.
  auto motion = std::make_shared<const FrameMotion>(
      FrameMotion{{{}, front_view(V3f(-0.25f, -0.5f, 0))}, {{}, front_view(V3f(0.25f, 0.5f, 0))}});
  const Vectors moved = vectors_of(*world, front_view(), vector_settings(motion));
  size_t hits = 0;
  for (size_t i = 0; i < moved.object.size(); ++i) {
    const bool hit = moved.object[i] != 0.0f;
    hits += hit ? 1 : 0;
    // The background is infinitely far away: only a turn of the camera moves it.
    expect_vector(moved, i, hit ? V2f(1, 2) : V2f(0.0f), hit ? V2f(-1, -2) : V2f(0.0f));
  }
  EXPECT_GT(hits, 12U);
  // A turn about the vertical axis by 10 degrees to the left for each frame.
  const auto turned = [](float degrees) {
    const float angle = degrees * kPi / 180.0f;
    const V3f eye(0, 0, 5);
    return Camera(SceneCamera{}, look_at(eye, eye - V3f(std::sin(angle), 0, std::cos(angle))), kVectorSize);
  };
  motion = std::make_shared<const FrameMotion>(FrameMotion{{{}, turned(-10)}, {{}, turned(10)}});
  const Vectors seen = vectors_of(*world, turned(0), vector_settings(motion));
  const float pixels = 8.0f / std::tan(0.5f * SceneCamera{}.yfov_rad); // for a slope of 1
  const size_t corner = 0, middle = 8 * 16 + 8;
  EXPECT_EQ(seen.object[corner], 0.0f);
  EXPECT_EQ(seen.object[middle], 1.0f);
  // Both have a column near -7.5 and 0.5 pixels from the center.
  for (const auto& [pixel, column] : {std::pair{corner, -7.5f}, std::pair{middle, 0.5f}}) {
    const float slope = std::atan(column / pixels), step = 10.0f * kPi / 180.0f;
    EXPECT_NEAR(seen.motion[4 * pixel], pixels * std::tan(slope + step) - column, 1.2f) << pixel;
    EXPECT_NEAR(seen.motion[4 * pixel + 2], pixels * std::tan(slope - step) - column, 1.2f) << pixel;
  }
}

TEST(MotionVectors, AreRefusedWithoutFramesAndWithAShutter) {
  const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f))}, {centered_square(1.0f, 0, 0)}),
                                accel::Kind::kdtree, std::make_shared<Environment>(Rgb(1.0f)));
  const auto refusal = [&](const RenderSettings& settings, bool shutter) {
    const Camera camera(SceneCamera{}, look_at(V3f(0, 0, 5), V3f(0.0f)), kVectorSize,
                        CameraMotion{.shutter_open = shutter});
    const Result<RenderOutcome> outcome = render(*world, camera, settings, nullptr, nullptr);
    EXPECT_FALSE(outcome.ok());
    return outcome.ok() ? std::string() : outcome.error().message;
  };
  const auto motion = std::make_shared<const FrameMotion>(FrameMotion{{{}, front_view()}, {{}, front_view()}});
  EXPECT_NE(refusal(vector_settings(nullptr), false).find("RenderSettings::motion"), std::string::npos);
  EXPECT_NE(refusal(vector_settings(motion), true).find("--aov vector: not with motion blur"), std::string::npos);
}

} // namespace
} // namespace kindling::test
