// What a render reads once and keeps for all of its images: the scene file, its textures, the environment.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/setup/load_environment.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/base/result.h"
#include "renderer/import/load_gltf.h"
#include "renderer/scene/member_values.h"
#include "renderer/scene/scene.h"
#include "renderer/texture/texture_memory.h"
#include "renderer/world/world_sequence.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace kindling::app {

struct RenderScene {
  std::optional<TextureMemory> texture_memory; // --texture-memory; outlives the worlds
  WorldSequence worlds;
  Scene scene;                    // as the file has it, with the variant and the lights that are asked for
  int root = kNone;               // into Scene::scenes: what is shown; kNone: the default
  int variant = kNone;            // into Scene::variants
  EnvironmentPointer environment; // null: none is asked for
  uint64_t content_hash = 0;
  uint64_t environment_hash = 0;         // of LoadedEnvironment
  std::optional<MemberValues> as_loaded; // of the scene; set by keep()
  double load_s = 0.0;
  ImportTimes import_times;           // the parts of it that follow each other
  EnvironmentTimes environment_times; // beside them

  // It will be posed more than once.
  void keep() { as_loaded.emplace(scene); }
  // Null without --texture-memory.
  [[nodiscard]] TextureMemory* textures() { return texture_memory ? &*texture_memory : nullptr; }
};

// What the options choose of a loaded scene. Fails (usage) if there is no such scene or variant.
[[nodiscard]] Result<void> choose_shown(RenderScene& scene, const RenderOptions& options);

// Reads, and choose_shown(). Reports Phase::load. Fails as load_gltf() and load_environment() do, and (usage) if the file has no such scene or variant.
[[nodiscard]] Result<std::unique_ptr<RenderScene>> load_render_scene(const RenderOptions& options,
                                                                     ProgressDisplay& display);

} // namespace kindling::app
