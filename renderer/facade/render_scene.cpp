// Loads scene and environment in parallel.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/render_scene.h"

#include "renderer/facade/choose.h"
#include "renderer/facade/light_sizes.h"
#include "renderer/import/load_scene.h"
#include "renderer/scene/strokes.h"

#include <tbb/task_group.h>

#include <utility>

namespace kindling {

namespace {

void set_environment(RenderScene& scene, const LoadedEnvironment& loaded) {
  scene.environment = loaded.environment;
  scene.environment_hash = loaded.content_hash;
}

} // namespace

Result<void> choose_shown(RenderScene& scene, const WorldSettings& settings) {
  scene.settings = settings;
  scene.source = scene.scene.source;
  const Result<int> root = choose_scene(scene.scene, settings.scene_name);
  if (!root.ok()) return root.error();
  scene.root = root.value();
  const Result<int> variant = show_variant(scene.scene, settings.variant_name);
  if (!variant.ok()) return variant.error();
  scene.variant = variant.value();
  if (!settings.outlines) scene.outlines_hidden = remove_outlines(scene.scene);
  apply_light_options(settings.lights, scene.scene);
  return {};
}

Result<std::unique_ptr<RenderScene>> load_render_scene(const std::filesystem::path& file, const WorldSettings& settings,
                                                       ProgressListener* listener) {
  const Stopwatch clock;
  auto loaded = std::make_unique<RenderScene>();
  if (settings.texture_memory_bytes) loaded->texture_memory.emplace(*settings.texture_memory_bytes);
  ImportOptions import_options;
  import_options.texture_memory = loaded->textures();
  import_options.times = &loaded->import_times;
  import_options.files = &loaded->files;
  import_options.limits.follow_links = settings.follow_links;
  std::optional<Result<LoadedEnvironment>> environment;
  tbb::task_group group;
  group.run([&] { environment.emplace(load_environment(settings, &loaded->environment_times)); });
  Result<Scene> scene = load_scene(file, import_options, listener);
  group.wait();
  if (!scene.ok()) return scene.error();
  if (!environment->ok()) return environment->error();
  loaded->scene = std::move(scene).value();
  loaded->content_hash = loaded->scene.content_hash;
  set_environment(*loaded, environment->value());
  loaded->load_s = clock.elapsed().wall_s;
  if (Result<void> chosen = choose_shown(*loaded, settings); !chosen.ok()) return chosen.error();
  return loaded;
}

Result<std::unique_ptr<RenderScene>> take_render_scene(Scene scene, const WorldSettings& settings) {
  const Stopwatch clock;
  auto taken = std::make_unique<RenderScene>();
  const Result<LoadedEnvironment> environment = load_environment(settings, &taken->environment_times);
  if (!environment.ok()) return environment.error();
  taken->scene = std::move(scene);
  taken->content_hash = taken->scene.content_hash;
  set_environment(*taken, environment.value());
  taken->load_s = clock.elapsed().wall_s;
  if (Result<void> chosen = choose_shown(*taken, settings); !chosen.ok()) return chosen.error();
  return taken;
}

} // namespace kindling
