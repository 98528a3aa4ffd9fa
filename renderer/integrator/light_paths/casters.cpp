// Choice of caster materials by their factors, and spheres around their meshes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/casters.h"

#include <algorithm>
#include <span>

namespace kindling {

namespace {

// Faint reflections are left to paths from the camera.
constexpr float kMinCoat = 0.1f;

bool has_narrow_base(const ShadingMaterial& material) {
  // With a texture, specular-glossiness has no upper bound of its roughness.
  if (material.specular_glossiness && material.specular_color.present()) return false;
  return material.roughness_factor <= kMaxCasterRoughness &&
         (material.metallic_factor > 0.0f || material.specular_factor > 0.0f);
}

bool is_caster(const WorldView& world, const ShadingMaterial& material) {
  // Light passes thin walls in a straight line.
  if (material.unlit || material.thin_wall || material.alpha_mode == AlphaMode::blend) return false;
  if (has_narrow_base(material)) return true;
  if (material.layers == kNone) return false;
  const LayerMaterial& layers = world.layer_materials[static_cast<size_t>(material.layers)];
  return layers.clearcoat_factor >= kMinCoat && layers.clearcoat_roughness_factor <= kMaxCasterRoughness;
}

// Divides boxes at the middle of their longest extent until each group has one sphere.
void add_spheres(std::span<Box3f> boxes, size_t count, std::vector<EmissionTarget>& targets) {
  if (boxes.empty()) return;
  Box3f all, centers;
  for (const Box3f& box : boxes) {
    all.extendBy(box);
    centers.extendBy(box.center());
  }
  const V3f extent = centers.max - centers.min;
  if (count <= 1 || boxes.size() == 1 || !(max_component(extent) > 0.0f)) {
    targets.push_back({all.center(), std::max(0.5f * (all.max - all.min).length(), 1e-6f)});
    return;
  }
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto middle = boxes.begin() + static_cast<ptrdiff_t>(boxes.size() / 2);
  std::nth_element(boxes.begin(), middle, boxes.end(),
                   [axis](const Box3f& a, const Box3f& b) { return a.center()[axis] < b.center()[axis]; });
  const auto first = static_cast<size_t>(middle - boxes.begin());
  add_spheres(boxes.first(first), count / 2, targets);
  add_spheres(boxes.subspan(first), count - count / 2, targets);
}

// Bounds a mesh of an instance over the shutter: vertices and matrices move linearly between their
// keys, so that each point stays within the bounds of all pairs of them.
Box3f bounds_of(const GeometryView& geometry, std::span<const M44f> matrices) {
  Box3f box;
  // Triangles share most vertices, and some vertices have no triangle.
  std::vector<uint8_t> used(geometry.positions.size(), 0);
  for (const uint32_t vertex : geometry.indices) used[vertex] = 1;
  for (size_t key = 0; key <= geometry.later_positions.size(); ++key) {
    const std::span<const V3f> positions = key == 0 ? geometry.positions : geometry.later_positions[key - 1];
    for (const M44f& matrix : matrices)
      for (size_t vertex = 0; vertex < used.size(); ++vertex)
        if (used[vertex] != 0) box.extendBy(transform_point(matrix, positions[vertex]));
  }
  return box;
}

} // namespace

std::vector<uint8_t> find_caster_materials(const WorldView& world) {
  std::vector<uint8_t> casters;
  for (const ShadingMaterial& material : world.materials) casters.push_back(is_caster(world, material) ? 1 : 0);
  return casters;
}

std::vector<EmissionTarget> find_targets(const World& world, const std::vector<uint8_t>& casters) {
  const accel::BuildInput input = world.accelerator_input();
  std::vector<Box3f> boxes;
  for (size_t i = 0; i < input.instances.size(); ++i) {
    const accel::Instance& instance = input.instances[i];
    const accel::MeshGroup& group = input.groups[instance.group];
    for (uint32_t mesh = group.first_mesh; mesh < group.first_mesh + group.mesh_count; ++mesh) {
      const GeometryView& geometry = world.geometries[mesh];
      if (casters[geometry.material] == 0) continue;
      const Box3f box = bounds_of(geometry, instance.motion == accel::kNoId ? std::span(&instance.object_to_world, 1)
                                                                            : input.motions[instance.motion]);
      if (!box.isEmpty() && is_finite(box.min) && is_finite(box.max)) boxes.push_back(box);
    }
  }
  std::vector<EmissionTarget> targets;
  add_spheres(boxes, kMaxTargets, targets);
  return targets;
}

} // namespace kindling
