// Reads a file by its extension, and makes a scene of its mesh.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/polygons/load_polygons.h"

#include "renderer/import/files/file_bytes.h"
#include "renderer/import/polygons/read_obj.h"
#include "renderer/import/polygons/read_ply.h"
#include "renderer/import/polygons/read_stl.h"

#include <cctype>

namespace kindling::polygons {

namespace {

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

Material default_material(bool colored) {
  Material material;
  material.name = "default";
  const float gray = colored ? 1.0f : 0.7f;
  material.base_color_factor = {gray, gray, gray, 1.0f};
  material.metallic_factor = 0.0f;
  material.roughness_factor = 0.6f;
  material.double_sided = true;
  return material;
}

} // namespace

bool is_polygon_file(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  return extension == ".ply" || extension == ".obj" || extension == ".stl";
}

Scene load_polygons(const std::filesystem::path& path, const ImportLimits& limits, gltf::Warnings& warnings) {
  const auto file = gltf::read_file(path, limits.max_file_bytes);
  if (!file) gltf::fail("", file.error().message, "", ErrorKind::input_output);
  if (file.value().size() == 0) gltf::fail("", "the file is empty");
  PolygonBuilder builder(limits, warnings);
  const std::string extension = extension_of(path);
  if (extension == ".ply")
    read_ply(file.value().span(), builder);
  else if (extension == ".obj")
    read_obj(file.value().span(), warnings, builder);
  else
    read_stl(file.value().span(), builder);

  Scene scene;
  scene.source = path.string();
  scene.content_hash = gltf::hash_content(file.value().span());
  Primitive primitive = builder.finish();
  scene.materials.push_back(default_material(!primitive.colors.empty()));
  primitive.material = 0;
  const std::string name = path.stem().string();
  Mesh& mesh = scene.meshes.emplace_back();
  mesh.name = name;
  mesh.primitives.push_back(std::move(primitive));
  Node& node = scene.nodes.emplace_back();
  node.name = name;
  node.mesh = 0;
  scene.scenes.push_back({name, {0}});
  scene.default_scene = 0;
  return scene;
}

} // namespace kindling::polygons
