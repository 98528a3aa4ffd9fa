// Leads the paths of a wave through the kernels, bounce by bounce.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/path_wave_runner.h"

#include <array>
#include <utility>

namespace kindling {

uint64_t path_wave_bytes(const WaveSetup& setup) {
  constexpr uint64_t kOfPath =
      sizeof(PathState) + sizeof(MediumStack) + sizeof(accel::Ray) + sizeof(accel::Hit) + 2 * sizeof(uint32_t);
  constexpr uint64_t kOfShadowRay = sizeof(accel::Ray) + sizeof(WaveShadow);
  return common_wave_bytes(setup) + setup.paths * (kOfPath + setup.direct_samples * kOfShadowRay) + sizeof(uint64_t);
}

std::vector<Kernel> path_wave_kernels(bool filters_hits) {
  if (filters_hits)
    return {Kernel::begin_path, Kernel::intersect, Kernel::shade, Kernel::trace_shadow, Kernel::finish_pixel};
  return {Kernel::begin_path, Kernel::intersect_opaque, Kernel::shade, Kernel::trace_shadow_opaque,
          Kernel::finish_pixel};
}

PathWaveRunner::PathWaveRunner(Device& on, const World& world, const DeviceScene* scene, const WaveSetup& setup)
    : DeviceWave(on, world, setup, setup.aovs.needs_film_surface()), filters_hits_(world.filters_hits),
      states_(on, capacity()), media_(on, capacity()), rays_(on, capacity()),
      shadow_rays_(on, capacity() * setup.direct_samples), hits_(on, capacity()), active_(on, capacity()),
      next_(on, capacity()), queue_counts_(on, 1), shadow_records_(on, capacity() * setup.direct_samples) {
  QueueCounts* const counts = queue_counts_.data();
  wave_.scene = scene;
  wave_.states = states_.data();
  wave_.media = media_.data();
  wave_.path_rays = rays_.data();
  wave_.hits = hits_.data();
  wave_.active.paths = active_.data();
  wave_.next = {&counts->next, next_.data()};
  wave_.shadows.count = &counts->shadows;
  wave_.shadow_rays = shadow_rays_.data();
  wave_.shadow_records = shadow_records_.data();
}

bool PathWaveRunner::run(const Film& film) {
  start(film, wave_);
  launch(Kernel::begin_path, wave_, sample_count());
  for (uint32_t active = sample_count(); active > 0;) {
    if (abandoned()) return false;
    launch(filters_hits_ ? Kernel::intersect : Kernel::intersect_opaque, wave_, active);
    queue_counts_.clear(1);
    launch_shading(Kernel::shade, wave_, active);
    std::array<QueueCounts, 1> counts;
    queue_counts_.download(counts);
    launch(filters_hits_ ? Kernel::trace_shadow : Kernel::trace_shadow_opaque, wave_, counts[0].shadows);
    std::swap(wave_.active.paths, wave_.next.paths);
    active = counts[0].next;
  }
  launch(Kernel::finish_pixel, wave_, pixel_count());
  download_sums();
  return !abandoned();
}

} // namespace kindling
