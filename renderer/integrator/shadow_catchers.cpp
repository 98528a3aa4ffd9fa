// Builds an accelerator of catchers and lamps.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/shadow_catchers.h"

#include <utility>

namespace kindling {

std::unique_ptr<const ShadowCatchers> ShadowCatchers::make(const World& world, std::vector<uint8_t> nodes,
                                                           const WorldOptions& options, const CancelToken* cancel) {
  std::unique_ptr<ShadowCatchers> catchers(new ShadowCatchers(world, std::move(nodes)));
  const accel::BuildInput whole = world.accelerator_input();
  const auto remains = [&](uint32_t mesh, uint32_t instance) {
    const ShadingMaterial& material = world.materials[world.geometries[mesh].material];
    return catchers->nodes_[static_cast<size_t>(world.node_of(mesh, instance))] != 0 ||
           (material.emissive && !material.emission.present());
  };
  // Numbers of meshes and instances are kept: what is left out has no triangles, or an empty group.
  std::vector<accel::TriangleMesh>& meshes = catchers->meshes_;
  std::vector<accel::MeshGroup>& groups = catchers->groups_;
  meshes.assign(whole.meshes.begin(), whole.meshes.end());
  for (accel::TriangleMesh& mesh : meshes) mesh.persistent_id = 0;
  groups.assign(whole.groups.begin(), whole.groups.end());
  const auto empty_group = static_cast<uint32_t>(groups.size());
  std::vector<uint32_t> uses(groups.size(), 0);
  for (uint32_t i = 0; i < whole.instances.size(); ++i) ++uses[whole.instances[i].group];
  groups.push_back({0, 0});
  for (uint32_t i = 0; i < whole.instances.size(); ++i) {
    accel::Instance& instance = catchers->instances_.emplace_back(whole.instances[i]);
    const accel::MeshGroup group = groups[instance.group];
    uint32_t remaining = 0;
    for (uint32_t mesh = group.first_mesh; mesh < group.first_mesh + group.mesh_count; ++mesh)
      remaining += remains(mesh, i) ? 1 : 0;
    if (remaining == 0) {
      instance.group = empty_group;
    } else if (uses[instance.group] == 1) { // baked meshes; a lamp of several copies remains as a whole
      for (uint32_t mesh = group.first_mesh; mesh < group.first_mesh + group.mesh_count; ++mesh)
        if (!remains(mesh, i)) meshes[mesh].indices = {};
    }
  }
  accel::BuildOptions build;
  build.quality = options.quality;
  build.robust = options.robust;
  build.simd = options.simd;
  if (cancel) build.cancel = &cancel->cancel_flag();
  catchers->accelerator_ = accel::make_accelerator(
      options.accelerator, {meshes, groups, accel::InstanceList(catchers->instances_), whole.motions, whole.filter},
      build);
  if (!catchers->accelerator_) return nullptr;
  return catchers;
}

} // namespace kindling
