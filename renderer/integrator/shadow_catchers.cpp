// Builds an accelerator of catchers and lamps.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/shadow_catchers.h"

#include <utility>

namespace kindling {

std::unique_ptr<const ShadowCatchers> ShadowCatchers::make(const World& world, CatcherFlags flags,
                                                           const WorldOptions& options, const CancelToken* cancel) {
  std::unique_ptr<ShadowCatchers> catchers(new ShadowCatchers(world, std::move(flags)));
  const accel::BuildInput whole = world.accelerator_input();
  const auto remains = [&](uint32_t mesh, uint32_t instance) {
    const ShadingMaterial& material = world.materials[world.geometries[mesh].material];
    return catchers->catches(mesh, static_cast<size_t>(world.node_of(mesh, instance))) ||
           (material.emissive && !material.emission.present());
  };
  // Numbers of meshes and instances are kept: what is left out has no triangles, or an empty group.
  std::vector<accel::TriangleMesh>& meshes = catchers->meshes_;
  std::vector<accel::MeshGroup>& groups = catchers->groups_;
  meshes.assign(whole.meshes.begin(), whole.meshes.end());
  for (accel::TriangleMesh& mesh : meshes) mesh.persistent_id = 0;
  groups.assign(whole.groups.begin(), whole.groups.end());
  const auto empty_group = static_cast<uint32_t>(groups.size());
  std::vector<uint8_t> needed(meshes.size(), 0); // in some instance; the others of that instance's group stay, too
  groups.push_back({0, 0});
  for (uint32_t i = 0; i < whole.instances.size(); ++i) {
    accel::Instance& instance = catchers->instances_.emplace_back(whole.instances[i]);
    const accel::MeshGroup group = groups[instance.group];
    bool any_remains = false;
    for (uint32_t mesh = group.first_mesh; mesh < group.first_mesh + group.mesh_count; ++mesh) {
      if (!remains(mesh, i)) continue;
      needed[mesh] = 1;
      any_remains = true;
    }
    if (!any_remains) instance.group = empty_group;
  }
  for (size_t mesh = 0; mesh < meshes.size(); ++mesh)
    if (needed[mesh] == 0) meshes[mesh].indices = {};
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
