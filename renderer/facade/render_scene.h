// The scene that one or more images are rendered from: file, environment, textures, and its Worlds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/facade/back_faces.h"
#include "renderer/facade/load_environment.h"
#include "renderer/facade/scene_light.h"
#include "renderer/facade/view_settings.h"
#include "renderer/import/load_gltf.h"
#include "renderer/scene/member_values.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_names.h"
#include "renderer/session/image_settings.h"
#include "renderer/texture/texture_memory.h"
#include "renderer/world/world_sequence.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kindling {

// Decisions of build_stage(), made once for all images with these views.
struct ViewDecisions {
  ViewSettings views;
  std::vector<PlacedCamera> cameras;    // decisive_views()
  std::optional<BackFaceCounts> backs;  // with Backfaces::automatic
  std::optional<SceneLight> light;      // if nothing but emissive surfaces lights the scene
  std::optional<double> exposure_stops; // if RenderScene::shares_exposure and animations change the scene
};

struct RenderScene {
  WorldSettings settings;
  std::optional<TextureMemory> texture_memory; // with WorldSettings::texture_memory_bytes; outlives the worlds
  WorldSequence worlds;
  // The World of the last stage, and the pose that it shows; null before the first.
  const World* world = nullptr;
  std::optional<double> world_time_s;
  std::optional<Shutter> world_shutter;
  Scene scene;                                // as loaded, with the variant and the sizes of lights that are asked for
  std::vector<std::filesystem::path> files;   // that the scene consists of; none for a scene in memory
  std::string source;                         // Scene::source, which remains when the scene is consumed
  int root = kNone;                           // into Scene::scenes; kNone: the default scene
  int variant = kNone;                        // into Scene::variants
  EnvironmentPointer environment;             // null if none is asked for
  uint64_t content_hash = 0;                  // Scene::content_hash
  uint64_t environment_hash = 0;              // LoadedEnvironment::content_hash
  std::shared_ptr<const SurfaceNames> names;  // set by build_stage() if mattes are wanted; else null
  std::optional<MemberValues> as_loaded;      // set by keep()
  const std::atomic<bool>* abandon = nullptr; // WorldOptions::abandon of its Worlds
  decltype(WorldOptions::wrap_accelerator) wrap_accelerator; // of its Worlds; may be null
  size_t outlines_hidden = 0;                                // primitives that choose_shown() removed
  bool strokes_sized = false;                                // points and lines have their width
  // Start of the path that ImageSettings::own_camera follows: the images of the path share the
  // decisions made with it. Unset: each own camera decides for itself.
  std::optional<PlacedCamera> path_start;
  std::optional<V3f> center;              // of the bounds at rest; for CameraTurn
  bool keeps_decisions = false;           // `decisions` hold for images with other views, too
  bool shares_exposure = false;           // frames of an animation: ViewDecisions::exposure_stops is wanted
  std::optional<ViewDecisions> decisions; // of the last build_stage()
  double load_s = 0.0;
  ImportTimes import_times;           // phases of load_s, one after the other
  EnvironmentTimes environment_times; // in parallel with these

  // Must be called before the first pose if there will be more than one.
  void keep() { as_loaded.emplace(scene); }
  // Null without a bound on the memory for textures.
  [[nodiscard]] TextureMemory* textures() { return texture_memory ? &*texture_memory : nullptr; }
};

// Applies the settings that choose from a loaded scene: scene, variant, outlines, sizes of lights.
// Sets RenderScene::settings and source. Fails (usage) if there is no such scene or variant.
[[nodiscard]] Result<void> choose_shown(RenderScene& scene, const WorldSettings& settings);

// Loads a file and its environment in parallel, then calls choose_shown(). Reports Phase::load to
// the listener, which may be null. Fails as load_scene(), load_environment() and choose_shown() do;
// an error of the scene comes first.
[[nodiscard]] Result<std::unique_ptr<RenderScene>>
load_render_scene(const std::filesystem::path& file, const WorldSettings& settings, ProgressListener* listener);

// The same for a scene in memory.
[[nodiscard]] Result<std::unique_ptr<RenderScene>> take_render_scene(Scene scene, const WorldSettings& settings);

} // namespace kindling
