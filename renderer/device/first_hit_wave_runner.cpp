// Computes the colors of a wave in one launch.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/first_hit_wave_runner.h"

namespace kindling {

uint64_t first_hit_wave_bytes(const WaveSetup& setup) {
  return common_wave_bytes(setup) + setup.paths * sizeof(SampleColor);
}

FirstHitWaveRunner::FirstHitWaveRunner(Device& on, const World& world, const DeviceScene* scene, const WaveSetup& setup)
    : DeviceWave(on, world, setup, false), colors_(on, capacity()) {
  wave_.scene = scene;
  wave_.colors = colors_.data();
}

bool FirstHitWaveRunner::run(const Film& film) {
  start(film, wave_);
  launch_shading(Kernel::show_first_hit, wave_, sample_count());
  launch(Kernel::finish_first_hit_pixel, wave_, pixel_count());
  download_sums();
  return !abandoned();
}

} // namespace kindling
