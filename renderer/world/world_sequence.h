// The Worlds of one scene at one moment after another: what does not change between two is not prepared anew.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/world/build_world.h"
#include "renderer/world/world.h"

#include <memory>
#include <optional>
#include <vector>

namespace kindling {

struct WorldParts;

class WorldSequence {
 public:
  WorldSequence();
  ~WorldSequence();
  WorldSequence(const WorldSequence&) = delete;
  WorldSequence& operator=(const WorldSequence&) = delete;

  // The World that build_world() would make, to the bit; it lives until the next call. The scene and the options are the same each time,
  // but for what animations change. `more`: there will be a next call, and the scene keeps what that may need: its images, and the
  // vertices of all meshes but those that stand in one place for good. Else the scene is consumed.
  // If nothing but cameras has changed the World is the one before. Else images and their levels, and the vertices of what stands where
  // it stood, are handed on. Reports Phase::build. Fails as build_world() does; then the sequence is over.
  [[nodiscard]] Result<const World*> next(Scene& scene, PosedScene posed, const WorldOptions& options, bool more,
                                          const CancelToken* cancel, ProgressListener* listener);

 private:
  // What a World depends on and animations change.
  struct Shown {
    std::vector<PosedMesh> meshes; // undeformed ones
    std::vector<PosedLight> lights;
    std::vector<float> members; // but those of cameras
  };
  [[nodiscard]] bool is_shown(const PosedScene& posed, const std::vector<float>& members) const;

  std::unique_ptr<World> world_;
  std::unique_ptr<WorldParts> parts_;
  std::optional<Shown> shown_; // none: something deforms, or there is no World
};

// By mesh: it stands in one place for good, where one node that no animation moves, hides or deforms has it, of materials that no
// animation changes.
[[nodiscard]] std::vector<uint8_t> find_static_meshes(const Scene& scene);

} // namespace kindling
