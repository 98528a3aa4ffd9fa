// The steps from a glTF file to a Scene, in order.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/load_gltf.h"

#include "renderer/import/guarded.h"
#include "renderer/import/lights/image_lights.h"
#include "renderer/import/lights/photometric_lights.h"
#include "renderer/import/materials/materials.h"
#include "renderer/import/materials/procedurals.h"
#include "renderer/import/materials/textures.h"
#include "renderer/import/materials/variant_mappings.h"
#include "renderer/import/meshes/meshes.h"
#include "renderer/import/nodes/animations.h"
#include "renderer/import/nodes/nodes.h"
#include "renderer/import/open_document.h"

#include <nlohmann/json.hpp>

#include <utility>

namespace kindling {
namespace gltf {
namespace {

void import_asset(const Document& document, Scene& scene) {
  const nlohmann::json& root = *document.json;
  scene.generator = document.core.asset.generator;
  scene.copyright = document.core.asset.copyright;
  if (root.contains("extensionsUsed")) scene.extensions_used = root["extensionsUsed"].get<std::vector<std::string>>();
  scene.variants = read_variant_names(document);
}

Scene import(const std::filesystem::path& path, const ImportOptions& options, ProgressListener* listener,
             Warnings& warnings) {
  const auto progress = [&](double done) {
    if (listener != nullptr) listener->on_progress({.phase = Phase::load, .done = done, .total = 1.0});
  };
  progress(0.0);
  ImportTimes times;
  Stopwatch clock;
  Document document = open_document(path, options.limits, warnings);
  times.files = clock.lap();
  progress(0.3);
  Scene scene;
  scene.source = path.string();
  import_asset(document, scene);
  import_samplers(document, scene, warnings);
  import_materials(document, scene, warnings);
  import_procedurals(document, scene, warnings);
  times.meshes = clock.lap();
  import_meshes(document, scene, warnings, times.tangents);
  times.meshes += clock.lap() - times.tangents;
  progress(0.9);
  import_cameras(document, scene, warnings);
  import_lights(document, scene, warnings);
  import_skins(document, scene, warnings);
  import_nodes(document, scene, warnings);
  import_image_lights(document, scene, warnings);
  import_photometric_lights(document, scene, warnings);
  import_animations(document, scene, warnings);
  times.meshes += clock.lap();
  progress(1.0);
  if (options.decode_textures) {
    import_images(document, scene, options.texture_memory, listener, warnings);
    import_image_light_faces(document, scene, warnings);
  }
  times.textures = clock.lap();
  if (options.times != nullptr) *options.times = times;
  if (options.files != nullptr) {
    *options.files = std::move(document.files);
    options.files->insert(options.files->begin(), path);
  }
  scene.content_hash = document.content_hash;
  return scene;
}

} // namespace
} // namespace gltf

Result<Scene> load_gltf(const std::filesystem::path& path, const ImportOptions& options, ProgressListener* listener) {
  gltf::Warnings warnings(options.strict);
  return gltf::guarded<Scene>(path, [&] {
    Scene scene = gltf::import(path, options, listener, warnings);
    warnings.send(path.string(), listener);
    return scene;
  });
}

} // namespace kindling
