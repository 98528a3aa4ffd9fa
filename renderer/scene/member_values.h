// What animate_members() changes, as it was: a scene that is shown at one time after another goes back to it in between.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <vector>

namespace kindling {

// Without it the values of one time would reach into the next: what must be apart is kept apart (the cones of a spot) by changing members
// that no animation sets.
class MemberValues {
 public:
  // Copies the objects that have members if any animation changes one.
  explicit MemberValues(const Scene& scene);
  // Of the same scene. Nothing if nothing was copied.
  void restore(Scene& scene) const;

 private:
  bool animated_ = false;
  std::vector<Material> materials_;
  std::vector<SceneCamera> cameras_;
  std::vector<PunctualLight> lights_;
  std::vector<ImageLight> image_lights_;
  std::vector<std::vector<float>> mesh_weights_;
};

} // namespace kindling
