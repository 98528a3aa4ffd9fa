// The photon maps of a render, built when they are needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/photons/photon_map.h"
#include "renderer/integrator/photons/photon_map_sizes.h"

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <vector>

namespace kindling {

// Photon maps by sample number. A map depends on its number alone, so any division of a render
// among threads, machines and runs gathers the same photons. Thread-safe: threads that need a map
// at the same time build it together.
class PhotonMaps {
 public:
  using Map = std::shared_ptr<const PhotonMap>;
  // Appends the photons of the light paths [first, first + count). Called on several threads.
  using Trace = std::function<void(uint64_t first, uint64_t count, std::vector<Photon>& photons)>;

  explicit PhotonMaps(const PhotonMapSizes& sizes);
  ~PhotonMaps();

  // Maps in memory: those of two open passes, and one more.
  static constexpr size_t kMaxStored = 5;

  [[nodiscard]] uint32_t samples_per_map() const { return sizes_.samples; }
  // Returns the samples that a pass of a render may have, so that it needs few maps at a time.
  [[nodiscard]] uint32_t samples_per_pass() const { return sizes_.samples * kMapsPerPass; }
  // Returns the map of a sample; null if `stopped` was true while it was built. `trace` is called
  // for a part of the map's light paths, others may call theirs for the rest. If one throws, all
  // threads that wait for the map throw std::runtime_error.
  [[nodiscard]] Map of_sample(uint32_t sample, const Trace& trace, const std::function<bool()>& stopped);

 private:
  struct Building;
  static constexpr uint32_t kMapsPerPass = 2;

  [[nodiscard]] std::shared_ptr<Building> find(uint64_t number);

  PhotonMapSizes sizes_;
  std::mutex mutex_;
  std::list<std::shared_ptr<Building>> stored_; // the latest first
};

// The maps that one thread's batch gathers from.
class BatchPhotonMaps {
 public:
  // Takes the maps of samples [first, end). False if the render was stopped.
  [[nodiscard]] bool take(uint32_t first, uint32_t end, PhotonMaps& maps, const PhotonMaps::Trace& trace,
                          const std::function<bool()>& stopped);
  [[nodiscard]] bool empty() const { return maps_.empty(); }
  [[nodiscard]] const PhotonMap& of_sample(uint32_t sample) const {
    return *maps_[sample / samples_per_map_ - first_map_];
  }

 private:
  uint32_t first_map_ = 0;
  uint32_t samples_per_map_ = 1;
  std::vector<PhotonMaps::Map> maps_;
};

} // namespace kindling
