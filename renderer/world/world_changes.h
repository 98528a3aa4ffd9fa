// Changes of a World that depend on its views: the built-in environment, and backs of faces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/world/build_world.h"
#include "renderer/world/world.h"

#include <memory>

namespace kindling {

// No thread may use the World meanwhile.
struct WorldChanges {
  // Builds the accelerator over the World's geometry, with WorldOptions::hide_backs. False if
  // cancelled; the World has none then. `structures` may be null.
  [[nodiscard]] static bool build_accelerator(World& world, const WorldOptions& options,
                                              std::unique_ptr<accel::PersistentStructures> structures,
                                              const CancelToken* cancel, ProgressListener* listener);

  // Sets the WorldOptions::view_point, and rebuilds the accelerator if it was built with another
  // WorldOptions::hide_backs. Fails
  // (render_failed) when cancelled; the World must not be used afterwards.
  [[nodiscard]] static Result<void> hide_backs(World& world, const WorldOptions& options, const CancelToken* cancel,
                                               ProgressListener* listener);

  // Adds the built-in environment to a World that is lit_by_emission_alone(), or removes it.
  static void light_by_studio(World& world, bool studio);
};

} // namespace kindling
