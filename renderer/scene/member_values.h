// A copy of the animated members of a Scene, to restore them between two times.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/scene.h"

#include <vector>

namespace kindling {

// Without restoring, one time would affect the next: animate_members() enforces constraints (the
// cones of a spot) by changing members that no animation sets.
class MemberValues {
 public:
  // Copies all objects that can have animated members, if any animation changes one.
  explicit MemberValues(const Scene& scene);
  // Restores the members of the same scene. No-op if nothing was copied.
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
