// Copies and restores animated members.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/member_values.h"

#include <algorithm>

namespace kindling {

MemberValues::MemberValues(const Scene& scene) {
  for (const Animation& animation : scene.animations)
    animated_ |= std::any_of(animation.channels.begin(), animation.channels.end(), [](const AnimationChannel& channel) {
      return channel.property == AnimatedProperty::member;
    });
  if (!animated_) return;
  materials_ = scene.materials;
  cameras_ = scene.cameras;
  lights_ = scene.lights;
  image_lights_ = scene.image_lights;
  for (const Mesh& mesh : scene.meshes) mesh_weights_.push_back(mesh.weights);
}

void MemberValues::restore(Scene& scene) const {
  if (!animated_) return;
  scene.materials = materials_;
  scene.cameras = cameras_;
  scene.lights = lights_;
  scene.image_lights = image_lights_;
  for (size_t mesh = 0; mesh < scene.meshes.size(); ++mesh) scene.meshes[mesh].weights = mesh_weights_[mesh];
}

} // namespace kindling
