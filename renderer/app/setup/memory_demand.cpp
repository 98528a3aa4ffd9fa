// Counts triangles, instances, textures and lights of a scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/memory_budget.h"

#include "accel/memory_estimate.h"
#include "accel/merged_instances.h"
#include "renderer/scene/describe.h"
#include "renderer/scene/material_slots.h"
#include "renderer/world/emitter_budget.h"
#include "renderer/world/opacity/alpha_classes.h"
#include "renderer/world/opacity/build_opacity.h"
#include "renderer/world/prepare_geometry.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

namespace kindling::app {

namespace {

// Counts over all primitives of a mesh.
struct MeshDemand {
  uint64_t triangles = 0, vertices = 0, bytes = 0, emissive_triangles = 0, cutout_triangles = 0;
};

uint64_t bytes_of(const Primitive& primitive) {
  uint64_t vertex = sizeof(V3f) + (primitive.normals.empty() ? 0 : sizeof(V3f)) +
                    (primitive.tangents.empty() ? 0 : sizeof(V4f)) + (primitive.colors.empty() ? 0 : sizeof(V4f));
  for (const std::vector<V2f>& set : primitive.texcoords) vertex += set.empty() ? 0 : sizeof(V2f);
  return primitive.positions.size() * vertex + primitive.indices.size() * sizeof(uint32_t);
}

uint64_t bytes_of(const std::vector<PosedMesh::Deformed>& deformed) {
  uint64_t bytes = 0;
  for (const PosedMesh::Deformed& d : deformed)
    bytes += d.positions.size() * sizeof(V3f) + d.normals.size() * sizeof(V3f) + d.tangents.size() * sizeof(V4f);
  return bytes;
}

bool is_emissive(const Scene& scene, const Primitive& primitive) {
  if (primitive.material == kNone) return false;
  const Material& material = scene.materials[static_cast<size_t>(primitive.material)];
  return material.alpha_mode == AlphaMode::opaque && !is_black(material.emissive_factor * material.emissive_strength);
}

// True if a texture may cut parts of the surfaces out.
bool has_cutouts(const Material& material) {
  return material.alpha_mode != AlphaMode::opaque && material.base_color_texture.texture != kNone;
}

MeshDemand demand_of(const Scene& scene, const Mesh& mesh) {
  MeshDemand demand;
  for (const Primitive& primitive : mesh.primitives) {
    demand.triangles += primitive.triangle_count();
    demand.vertices += primitive.positions.size();
    demand.bytes += bytes_of(primitive);
    if (is_emissive(scene, primitive)) demand.emissive_triangles += primitive.triangle_count();
    if (primitive.material != kNone && has_cutouts(scene.materials[static_cast<size_t>(primitive.material)]))
      demand.cutout_triangles += primitive.triangle_count();
  }
  return demand;
}

// An image is held once; its levels once for each kind of use.
void count_textures(const Scene& scene, MemoryDemand& demand) {
  std::set<const Image*> images;
  for (const SceneTexture& texture : scene.textures) {
    const Image* image = texture.image.get();
    if (image == nullptr || !images.insert(image).second) continue;
    demand.texture_bytes += image->byte_count();
    demand.largest_image_bytes = std::max<uint64_t>(demand.largest_image_bytes, image->byte_count());
  }
  constexpr int kData = 0, kNormal = 1, kColor = 2, kCutout = 3;
  std::set<std::pair<const Image*, int>> uses;
  for (const Material& material : scene.materials) {
    const auto use = [&](const TextureSlot& slot, int kind) {
      if (slot.texture == kNone) return;
      const Image* image = scene.textures[static_cast<size_t>(slot.texture)].image.get();
      if (image != nullptr && uses.insert({image, kind}).second) demand.level_bytes += image->byte_count() / 3;
    };
    for (const TextureSlot* slot : texture_slots(material)) {
      const bool color = slot == &material.base_color_texture || slot == &material.emissive_texture ||
                         slot == &material.specular_color_texture || slot == &material.sheen_color_texture ||
                         slot == &material.diffuse_transmission_color_texture;
      const bool normal = slot == &material.normal_texture || slot == &material.clearcoat_normal_texture;
      const bool cutout = slot == &material.base_color_texture && material.alpha_mode != AlphaMode::opaque;
      use(*slot, cutout ? kCutout : color ? kColor : normal ? kNormal : kData);
    }
  }
}

// Returns the memory of opacity micromaps, while they are built.
uint64_t micromap_bytes(const Scene& scene, uint64_t triangles) {
  if (triangles == 0) return 0;
  uint64_t materials = 0, class_bytes = 0;
  for (const Material& material : scene.materials) {
    if (!has_cutouts(material)) continue;
    ++materials;
    const Image* image = scene.textures[static_cast<size_t>(material.base_color_texture.texture)].image.get();
    if (image != nullptr) class_bytes += AlphaClasses::bytes(image->width, image->height);
  }
  return OpacityMicromaps::max_bytes({triangles, materials, class_bytes});
}

// Counts what a device keeps in memory (device/tile_plan.h): level 0 of images that rays and light
// samples read on their way, all levels of those of procedural textures.
void count_unpaged_textures(const Scene& scene, MemoryDemand& demand) {
  std::set<const Image*> finest, whole;
  const auto image_of = [&](int texture) {
    return texture == kNone ? nullptr : scene.textures[static_cast<size_t>(texture)].image.get();
  };
  for (const Material& material : scene.materials) {
    uint64_t images = 0;
    const bool is_wall = material.transmission_factor > 0.0f && material.thickness_factor == 0.0f;
    for (const TextureSlot* slot : texture_slots(material)) {
      const Image* image = image_of(slot->texture);
      if (image == nullptr) continue;
      ++images;
      const bool covers = slot == &material.base_color_texture && material.alpha_mode != AlphaMode::opaque;
      if (covers || is_wall || slot == &material.emissive_texture) finest.insert(image);
    }
    demand.max_images_of_material = std::max(demand.max_images_of_material, images);
  }
  for (const ProceduralGraph& graph : scene.procedurals)
    for (const ProceduralNode& node : graph.nodes)
      for (const ProceduralInput& input : node.inputs)
        if (const Image* image = image_of(input.texture)) whole.insert(image);
  for (const Image* image : finest)
    if (!whole.contains(image)) demand.unpaged_texture_bytes += image->byte_count();
  for (const Image* image : whole) demand.unpaged_texture_bytes += 2 * image->byte_count(); // as color and as data
}

} // namespace

MemoryDemand memory_demand(const Scene& scene, const PosedScene& posed) {
  MemoryDemand demand;
  std::error_code none;
  const uint64_t size = std::filesystem::file_size(scene.source, none);
  const SceneStatistics statistics = describe(scene);
  demand.scene_bytes = statistics.geometry_bytes;
  demand.nodes = statistics.nodes;
  // A .gltf is text, with buffers beside it or within.
  if (!none) demand.file_bytes = scene.source.ends_with(".glb") ? size : 3 * size + demand.scene_bytes;
  for (const Node& node : scene.nodes) demand.gpu_instances += node.gpu_instances.size();
  demand.placed_meshes = posed.meshes.size();

  std::vector<MeshDemand> meshes;
  for (const Mesh& mesh : scene.meshes) {
    meshes.push_back(demand_of(scene, mesh));
    for (const Primitive& primitive : mesh.primitives)
      demand.largest_primitive_bytes = std::max(demand.largest_primitive_bytes, bytes_of(primitive));
  }
  uint64_t cutout_triangles = 0;
  const auto add = [&](const MeshDemand& mesh, uint64_t keys) { // for each instance after the first
    demand.triangles += mesh.triangles * (1 + keys);
    demand.vertices += mesh.vertices;
    demand.lone_vertices += accel::lone_vertices(mesh.vertices, mesh.triangles);
    demand.geometry_bytes += mesh.bytes * (1 + keys);
    cutout_triangles += mesh.cutout_triangles;
  };
  const BakeChoice choice = choose_baked(scene.meshes, posed);
  std::vector<uint64_t> instances(scene.meshes.size(), 0), merged(scene.meshes.size(), 0);
  accel::MergedInstances merged_instances(scene.meshes.size());
  for (const PosedMesh& mesh : posed.meshes) {
    const auto number = static_cast<size_t>(mesh.mesh);
    demand.deformed_bytes += bytes_of(mesh.deformed);
    for (const auto& key : mesh.later_deformed) demand.deformed_bytes += bytes_of(key);
    if (!mesh.later_transforms.empty()) demand.instance_keys += 1 + mesh.later_transforms.size();
    if (choice.is_baked(mesh) || !mesh.deformed.empty()) {
      add(meshes[number], mesh.later_deformed.size());
      demand.emissive_triangles += meshes[number].emissive_triangles;
      continue;
    }
    if (instances[number]++ == 0) add(meshes[number], 0);
    ++demand.instances;
    const bool static_identity = mesh.later_transforms.empty() && mesh.mesh_to_world == M44f();
    if (static_identity && merged_instances.take(static_cast<uint32_t>(number), meshes[number].triangles))
      ++merged[number];
  }
  // A mesh is in the world's structure once for each merged instance, and in its own if it has
  // others.
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (merged[m] == 0) continue;
    const uint64_t copies = merged[m] - (merged[m] == instances[m] ? 1 : 0);
    demand.copied_triangles += copies * meshes[m].triangles;
    demand.lone_vertices += copies * accel::lone_vertices(meshes[m].vertices, meshes[m].triangles);
  }
  uint64_t instanced_emitters = 0;
  for (size_t m = 0; m < meshes.size(); ++m) instanced_emitters += instances[m] * meshes[m].emissive_triangles;
  demand.emissive_triangles += std::min(instanced_emitters, kMaxSampledEmitters);

  demand.geometry_bytes += micromap_bytes(scene, cutout_triangles);
  count_textures(scene, demand);
  count_unpaged_textures(scene, demand);
  if (posed.image_light != kNone) {
    const auto& face = scene.image_lights[static_cast<size_t>(posed.image_light)].faces[0];
    const uint64_t side = face ? static_cast<uint64_t>(face->width) : 0;
    demand.light_texels = std::min<uint64_t>(8 * side * side, 8192ULL * 4096);
  }
  return demand;
}

} // namespace kindling::app
