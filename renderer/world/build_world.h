// Builds the World from a posed Scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/world/builtin_environment.h"
#include "renderer/world/world.h"

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

namespace kindling {

class TextureMemory;

struct WorldOptions {
  accel::Kind accelerator = accel::Kind::embree;
  accel::Quality quality = accel::Quality::balanced;
  bool robust = true;                    // for Embree
  std::optional<accel::SimdTarget> simd; // of the kd-tree's kernels; unset: the best that the processor supports
  std::shared_ptr<const Environment>
      environment; // null: the file's environment, or the built-in one if the scene has no lights
  // Minimum number of triangles in persistent meshes for a tree of their own (persistent_meshes.h);
  // images of more samples need more.
  size_t min_persistent_triangles = 100'000;
  uint64_t image_samples = 0;              // planned for the whole image: pixels times samples per pixel
  TextureMemory* texture_memory = nullptr; // used when the scene was loaded; must outlive the World; may be null
  // Polled by queries and integrators: once it is set, they drop the work in hand
  // (World::abandoned()). Null: never. Must outlive the World.
  const std::atomic<bool>* abandon = nullptr;
  bool hide_backs = false;             // WorldView::hides_backs
  std::optional<ViewPoint> view_point; // with it; unset: only rays of the camera pass through backs
  // The built-in environment. Automatic: it lights a scene without any light. Emissive surfaces
  // count as lights (is_lamp()); light_by_studio() can add it to a World that they alone light.
  Studio studio = Studio::automatic;
  // Called once with the accelerator; the result replaces it (such as a recorder of rays around
  // it). May be null.
  std::function<std::unique_ptr<accel::Accelerator>(std::unique_ptr<accel::Accelerator>)> wrap_accelerator;
};

// True if the material is meant to light a scene. Textured emission of strength 1 is a display or a
// glowing mark.
[[nodiscard]] bool is_lamp(const Material& material);

// Consumes the scene: vertex arrays that are used once and not deformed are moved. Parallel with
// TBB; the result does not depend on the number of threads. Reports Phase::build. Fails
// (render_failed) when cancelled.
[[nodiscard]] Result<std::unique_ptr<const World>> build_world(Scene scene, PosedScene posed,
                                                               const WorldOptions& options, const CancelToken* cancel,
                                                               ProgressListener* listener);

} // namespace kindling
