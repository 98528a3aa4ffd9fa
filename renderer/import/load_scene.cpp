// Chooses the reader of a scene file.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/load_scene.h"

#include "renderer/import/guarded.h"
#include "renderer/import/open_document.h"
#include "renderer/import/polygons/load_polygons.h"

namespace kindling {

Result<Scene> load_scene(const std::filesystem::path& path, const ImportOptions& options, ProgressListener* listener) {
  if (!polygons::is_polygon_file(path)) return load_gltf(path, options, listener);
  gltf::Warnings warnings(options.strict);
  return gltf::guarded<Scene>(path, [&] {
    const auto progress = [&](double done) {
      if (listener != nullptr) listener->on_progress({.phase = Phase::load, .done = done, .total = 1.0});
    };
    progress(0.0);
    const Stopwatch clock;
    Scene scene = polygons::load_polygons(path, options.limits, warnings);
    if (options.times != nullptr)
      *options.times = {.files = {}, .meshes = clock.elapsed(), .tangents = {}, .textures = {}};
    if (options.files != nullptr) *options.files = {path};
    progress(1.0);
    warnings.send(path.string(), listener);
    return scene;
  });
}

Result<std::vector<std::filesystem::path>> list_scene_files(const std::filesystem::path& path,
                                                            const ImportLimits& limits) {
  using Files = std::vector<std::filesystem::path>;
  return gltf::guarded<Files>(path, [&] {
    Files files;
    if (!polygons::is_polygon_file(path)) files = gltf::list_files(path, limits);
    files.insert(files.begin(), path);
    return files;
  });
}

} // namespace kindling
