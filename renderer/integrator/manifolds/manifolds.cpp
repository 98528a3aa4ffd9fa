// Lists of lamps without a size, and spheres around glass.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/manifolds/manifolds.h"

#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/integrator/light_paths/casters.h"

namespace kindling {

namespace {

// By material: 1 for solid glass that may be smooth somewhere.
std::vector<uint8_t> find_glass(const WorldView& world) {
  std::vector<uint8_t> glass;
  for (const ShadingMaterial& material : world.materials) {
    const bool solid = !material.unlit && !material.thin_wall && material.layers != kNone &&
                       world.layer_materials[static_cast<size_t>(material.layers)].volume;
    const bool smooth = material.roughness_factor <= kStraightRoughness || material.metallic_roughness.present();
    glass.push_back(solid && smooth ? 1 : 0);
  }
  return glass;
}

} // namespace

Manifolds::Manifolds(const World& world) : all_targets_(find_targets(world, find_glass(world))) {
  const LightSetView& lights = world.lights;
  for (uint32_t i = 0; i < lights.punctuals.size(); ++i)
    if (lights.punctuals[i].radius == 0.0f && lights.punctuals[i].luminance > 0.0f) all_lamps_.push_back(i);
  targets = all_targets_;
  lamps = all_lamps_;
}

std::unique_ptr<const Manifolds> make_manifolds(const IntegratorSettings& settings, const World& world) {
  if (settings.manifold_samples == 0) return nullptr;
  auto manifolds = std::make_unique<const Manifolds>(world);
  return manifolds->targets.empty() || manifolds->lamps.empty() ? nullptr : std::move(manifolds);
}

} // namespace kindling
