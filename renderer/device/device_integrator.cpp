// Fills waves with samples of blocks, one wave after the other.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/device_integrator.h"

#include "renderer/device/device_plan.h"
#include "renderer/device/first_hit_wave_runner.h"
#include "renderer/device/path_wave_runner.h"
#include "renderer/device/tree_wave_runner.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace kindling {

DeviceIntegrator::DeviceIntegrator(Device& device, const IntegratorSettings& settings, const DeviceSceneInput& input,
                                   const WaveSetup& setup, std::unique_ptr<const FirstHits> first_hits)
    : device_(device), settings_(settings), world_(input.world), setup_(setup), first_hits_(std::move(first_hits)) {
  setup_.max_shadow_rays = settings.max_shadow_rays();
  setup_.path_reuse = static_cast<uint32_t>(settings.path_reuse);
  setup_.image_px = input.camera.size_px();
  setup_.first_hits = first_hits_.get();
  // With sample rates a wave knows the level of its first samples alone, which decides on their
  // map.
  const auto pixels = static_cast<uint64_t>(setup_.image_px.x) * static_cast<uint64_t>(setup_.image_px.y);
  const uint32_t maps = setup_.has_rates ? 1 : PhotonMapsOnDevice::filling(device.wave_size(), setup_.photons, pixels);
  DevicePlan plan = plan_device_memory(device, input, [this](uint32_t paths) { return wave_bytes(paths); },
                                       {.bytes = setup_.photons.bytes(), .together = maps});
  setup_.paths = plan.paths;
  setup_.photon_maps = plan.photon_maps;
  if (plan.tiles)
    pager_ = std::make_unique<TilePager>(device, world_.textures, std::move(*plan.tiles), plan.slots, plan.paths);
  setup_.pager = pager_.get();
  scene_.emplace(device, input, pager_.get());
  switch (settings.kind) {
  case IntegratorKind::path: device.prepare(path_wave_kernels(world_.filters_hits, setup_)); break;
  case IntegratorKind::whitted: device.prepare(kTreeWaveKernels); break;
  default: device.prepare(kFirstHitWaveKernels);
  }
}

uint64_t DeviceIntegrator::wave_bytes(uint32_t paths) const {
  WaveSetup setup = setup_;
  setup.paths = paths;
  switch (settings_.kind) {
  case IntegratorKind::path: return path_wave_bytes(setup);
  case IntegratorKind::whitted: return tree_wave_bytes(setup, settings_.whitted);
  default: return first_hit_wave_bytes(setup);
  }
}

std::unique_ptr<ThreadContext> DeviceIntegrator::make_context() const {
  const DeviceScene* const scene = scene_->address();
  switch (settings_.kind) {
  case IntegratorKind::path: return std::make_unique<PathWaveRunner>(device_, world_, scene, setup_);
  case IntegratorKind::whitted:
    return std::make_unique<TreeWaveRunner>(device_, world_, scene, settings_.whitted, setup_);
  default: return std::make_unique<FirstHitWaveRunner>(device_, world_, scene, setup_);
  }
}

uint32_t DeviceIntegrator::render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                                        Film& film) const {
  std::array<BlockWork, 1> work{BlockWork{block, samples}};
  render_blocks(work, context, film);
  return work[0].added;
}

// A pass needs no more photon maps than there is room for.
uint32_t DeviceIntegrator::samples_per_pass() const {
  return setup_.photons.empty() ? Integrator::samples_per_pass() : setup_.photon_maps * setup_.photons.samples;
}

void DeviceIntegrator::render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const {
  assert(dynamic_cast<DeviceWave*>(&context));
  auto& wave = static_cast<DeviceWave&>(context);
  SampleRange all = work.empty() ? SampleRange{} : work.front().samples;
  for (BlockWork& block : work) {
    block.added = 0, block.rays = 0;
    all = {std::min(all.first, block.samples.first), std::max(all.end, block.samples.end)};
  }
  while (!all.empty()) {
    uint32_t end = all.end;
    if (!setup_.photons.empty()) { // those of as many maps as there is room for
      const uint32_t per_map = setup_.photons.samples;
      end = std::min(end, (all.first / per_map + setup_.photon_maps) * per_map);
    }
    if (!render_samples(work, {all.first, end}, wave, film)) return;
    all.first = end;
  }
}

bool DeviceIntegrator::render_samples(std::span<BlockWork> work, const SampleRange& samples, DeviceWave& wave,
                                      Film& film) {
  const auto wanted = [&](const BlockWork& block) {
    const uint32_t first = std::max(samples.first, block.samples.first);
    return SampleRange{first, std::max(first, std::min(samples.end, block.samples.end))};
  };
  size_t next = 0;
  uint32_t taken = 0; // samples of each pixel of that block, or levels
  while (next < work.size()) {
    while (next < work.size()) {
      const BlockWork& block = work[next];
      const SampleRange of_block = wanted(block);
      taken += wave.take(next, block.block, {of_block.first + taken, of_block.end}, block.rates);
      if (taken < of_block.count()) break; // the wave is full
      ++next;
      taken = 0;
    }
    if (wave.empty()) break;
    if (!wave.run(film)) return false;
    wave.take_results(work, film);
  }
  return true;
}

} // namespace kindling
