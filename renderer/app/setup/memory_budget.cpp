// The model of the memory budget: the parts that each phase holds.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/memory_budget.h"

#include "accel/memory_estimate.h"
#include "renderer/app/text/text_format.h"
#include "renderer/denoise/denoiser.h"
#include "renderer/device/device_plan.h"
#include "renderer/device/path_wave_runner.h"
#include "renderer/film/film.h"
#include "renderer/integrator/photons/photon_maps.h"
#include "renderer/world/geometry.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

using Part = MemoryBudget::Part;
using Costs = MemoryCosts;

uint64_t film_bytes(const MemoryRequest& request) {
  Film one({1, 1}, {{0, 0}, {1, 1}}, request.aovs);
  one.split_by_light_groups(std::vector<std::string>(request.light_groups));
  if (request.trims_outliers) one.trim_outliers();
  if (request.light_paths) one.enable_splats();
  const uint64_t of_pixel = one.memory_bytes() + (request.aovs.has_mattes() ? Costs::kFurtherMattes : 0);
  return of_pixel * static_cast<uint64_t>(request.size_px.x) * static_cast<uint64_t>(request.size_px.y);
}

PhotonMapSizes photon_maps(const MemoryRequest& request) {
  if (request.photons == 0.0f) return {};
  const double pixels = static_cast<double>(request.size_px.x) * static_cast<double>(request.size_px.y);
  const auto paths = static_cast<uint64_t>(std::max(1.0, static_cast<double>(request.photons) * pixels));
  return PhotonMapSizes::of(paths);
}

uint64_t count_mattes(AovSet aovs) {
  return static_cast<uint64_t>(
      std::ranges::count_if(kMattes, [&](const MatteInfo& info) { return aovs.contains(info.matte); }));
}

// Memory held by textures, and extra memory while one is decoded.
struct TextureBytes {
  uint64_t held = 0, decoding = 0;
  bool paged = false;
};

TextureBytes texture_bytes(const MemoryDemand& demand, const MemoryRequest& request) {
  TextureBytes bytes{demand.texture_bytes + demand.level_bytes, demand.largest_image_bytes, false};
  if (!request.texture_memory_bytes || bytes.held <= *request.texture_memory_bytes) return bytes;
  // Levels are computed in memory for one image at a time.
  return {*request.texture_memory_bytes, 3 * demand.largest_image_bytes, true};
}

std::string times(uint64_t count, std::string_view what) { return fmt::format("{} {}", count, what); }

} // namespace

MemoryBudget memory_budget(const MemoryDemand& d, const MemoryRequest& request) {
  MemoryBudget budget;
  budget.request = request;
  const TextureBytes textures = texture_bytes(d, request);
  const uint64_t pixels = static_cast<uint64_t>(request.size_px.x) * static_cast<uint64_t>(request.size_px.y);
  const uint64_t texels = request.environment_texels + d.light_texels;
  const uint64_t program = Costs::kProgram + (textures.paged ? Costs::kImageLibrary : 0);
  const uint64_t threads = static_cast<uint64_t>(request.threads) * Costs::kThread;
  const uint64_t instances = (1 + d.instances) * sizeof(WorldInstance) + d.instance_keys * Costs::kInstanceKey;
  const uint64_t lights = d.emissive_triangles * Costs::kEmissiveTriangle;
  const uint64_t environment = texels * Costs::kEnvironmentTexel + (texels > 0 ? Costs::kPresampledEnvironment : 0);
  const uint64_t film = film_bytes(request);

  budget.parts = {Part{"program", program, textures.paged ? "with OpenImageIO" : ""},
                  Part{"threads", threads, times(static_cast<uint64_t>(request.threads), "threads")},
                  Part{"geometry", d.geometry_bytes, fmt::format("{} triangles, {} vertices", d.triangles, d.vertices)},
                  Part{"instances", instances, times(d.instances, "instances")},
                  Part{"textures", textures.held, textures.paged ? "--texture-memory" : "decoded, and their levels"},
                  Part{"lights", lights, times(d.emissive_triangles, "emissive triangles")},
                  Part{"environment", environment, times(texels, "texels")},
                  Part{"film", film,
                       fmt::format("{}x{}{}", request.size_px.x, request.size_px.y,
                                   request.aovs.has_mattes() ? ", four objects in each pixel" : "")},
                  Part{"guide", Costs::kGuide, "at most"},
                  Part{"photons", PhotonMaps::kMaxStored * photon_maps(request).bytes(), "of all maps"},
                  Part{"writing", pixels * (Costs::kPixelOfImage + count_mattes(request.aovs) * Costs::kPixelOfMatte),
                       "the image, resolved and encoded"},
                  Part{"denoising", denoise_memory_bytes(request.size_px, request.denoising),
                       fmt::format("Open Image Denoise, {}", denoising_name(request.denoising))}};

  // --- loading: the file, what is read of it, the images -----------------------------------------
  const uint64_t posing = d.placed_meshes * (sizeof(PosedMesh) + 8) + d.deformed_bytes;
  const uint64_t scene = d.scene_bytes + d.gpu_instances * sizeof(Transform);
  const uint64_t environment_loading = std::max(texels * Costs::kEnvironmentTexelInBuild, environment);
  const uint64_t reading = d.file_bytes + d.nodes * Costs::kNode + d.gpu_instances * 16 + d.largest_primitive_bytes;
  const uint64_t images = d.texture_bytes == 0 ? 0 : textures.held + textures.decoding;
  budget.loading = program + threads + environment_loading + scene + std::max(reading + images, images);

  // --- building: first vertices and instances of the posed scene, then lights, then the accelerato
  const uint64_t shared = program + threads + environment + textures.held;
  const uint64_t preparing = shared + textures.decoding + scene + posing + std::max(d.geometry_bytes, d.scene_bytes) -
                             d.scene_bytes + d.largest_primitive_bytes + instances;
  const uint64_t prepared = shared + d.geometry_bytes + instances;
  const uint64_t lighting = prepared + d.emissive_triangles * Costs::kEmissiveTriangleInBuild;

  const std::array<accel::Kind, 2> kinds{accel::Kind::kdtree, accel::Kind::embree};
  for (size_t i = 0; i < kinds.size(); ++i) {
    MemoryBudget::OfAccelerator& of = budget.accelerators[i];
    const accel::MemoryEstimate estimate =
        accel::estimate_memory(kinds[i], d.triangles + d.copied_triangles, d.instances, d.lone_vertices);
    of.kind = kinds[i];
    of.held = estimate.held;
    of.building = estimate.building;
    of.rendering = estimate.held;
    for (const Part& part : budget.parts) of.rendering += part.bytes;
    const uint64_t building = std::max({preparing, lighting, prepared + lights + estimate.building});
    of.peak = std::max({budget.loading, building, of.rendering});
    of.peak_phase = of.peak == of.rendering ? "rendering" : of.peak == building ? "building" : "loading";
  }
  const uint64_t texels_of_images = d.texture_bytes + d.level_bytes;
  const uint64_t untextured =
      d.geometry_bytes + instances + lights + environment + Costs::kGuide + budget.of(accel::Kind::kdtree).held;
  const uint64_t tiles = 4 * d.max_images_of_material * kTileBytes + texels_of_images / Costs::kTexelsOfTableByte;
  WaveSetup waves{.aovs = request.aovs,
                  .light_groups = static_cast<uint32_t>(request.light_groups),
                  .max_shadow_rays = request.max_shadow_rays,
                  .path_reuse = request.path_reuse,
                  .trims_outliers = request.trims_outliers,
                  .light_paths = request.light_paths ? 1.0f : 0.0f,
                  .photons = photon_maps(request)};
  budget.on_device = {
      .scene = untextured + texels_of_images, .waves = path_wave_bytes(waves), .photons = waves.photons.bytes()};
  waves.paths = kMinWaveSize;
  budget.on_device.min = untextured + budget.on_device.photons +
                         std::min(d.unpaged_texture_bytes + tiles, texels_of_images) + path_wave_bytes(waves) +
                         Costs::kWaitingPath * kMinWaveSize;
  return budget;
}

std::string format_memory_budget(const MemoryBudget& budget) {
  TextTable parts({{"held by", false}, {"memory", true}, {"for"}});
  for (const Part& part : budget.parts)
    if (part.bytes > 0) parts.add({std::string(part.name), format_bytes(part.bytes), part.basis});
  TextTable accelerators(
      {{"accelerator"}, {"held", true}, {"in its build", true}, {"render holds", true}, {"peak", true}, {"while"}});
  for (const MemoryBudget::OfAccelerator& of : budget.accelerators)
    accelerators.add({std::string(accel::kind_name(of.kind)), format_bytes(of.held), format_bytes(of.building),
                      format_bytes(of.rendering), format_bytes(of.peak), std::string(of.peak_phase)});
  TextTable device({{"on a device"}, {"memory", true}, {"for"}});
  device.add({"scene", format_bytes(budget.on_device.scene), "all arrays that kernels read"});
  device.add({"waves", format_bytes(budget.on_device.waves), fmt::format("{} paths", kWaveSize)});
  if (budget.on_device.photons > 0)
    device.add({"photons", format_bytes(budget.on_device.photons), "of one map at a time"});
  device.add({"at least", format_bytes(budget.on_device.min),
              fmt::format("with paged textures and waves of {} paths", kMinWaveSize)});
  return fmt::format("\nmemory of a render, at most, with {} thread{} (loading: {})\n{}{}{}", budget.request.threads,
                     budget.request.threads == 1 ? "" : "s", format_bytes(budget.loading), parts.str(),
                     accelerators.str(), device.str());
}

std::optional<std::string> warn_of_memory(const MemoryBudget& budget, accel::Kind kind, uint64_t resident_bytes,
                                          std::optional<uint64_t> available) {
  const uint64_t peak = budget.of(kind).peak;
  if (!available || peak <= resident_bytes + *available) return std::nullopt;
  return fmt::format("the render may take {} of memory while {}, and {} are free; see 'kindling info' for the parts",
                     format_bytes(peak), budget.of(kind).peak_phase, format_bytes(resident_bytes + *available));
}

} // namespace kindling::app
