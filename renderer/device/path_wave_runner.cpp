// Leads the paths of a wave through the kernels, bounce by bounce.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/path_wave_runner.h"

#include <array>
#include <utility>

namespace kindling {

PathWaveRunner::PathWaveRunner(Device& on, const World& world, const DeviceScene* scene, bool with_surfaces)
    : DeviceWave(on, world, with_surfaces), states_(on, capacity()), media_(on, capacity()), rays_(on, capacity()),
      shadow_rays_(on, capacity()), hits_(on, capacity()), active_(on, capacity()), next_(on, capacity()),
      queue_counts_(on, 1), shadow_records_(on, capacity()) {
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
    launch(Kernel::intersect, wave_, active);
    queue_counts_.clear(1);
    launch(Kernel::shade, wave_, active);
    std::array<QueueCounts, 1> counts;
    queue_counts_.download(counts);
    launch(Kernel::trace_shadow, wave_, counts[0].shadows);
    std::swap(wave_.active.paths, wave_.next.paths);
    active = counts[0].next;
  }
  launch(Kernel::finish_pixel, wave_, pixel_count());
  download_sums();
  return !abandoned();
}

} // namespace kindling
