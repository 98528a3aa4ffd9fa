// From a Scene, posed at one moment, to the World that is rendered.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/world/world.h"

#include <functional>
#include <memory>
#include <optional>

namespace kindling {

class TextureMemory;

struct WorldOptions {
  accel::Kind accelerator = accel::Kind::embree;
  accel::Quality quality = accel::Quality::balanced;
  bool robust = true;                             // of Embree
  std::optional<accel::SimdTarget> simd;          // of the kd-tree's kernels; none: the best that the processor runs
  std::shared_ptr<const Environment> environment; // null: none, or the built-in one if the scene has no lights
  // When triangles that stand for good have a tree of their own (persistent_meshes.h): so many, and more for an image of more samples.
  size_t min_persistent_triangles = 100'000;
  uint64_t image_samples = 0;              // planned for the whole image: pixels times samples of each
  TextureMemory* texture_memory = nullptr; // what the scene was loaded with; must outlive the World; may be null
  bool builtin_environment = true;         // a scene without any light gets a neutral one
  // Called once with the accelerator; what it returns is used in its place (a recorder of rays around it). May be null.
  std::function<std::unique_ptr<accel::Accelerator>(std::unique_ptr<accel::Accelerator>)> wrap_accelerator;
};

// Consumes the scene: vertex arrays are moved where they are used once and not deformed. Parallel with TBB; the result does
// not depend on the number of threads. Reports Phase::build. Fails (render_failed) when cancelled.
[[nodiscard]] Result<std::unique_ptr<const World>> build_world(Scene scene, PosedScene posed,
                                                               const WorldOptions& options, const CancelToken* cancel,
                                                               ProgressListener* listener);

} // namespace kindling
