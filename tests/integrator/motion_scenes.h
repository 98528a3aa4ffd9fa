// Builders of small animated scenes, and of their worlds over a shutter interval or at one time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/test_scenes.h"

#include <utility>

namespace kindling::test {

// Adds a channel with linear interpolation. `values` has the same number of components for each
// time.
inline void animate(Scene& scene, int node, AnimatedProperty property, std::vector<float> times,
                    std::vector<float> values) {
  AnimationChannel channel;
  channel.node = node;
  channel.property = property;
  channel.components = static_cast<int>(values.size() / times.size());
  channel.times_s = std::move(times);
  channel.values = std::move(values);
  if (scene.animations.empty()) scene.animations.emplace_back();
  scene.animations[0].channels.push_back(std::move(channel));
}

// Adds a rotation from time 0 to 1 about a unit axis, by less than 180 degrees.
inline void animate_turn(Scene& scene, int node, const V3f& axis, float degrees) {
  const float half = degrees * kPi / 360.0f;
  const V3f v = axis * std::sin(half);
  animate(scene, node, AnimatedProperty::rotation, {0, 1}, {0, 0, 0, 1, v.x, v.y, v.z, std::cos(half)});
}

inline std::unique_ptr<const World> make_posed_world(Scene scene, const PoseOptions& pose, accel::Kind kind,
                                                     std::shared_ptr<const Environment> environment = nullptr) {
  Result<PosedScene> posed = pose_scene(scene, pose);
  EXPECT_TRUE(posed.ok());
  WorldOptions options;
  options.accelerator = kind;
  options.environment = std::move(environment);
  options.studio = Studio::off;
  Result<std::unique_ptr<const World>> world =
      build_world(std::move(scene), std::move(posed).value(), options, nullptr, nullptr);
  EXPECT_TRUE(world.ok());
  return std::move(world).value();
}

// A strip of `segments` quads from y = 0 to y = 2, 0.8 m wide, in the plane z = 0, with normals and
// tangents. Its lower end follows joint 0, its upper one joint 1, which is at y = 1.
inline Primitive jointed_strip(int segments, int material) {
  Primitive strip;
  strip.material = material;
  for (int i = 0; i <= segments; ++i) {
    const float y = 2.0f * static_cast<float>(i) / static_cast<float>(segments);
    for (const float x : {-0.4f, 0.4f}) {
      strip.positions.emplace_back(x, y, 0.0f);
      strip.normals.emplace_back(0, 0, 1);
      strip.tangents.emplace_back(1, 0, 0, 1);
      strip.joints.push_back({0, 1, 0, 0});
      strip.weights.emplace_back(1.0f - 0.5f * y, 0.5f * y, 0.0f, 0.0f);
    }
  }
  for (uint32_t i = 0; i < static_cast<uint32_t>(segments); ++i)
    for (const uint32_t corner : {0U, 1U, 3U, 0U, 3U, 2U}) strip.indices.push_back(2 * i + corner);
  strip.texcoords = {std::vector<V2f>(strip.positions.size(), V2f(0.5f))};
  return strip;
}

// Gives the mesh of `node` a skin of two joints, the upper of which turns about `axis` by `degrees`
// from time 0 to 1.
inline void add_bending_skin(Scene& scene, int node, const V3f& axis, float degrees) {
  Node foot, top;
  const auto first = static_cast<int>(scene.nodes.size());
  foot.children = {first + 1};
  top.local.translation = V3f(0, 1, 0);
  scene.nodes.push_back(foot);
  scene.nodes.push_back(top);
  scene.scenes[0].nodes.push_back(first);
  Skin skin;
  skin.joints = {first, first + 1};
  skin.inverse_bind_matrices = {M44f(), M44f(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1)};
  scene.nodes[static_cast<size_t>(node)].skin = static_cast<int>(scene.skins.size());
  scene.skins.push_back(skin);
  animate_turn(scene, first + 1, axis, degrees);
}

// Adds a morph target to the mesh of `node` that displaces its vertices by `by(position)`, with a
// weight of 0 at time 0 and 1 at time 1.
template <typename By>
void add_morph(Scene& scene, int node, const By& by) {
  Mesh& mesh = scene.meshes[static_cast<size_t>(scene.nodes[static_cast<size_t>(node)].mesh)];
  MorphTarget target;
  for (const V3f& p : mesh.primitives[0].positions) target.positions.push_back(by(p));
  mesh.primitives[0].targets.push_back(std::move(target));
  mesh.weights.push_back(0.0f);
  animate(scene, node, AnimatedProperty::weights, {0, 1}, {0, 1});
}

} // namespace kindling::test
