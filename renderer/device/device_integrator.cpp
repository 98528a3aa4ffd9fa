// Fills waves with samples of blocks, one wave after the other.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/device_integrator.h"

#include "renderer/device/first_hit_wave_runner.h"
#include "renderer/device/path_wave_runner.h"
#include "renderer/device/tree_wave_runner.h"

#include <array>
#include <cassert>

namespace kindling {

DeviceIntegrator::DeviceIntegrator(Device& device, const IntegratorSettings& settings, const DeviceSceneInput& input,
                                   AovSet aovs)
    : device_(device), settings_(settings), world_(input.world), aovs_(aovs), scene_(device, input) {
  switch (settings.kind) {
  case IntegratorKind::path: device.prepare(path_wave_kernels(world_.filters_hits)); break;
  case IntegratorKind::whitted: device.prepare(kTreeWaveKernels); break;
  default: device.prepare(kFirstHitWaveKernels);
  }
}

std::unique_ptr<ThreadContext> DeviceIntegrator::make_context() const {
  const bool with_surfaces = aovs_.needs_film_surface();
  switch (settings_.kind) {
  case IntegratorKind::path: return std::make_unique<PathWaveRunner>(device_, world_, scene_.address(), with_surfaces);
  case IntegratorKind::whitted:
    return std::make_unique<TreeWaveRunner>(device_, world_, scene_.address(), settings_.whitted, with_surfaces);
  default: return std::make_unique<FirstHitWaveRunner>(device_, world_, scene_.address());
  }
}

uint32_t DeviceIntegrator::render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                                        Film& film) const {
  std::array<BlockWork, 1> work{BlockWork{block, samples}};
  render_blocks(work, context, film);
  return work[0].added;
}

void DeviceIntegrator::render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const {
  assert(dynamic_cast<DeviceWave*>(&context));
  auto& wave = static_cast<DeviceWave&>(context);
  for (BlockWork& block : work) block.added = 0, block.rays = 0;
  size_t next = 0;
  uint32_t taken = 0; // samples of each pixel of that block, or levels
  while (next < work.size()) {
    while (next < work.size()) {
      const BlockWork& block = work[next];
      taken += wave.take(next, block.block, {block.samples.first + taken, block.samples.end}, block.rates);
      if (taken < block.samples.count()) break; // the wave is full
      ++next;
      taken = 0;
    }
    if (!wave.run(film)) return;
    wave.take_results(work, film);
  }
}

} // namespace kindling
