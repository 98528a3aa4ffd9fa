// Reads what is read once.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/render_scene.h"

#include "renderer/app/setup/choose.h"
#include "renderer/app/setup/light_sizes.h"
#include "renderer/import/load_gltf.h"

#include <tbb/task_group.h>

#include <chrono>
#include <utility>

namespace kindling::app {

Result<void> choose_shown(RenderScene& scene, const RenderOptions& options) {
  const Result<int> root = choose_scene(scene.scene, options.scene_name);
  if (!root.ok()) return root.error();
  scene.root = root.value();
  const Result<int> variant = show_variant(scene.scene, options.variant_name);
  if (!variant.ok()) return variant.error();
  scene.variant = variant.value();
  apply_light_options(options.lights, scene.scene);
  return {};
}

Result<std::unique_ptr<RenderScene>> load_render_scene(const RenderOptions& options, ProgressDisplay& display) {
  const auto start = std::chrono::steady_clock::now();
  auto loaded = std::make_unique<RenderScene>();
  display.start_phase(Phase::load);
  if (options.texture_memory_bytes) loaded->texture_memory.emplace(*options.texture_memory_bytes);
  ImportOptions import_options;
  import_options.texture_memory = loaded->textures();
  import_options.times = &loaded->import_times;
  std::optional<Result<LoadedEnvironment>> environment; // read at the same time
  tbb::task_group group;
  group.run([&] { environment.emplace(load_environment(options, &loaded->environment_times)); });
  Result<Scene> scene = load_gltf(options.scene_file, import_options, &display);
  group.wait();
  if (!scene.ok()) return scene.error();
  if (!environment->ok()) return environment->error();
  loaded->scene = std::move(scene).value();
  loaded->environment = environment->value().environment;
  loaded->environment_hash = environment->value().content_hash;
  loaded->content_hash = loaded->scene.content_hash;
  loaded->load_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  display.end_phase();
  if (Result<void> chosen = choose_shown(*loaded, options); !chosen.ok()) return chosen.error();
  return loaded;
}

} // namespace kindling::app
