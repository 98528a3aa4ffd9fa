// A sequence of Worlds of one scene at different moments, which reuses unchanged parts.
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

  // Returns the World that build_world() would make, to the bit; it is valid until the next call.
  // The scene and the options must be the same each time, except for animated changes. With `more`
  // there will be a next call, and the scene keeps what it may need: its images, and the vertices
  // of all meshes except static ones with a single placement. Otherwise the scene is consumed.
  // If only cameras have changed, the previous World is returned. Otherwise images and their
  // levels, and the vertices of unchanged objects, are reused. Reports Phase::build. Fails like
  // build_world(); then the sequence is over.
  [[nodiscard]] Result<const World*> next(Scene& scene, PosedScene posed, const WorldOptions& options, bool more,
                                          const CancelToken* cancel, ProgressListener* listener);

  // Makes the World of the last next() that of options with this WorldOptions::hide_backs and
  // view_point, which the next ones may not have. Fails like build_world(); then the sequence is
  // over.
  [[nodiscard]] Result<void> hide_backs(const WorldOptions& options, const CancelToken* cancel,
                                        ProgressListener* listener);

  // Adds the built-in environment to the World of the last next(), which must be
  // lit_by_emission_alone(), or removes it. No thread may use the World meanwhile.
  void light_by_studio(bool studio);

 private:
  // The animated data that a World depends on.
  struct Shown {
    std::vector<PosedMesh> meshes; // undeformed ones
    std::vector<PosedLight> lights;
    std::vector<float> members; // without those of cameras
  };
  [[nodiscard]] bool is_shown(const PosedScene& posed, const std::vector<float>& members) const;

  std::unique_ptr<World> world_;
  std::unique_ptr<WorldParts> parts_;
  std::optional<Shown> shown_; // unset: something deforms, or there is no World
};

// Returns flags by mesh: 1 if it has a single placement, at a node that no animation moves, hides
// or deforms, with materials that no animation changes.
[[nodiscard]] std::vector<uint8_t> find_static_meshes(const Scene& scene);

} // namespace kindling
