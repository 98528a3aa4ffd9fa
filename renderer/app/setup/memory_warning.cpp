// Fills in the request for the memory budget of one image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/memory_warning.h"

#include "renderer/app/setup/available_memory.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/integrator/light_paths/casters.h"
#include "renderer/integrator/pilots/direct_sample_pilot.h"
#include "renderer/session/prepare/choose_light_paths.h"
#include "renderer/session/prepare/choose_photons.h"
#include "renderer/world/light_groups/light_groups.h"

#include <tbb/task_arena.h>

#include <algorithm>

namespace kindling::app {

void add_environment(const Environment* environment, MemoryRequest& request) {
  if (environment != nullptr) request.environment_texels = environment->memory_bytes() / MemoryCosts::kEnvironmentTexel;
}

namespace {

// Returns how many groups make_light_groups() can find at most.
size_t max_light_groups(LightGrouping grouping, const Scene& scene, const PosedScene& posed) {
  constexpr size_t kKinds = 4;
  if (grouping == LightGrouping::off) return 0;
  if (grouping == LightGrouping::kind) return kKinds;
  const auto shining = std::count_if(scene.materials.begin(), scene.materials.end(), [](const Material& material) {
    return material.unlit || !is_black(material.emissive_factor);
  });
  const auto nodes =
      std::count_if(scene.nodes.begin(), scene.nodes.end(), [](const Node& node) { return !node.light_group.empty(); });
  constexpr size_t kEnvironmentAndRest = 2;
  return std::min(kMaxLightGroups, posed.lights.size() + static_cast<size_t>(shining + nodes) + kEnvironmentAndRest);
}

// True if light paths may be chosen for the sake of a material: find_caster_materials() finds no
// other.
bool may_cast(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& material) {
    return material.roughness_factor <= kMaxCasterRoughness ||
           (material.clearcoat_factor > 0.0f && material.clearcoat_roughness_factor <= kMaxCasterRoughness);
  });
}

} // namespace

void add_parts_of_light(const RenderOptions& options, const Scene& scene, const PosedScene& posed,
                        MemoryRequest& request) {
  request.light_groups = max_light_groups(options.integrator.light_groups, scene, posed);
  request.light_paths = options.integrator.light_paths > 0.0f || (options.chooses_light_paths && may_cast(scene));
  request.photons = options.integrator.photons;
  if (options.chooses_photons && options.integrator.photons == 0.0f && may_cast(scene))
    request.photons = max_chosen_photons(request.size_px);
}

std::optional<std::string> warn_of_render_memory(const RenderScene& scene, const PosedImage& image,
                                                 const RenderOptions& options) {
  MemoryRequest request;
  request.size_px = options.crop ? options.crop->max - options.crop->min : image.size_px;
  request.aovs = options.recorded_aovs();
  request.trims_outliers = options.outliers == Outliers::trim;
  IntegratorSettings chosen = options.integrator;
  if (options.chooses_direct_samples) chosen.direct_samples = kMaxChosenDirectSamples;
  if (options.chooses_reflection_samples) chosen.reflection_samples = kMaxReflectionSamples;
  request.max_shadow_rays = chosen.max_shadow_rays();
  request.path_reuse =
      options.chooses_path_reuse ? kMaxPathReuse : static_cast<uint32_t>(options.integrator.path_reuse);
  add_parts_of_light(options, scene.scene, image.posed, request);
  // Whatever the camera is: one that light paths do not work with is rare.
  const RenderSettings settings = to_render_settings(options, image.size_px);
  const Camera camera(SceneCamera{}, M44f(), image.size_px);
  if (leaves_light_paths_open(settings) && !why_no_light_paths(settings, camera).empty()) request.light_paths = false;
  if (leaves_photons_open(settings) && !why_no_photons(settings, camera).empty()) request.photons = 0.0f;
  request.denoising = options.denoising_of_images();
  request.threads = tbb::this_task_arena::max_concurrency();
  request.texture_memory_bytes = options.texture_memory_bytes;
  add_environment(scene.environment.get(), request);
  const MemoryBudget budget = memory_budget(memory_demand(scene.scene, image.posed), request);
  return warn_of_memory(budget, options.accelerator, resident_bytes(), available_memory_bytes());
}

} // namespace kindling::app
