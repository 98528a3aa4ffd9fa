// Traces photon maps on the threads of an arena.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/photons/photon_source.h"

#include <utility>
#include <vector>

namespace kindling {

PhotonSource::PhotonSource(const PathStages& stages, std::unique_ptr<const LightPaths> light_paths, const World& world,
                           int threads, LightGroups groups)
    : stages_(stages), light_paths_(std::move(light_paths)), world_(world), groups_(std::move(groups)),
      groups_view_(groups_.view()), maps_(light_paths_->photon_paths_per_sample(), light_paths_->samples_per_map),
      arena_(threads) {}

PhotonMaps::Map PhotonSource::of_sample(uint32_t sample, RayCounters& counters) {
  const PhotonMaps::Trace trace = [&](uint64_t first, uint64_t count, std::vector<Photon>& photons) {
    Context& context = contexts_.local();
    context.paths.splits = &groups_view_;
    light_paths_->trace_photons(stages_, first, count, context.paths, photons, context.rays);
  };
  PhotonMaps::Map map;
  arena_.execute([&] { map = maps_.of_sample_alone(sample, trace, [this] { return world_.abandoned(); }); });
  for (Context& context : contexts_) counters.add(std::exchange(context.rays, RayCounters{}));
  return map;
}

} // namespace kindling
