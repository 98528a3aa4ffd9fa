// Leads the nodes of a wave's trees through the kernels, the newest first.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/tree_wave_runner.h"

#include <algorithm>
#include <array>
#include <string>

namespace kindling {
namespace {

// A node has at most one child straight on, and for each of base, coat, reflection and refraction
// of glass one, or n x n where they are split.
uint32_t max_children(const WhittedSettings& settings) {
  return 1U + 4U * static_cast<uint32_t>(settings.glossy_strata * settings.glossy_strata);
}

// With the newest node first, a tree of this many levels below one another waits with at most the
// children of each level. Chains of partly transparent surfaces are longer, and rare: where one
// needs more, the render ends with a message.
uint32_t reserve_for(const WhittedSettings& settings) {
  return max_children(settings) * static_cast<uint32_t>(settings.trace_depth + 8);
}

} // namespace

uint64_t tree_wave_bytes(const WaveSetup& setup, const WhittedSettings& settings) {
  const uint64_t of_sample = sizeof(WhittedSample) + (setup.aovs.needs_film_surface() ? sizeof(WhittedComponents) : 0) +
                             3 * sizeof(WhittedNode);
  return common_wave_bytes(setup) + setup.paths * of_sample + reserve_for(settings) * sizeof(WhittedNode) +
         sizeof(uint32_t);
}

TreeWaveRunner::TreeWaveRunner(Device& on, const World& world, const DeviceScene* scene,
                               const WhittedSettings& settings, const WaveSetup& setup)
    : DeviceWave(on, world, setup, setup.aovs.needs_film_surface()), max_children_(max_children(settings)),
      reserve_(reserve_for(settings)), sums_(on, capacity()),
      components_(on, setup.aovs.needs_film_surface() ? capacity() : 0),
      waiting_(on, size_t{capacity()} * 2 + reserve_), nodes_(on, capacity()), waiting_count_(on, 1) {
  wave_.scene = scene;
  wave_.sums = sums_.data();
  wave_.components = components_.data();
  wave_.waiting = waiting_.data();
  wave_.waiting_count = waiting_count_.data();
  wave_.nodes = nodes_.data();
}

// All children of a round must find places. Those of the reserve are left to rounds of one node.
uint32_t TreeWaveRunner::round_size(uint32_t waiting) const {
  const auto places = static_cast<uint32_t>(waiting_.size()) - waiting;
  const uint32_t shared = places > reserve_ ? places - reserve_ : 0;
  return std::max(1U, std::min({waiting, capacity(), shared / max_children_}));
}

bool TreeWaveRunner::run(const Film& film) {
  start(film, wave_);
  launch(Kernel::begin_tree, wave_, sample_count());
  for (uint32_t waiting = sample_count(); waiting > 0;) {
    if (abandoned()) return false;
    const uint32_t count = round_size(waiting);
    wave_.first_taken = waiting - count;
    if (waiting_.size() - wave_.first_taken < size_t{count} * max_children_)
      throw DeviceError(device().name() + ": a ray tree has more than " + std::to_string(waiting_.size()) +
                        " nodes in work; use a smaller --trace-depth or --glossy-strata, or --device cpu");
    launch(Kernel::take_node, wave_, count);
    waiting_count_.upload(std::array{wave_.first_taken});
    launch_shading(Kernel::trace_node, wave_, count);
    if (abandoned()) return false; // with nodes that wait for tiles
    std::array<uint32_t, 1> now;
    waiting_count_.download(now);
    waiting = now[0];
  }
  launch(Kernel::finish_tree_pixel, wave_, pixel_count());
  download_sums();
  return !abandoned();
}

} // namespace kindling
