// Tests that animated members are restored to the values of the file.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/member_values.h"

#include "renderer/scene/animated_members.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

// A spot whose outer cone is animated: at time 0 it is narrower than the inner one, which is
// reduced.
Scene spot_scene() {
  Scene scene;
  PunctualLight& light = scene.lights.emplace_back();
  light.kind = PunctualLight::Kind::spot;
  light.inner_cone_rad = 0.1f;
  light.outer_cone_rad = 0.3f;
  scene.materials.resize(1);
  AnimationChannel channel;
  channel.property = AnimatedProperty::member;
  channel.member = find_animated_member(scene, "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle").value();
  channel.times_s = {0.0f, 1.0f};
  channel.values = {0.05f, 0.5f};
  channel.components = 1;
  scene.animations.emplace_back().channels.push_back(channel);
  return scene;
}

TEST(MemberValues, RestoresMembersChangedByConstraints) {
  Scene scene = spot_scene();
  Scene fresh = scene;
  const MemberValues as_loaded(scene);
  animate_members(scene, 0.0);
  ASSERT_NE(scene.lights[0].inner_cone_rad, 0.1f) << "the constraint is inactive, so the test is void";
  as_loaded.restore(scene);
  EXPECT_EQ(scene.lights[0].inner_cone_rad, 0.1f);
  EXPECT_EQ(scene.lights[0].outer_cone_rad, 0.3f);
  animate_members(scene, 1.0);
  animate_members(fresh, 1.0);
  EXPECT_EQ(scene.lights[0].inner_cone_rad, fresh.lights[0].inner_cone_rad);
  EXPECT_EQ(scene.lights[0].outer_cone_rad, fresh.lights[0].outer_cone_rad);
}

TEST(MemberValues, RestoreIsNoOpWithoutAnimatedMembers) {
  Scene scene = spot_scene();
  scene.animations.clear();
  const MemberValues as_loaded(scene);
  scene.lights[0].intensity = 7.0f;
  as_loaded.restore(scene);
  EXPECT_EQ(scene.lights[0].intensity, 7.0f);
}

} // namespace
} // namespace kindling
