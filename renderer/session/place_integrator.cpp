// Opens devices, and makes integrators that run on them or on the CPU.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/place_integrator.h"

#include "renderer/device/failure_reason.h"
#include "renderer/device/make_device.h"
#include "renderer/device/scene_on_device.h"
#include "renderer/integrator/first_hits.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/manifolds/manifolds.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/stages/first_hit.h"
#include "renderer/integrator/whitted_shader.h"
#include "renderer/light/per_light_sampling.h"
#include "renderer/session/check_settings.h"
#include "renderer/world/light_groups/light_groups.h"

#include <utility>

namespace kindling {
namespace {

Result<std::unique_ptr<MeteredDevice>> open_checked(DeviceKind kind, const World& world, const RenderSettings& settings,
                                                    int threads, const DeviceNotice& notice) {
  if (const Result<void> checked = check_device_scene(world); !checked) return checked.error();
  Result<std::unique_ptr<Device>> device = open_device(kind, threads, notice);
  if (!device) return device.error();
  return std::make_unique<MeteredDevice>(std::move(device).value(), settings.device_memory_bytes);
}

PlacedIntegrator place_on_cpu(const World& world, const Camera& camera, const RenderSettings& settings,
                              const Guide* guide, std::string why_cpu) {
  PlacedIntegrator placed;
  placed.integrator =
      make_integrator(settings.integrator, world, camera, make_sampler(settings), settings.filter, settings.aovs, guide,
                      {settings.names.get(), settings.motion.get(), settings.catchers.get()});
  placed.use.why_cpu = std::move(why_cpu);
  return placed;
}

PlacedIntegrator place_on(std::unique_ptr<MeteredDevice> device, const World& world, const Camera& camera,
                          const RenderSettings& settings, const Guide* guide) {
  const Sampler sampler = make_sampler(settings);
  const PerLightSampling lights(world.light_set());
  PathStages stages = make_path_stages(settings.integrator, world, camera, sampler, guide);
  const std::unique_ptr<const LightPaths> light_paths =
      make_light_paths(settings.integrator, world, camera, settings.filter, sampler.seed());
  const LightPaths* const beside = light_paths.get();
  stages.light_paths = beside;
  // More than there may be are refused by check_light_groups().
  LightGroups groups;
  if (Result<LightGroups> found =
          make_light_groups(world, settings.integrator.light_groups, settings.integrator.background.has_value()))
    groups = std::move(found).value();
  const std::unique_ptr<const PresampledEnvironment> presampled =
      presample_environment(settings.integrator, world.lights, sampler.seed());
  stages.presampled = presampled.get();
  const std::unique_ptr<const Manifolds> manifolds = make_manifolds(settings.integrator, world);
  stages.manifolds = manifolds.get();
  const WhittedShader shader = make_whitted_shader(settings.integrator, world, camera, sampler, lights);
  const FirstHitStages first_hit = make_first_hit_stages(settings.integrator, world, camera, sampler);
  auto integrator = std::make_unique<DeviceIntegrator>(
      *device, settings.integrator,
      DeviceSceneInput{world, camera, stages, shader, first_hit, sampler, settings.filter, beside,
                       groups.view(world.surface_nodes())},
      WaveSetup{.aovs = settings.aovs,
                .light_groups = static_cast<uint32_t>(groups.names.size()),
                .trims_outliers = settings.outliers == Outliers::trim,
                .has_rates = settings.sample_rates != SampleRateKind::even,
                .manifolds = manifolds != nullptr,
                .light_paths = beside != nullptr ? settings.integrator.light_paths : 0.0f,
                .outside = beside != nullptr ? beside->outside : OutsidePixels{},
                .filter = settings.filter,
                .photons = beside != nullptr ? beside->photon_maps() : PhotonMapSizes{}},
      std::make_unique<const FirstHits>(world, camera, settings.filter, settings.aovs,
                                        AovInputs{settings.names.get(), settings.motion.get()}));
  PlacedIntegrator placed;
  placed.use.name = device->name();
  placed.use.scene_bytes = integrator->scene_bytes();
  placed.use.wave_paths = integrator->paths_together();
  placed.on_device = integrator.get();
  placed.device = std::move(device);
  placed.integrator = std::move(integrator);
  return placed;
}

} // namespace

Sampler make_sampler(const RenderSettings& settings) {
  return Sampler(settings.seed, settings.sampler, settings.planned(),
                 settings.sample_rates == SampleRateKind::noise ? SampleRates::kMaxLog2Ratio : 0);
}

Result<OpenedDevice> open_device(const World& world, const Camera& camera, const RenderSettings& settings, int threads,
                                 const DeviceNotice& notice) {
  if (settings.device == DeviceKind::cpu) return OpenedDevice{};
  if (settings.device != DeviceKind::automatic) {
    Result<std::unique_ptr<MeteredDevice>> device = open_checked(settings.device, world, settings, threads, notice);
    if (!device) return device.error();
    return OpenedDevice{std::move(device).value(), {}};
  }
  RenderSettings on_gpu = settings;
  on_gpu.device = DeviceKind::gpu;
  if (const Result<void> checked = check_settings(on_gpu, camera); !checked)
    return OpenedDevice{nullptr, failure_reason(checked.error().message)};
  Result<std::unique_ptr<MeteredDevice>> device = open_checked(DeviceKind::gpu, world, settings, threads, notice);
  if (!device) return OpenedDevice{nullptr, failure_reason(device.error().message)};
  return OpenedDevice{std::move(device).value(), {}};
}

void PlacedIntegrator::count(DeviceUse& seen) const {
  if (on_device == nullptr) return;
  seen.peak_bytes = device->peak_bytes();
  seen.tiles = on_device->tile_statistics();
  seen.kernels = device->kernel_uses();
}

PlacedIntegrator place_integrator(OpenedDevice opened, const World& world, const Camera& camera,
                                  const RenderSettings& settings, const Guide* guide) {
  if (!opened.device) return place_on_cpu(world, camera, settings, guide, std::move(opened.why_cpu));
  try {
    return place_on(std::move(opened.device), world, camera, settings, guide);
  } catch (const DeviceError& error) {
    if (settings.device != DeviceKind::automatic) {
      if (!settings.device_memory_bytes) throw;
      throw DeviceError(std::string(error.what()) + " or a larger --device-memory");
    }
    return place_on_cpu(world, camera, settings, guide, failure_reason(error.what()));
  }
}

} // namespace kindling
