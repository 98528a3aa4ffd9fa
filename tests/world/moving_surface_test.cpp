// Tests of surfaces of moving objects against the same objects posed at the ray's time.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/motion_scenes.h"

namespace kindling::test {
namespace {

constexpr float kTimes[] = {0.0f, 0.13f, 0.5f, 0.77f, 1.0f};

Scene turning_sphere() {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {sphere(V3f(0.0f), 1.0f, 24, 0)});
  scene.nodes[0].local.scale = V3f(1.0f, 0.6f, -1.5f);
  animate_turn(scene, 0, V3f(0, 0, 1), 40.0f);
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 2, 1, 0.5f});
  return scene;
}

Scene bending_strip() {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {jointed_strip(40, 0)});
  add_bending_skin(scene, 0, V3f(1, 0, 0), 70.0f);
  return scene;
}

Scene swelling_sphere() {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {sphere(V3f(0.0f), 1.0f, 24, 0)});
  add_morph(scene, 0, [](const V3f& p) { return V3f(p.x, 0.3f * p.y, 0.0f); });
  scene.nodes[0].local.scale = V3f(-1.0f, 1.0f, 1.0f); // mirrored
  animate_turn(scene, 0, V3f(0, 1, 0), 30.0f);
  return scene;
}

struct Case {
  const char* name;
  Scene (*scene)();
  bool deforms;
  float tolerance_m; // from keys: a thousandth of the radius, magnified at grazing views
};
const Case kCases[] = {{"sphere", turning_sphere, false, 4e-3f},
                       {"strip", bending_strip, true, 4e-3f},
                       {"swelling", swelling_sphere, true, 6e-3f}};

TEST(MovingSurface, MatchesPoseAtTimeOfRay) {
  for (const Case& c : kCases) {
    const auto moving = make_posed_world(c.scene(), {.shutter = Shutter{0.0, 1.0}}, accel::Kind::brute_force);
    EXPECT_TRUE(moving->has_motion);
    for (const float time : kTimes) {
      const auto still = make_posed_world(c.scene(), {.time_s = time}, accel::Kind::brute_force);
      EXPECT_FALSE(still->has_motion);
      const V3f center = still->bounds.center();
      int compared = 0;
      for (int i = 0; i < 400; ++i) {
        // Rays from all around to points near the center.
        const float z = 1.0f - 2.0f * (static_cast<float>(i) + 0.5f) / 400.0f, phi = 2.39996f * static_cast<float>(i);
        const float r = std::sqrt(1.0f - z * z);
        const V3f from = center + V3f(r * std::cos(phi), r * std::sin(phi), z) * 10.0f;
        const V3f to = center + V3f(std::sin(9.0f * phi), std::cos(7.0f * phi), std::sin(5.0f * phi)) * 0.3f;
        const accel::Ray ray{.origin = from, .direction = (to - from).normalized(), .t_max = kInfinity, .time = time};
        const accel::Hit hit = moving->accelerator().intersect(ray), true_hit = still->accelerator().intersect(ray);
        if (!hit.is_hit() || !true_hit.is_hit() || hit.triangle != true_hit.triangle) continue;
        SurfacePoint found, expected;
        moving->surface_at(ray, hit, found);
        still->surface_at(ray, true_hit, expected);
        if (std::abs(expected.geometric_normal.dot(ray.direction)) < 0.3f) continue;
        ++compared;
        EXPECT_LT((found.position - expected.position).length(), c.tolerance_m) << c.name << " at " << time;
        // On the ray as well, within the bound.
        const V3f off_ray = (found.position - from).cross(ray.direction);
        EXPECT_LT(off_ray.length(), 2e-5f) << c.name;
        EXPECT_LT(found.position_error, 1e-4f) << c.name;
        EXPECT_GT(found.geometric_normal.dot(expected.geometric_normal), 0.9999f) << c.name << " at " << time;
        // Static objects are baked with unit vertex normals, which interpolate differently in
        // scaled meshes.
        EXPECT_GT(found.shading_normal.dot(expected.shading_normal), 0.999f) << c.name << " at " << time;
      }
      EXPECT_GT(compared, 60) << c.name << " at " << time;
    }
  }
}

// The front side of a mirrored, deforming mesh is the same as without a shutter: emission of
// one-sided material shows it.
TEST(MovingSurface, KeepsFrontSide) {
  for (Scene (*make)() : {turning_sphere, swelling_sphere}) {
    Scene scene = make();
    scene.materials[0].emissive_factor = Rgb(1.0f);
    scene.materials[0].double_sided = false;
    const auto world = make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, accel::Kind::brute_force);
    for (const float time : kTimes) {
      const accel::Ray ray{.origin = V3f(0.1f, 0.2f, 8), .direction = V3f(0, 0, -1), .t_max = kInfinity, .time = time};
      const accel::Hit hit = world->accelerator().intersect(ray);
      if (!hit.is_hit()) continue;
      SurfacePoint surface;
      world->surface_at(ray, hit, surface);
      EXPECT_EQ(surface.emitted, Rgb(1.0f)) << time;
      // Light sampling uses the triangle as well, with the same front side at that time.
      EXPECT_EQ(surface.emissive_triangle, hit.triangle);
      EXPECT_EQ(world->lights.emitted(surface.emissive_triangle, 0.3f, 0.3f, ray.direction, time), Rgb(1.0f)) << time;
      EXPECT_GT(world->lights.pdf_triangle(surface.emissive_triangle, ray.origin, V3f(0.0f), ray.direction, hit.t,
                                           nullptr, time),
                0.0f);
      EXPECT_GT(surface.shading_normal.z, 0.0f);
    }
    EXPECT_FALSE(world->lights.empty());
  }
}

TEST(MovingWorld, StaticMeshesAreBakedAndMovingOnesShared) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))},
                           {sphere(V3f(0.0f), 1.0f, 8, 0), quad(V3f(-1, -1, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)});
  for (const float x : {3.0f, 6.0f}) { // two more spheres, one of them moving
    Node node = scene.nodes[0];
    node.local.translation = V3f(x, 0, 0);
    scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
  }
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 0, 0, -9});
  animate(scene, 3, AnimatedProperty::translation, {0, 1}, {6, 0, 0, 6, 7, 0});
  const auto world = make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, accel::Kind::embree);
  const accel::BuildInput input = world->accelerator_input();
  EXPECT_EQ(input.meshes.size(), 3U); // baked: a sphere and the floor; the sphere that moves
  ASSERT_EQ(input.groups.size(), 2U);
  ASSERT_EQ(input.instances.size(), 3U);
  EXPECT_EQ(input.instances[0].motion, accel::kNoId);
  EXPECT_EQ(input.instances[1].group, input.instances[2].group);
  ASSERT_EQ(input.motions.size(), 2U);
  EXPECT_EQ(input.motions[0].size(), 2U);
  EXPECT_EQ(input.motions[0][0], input.instances[1].object_to_world);
  // Over the shutter: the spheres move down to z = -10 and up to y = 8.
  EXPECT_NEAR(world->bounds.min.z, -10.0f, 1e-4f);
  EXPECT_NEAR(world->bounds.max.y, 8.0f, 1e-4f);
  EXPECT_EQ(world->statistics().motion.moving_instance_count, 2U);
  EXPECT_EQ(world->statistics().motion.max_keys, 2U);
}

TEST(MovingWorld, DeformingMeshesHaveOwnGroups) {
  const auto world = make_posed_world(bending_strip(), {.shutter = Shutter{0.0, 1.0}}, accel::Kind::embree);
  const accel::BuildInput input = world->accelerator_input();
  ASSERT_EQ(input.meshes.size(), 1U);
  EXPECT_GE(input.meshes[0].later_positions.size(), 8U);
  EXPECT_EQ(input.instances[0].motion, accel::kNoId);
  EXPECT_EQ(input.instances[0].object_to_world, M44f());
  EXPECT_EQ(world->statistics().motion.deforming_mesh_count, 1U);
  EXPECT_GT(world->statistics().motion.key_bytes, 8 * input.meshes[0].positions.size() * 36);
}

TEST(MovingWorld, MovingLampsLightTheScene) {
  Scene scene = turning_sphere();
  scene.materials[0].emissive_factor = Rgb(1.0f);
  PosedScene posed = pose_scene(scene, {.shutter = Shutter{0.0, 1.0}}).value();
  const auto world = build_world(std::move(scene), std::move(posed), {}, nullptr, nullptr);
  EXPECT_FALSE(world.value()->lights.has_environment); // no studio
}

} // namespace
} // namespace kindling::test
