// Threads that need a photon map trace chunks of its light paths; the last one builds the tree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/photons/photon_maps.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <stdexcept>
#include <utility>

namespace kindling {

struct PhotonMaps::Building {
  enum class State : uint8_t { tracing, complete, stopped, failed };

  Building(uint64_t map_number, uint64_t paths)
      : number(map_number), first_path(map_number * paths), path_count(paths),
        chunks((paths + PhotonMapSizes::kChunk - 1) / PhotonMapSizes::kChunk) {}

  // Traces chunks that no other thread has taken; true if this thread finished the last one.
  bool help(const Trace& trace, const std::function<bool()>& stopped) {
    bool last = false;
    for (size_t chunk = next++; chunk < chunks.size(); chunk = next++) {
      if (stopped()) {
        end(State::stopped);
        return false;
      }
      const uint64_t begin = chunk * PhotonMapSizes::kChunk;
      trace(first_path + begin, std::min(PhotonMapSizes::kChunk, path_count - begin), chunks[chunk]);
      last = ++done == chunks.size();
    }
    return last && !stopped();
  }

  void build() {
    size_t count = 0;
    for (const std::vector<Photon>& chunk : chunks) count += chunk.size();
    std::vector<Photon> photons;
    photons.reserve(count);
    for (std::vector<Photon>& chunk : chunks) {
      photons.insert(photons.end(), chunk.begin(), chunk.end());
      chunk = {};
    }
    map = std::make_shared<const PhotonMap>(std::move(photons));
  }

  void end(State how) {
    {
      const std::lock_guard lock(mutex);
      if (state != State::tracing) return;
      state = how;
    }
    ended.notify_all();
  }

  State wait(const std::function<bool()>& stopped) {
    std::unique_lock lock(mutex);
    while (state == State::tracing && !stopped()) ended.wait_for(lock, std::chrono::milliseconds(20));
    return state;
  }

  const uint64_t number, first_path, path_count;
  std::vector<std::vector<Photon>> chunks; // what was found by each
  std::atomic<size_t> next{0}, done{0};
  std::mutex mutex;
  std::condition_variable ended;
  State state = State::tracing; // guarded by mutex
  Map map;                      // set before the state is complete
};

PhotonMaps::PhotonMaps(const PhotonMapSizes& sizes) : sizes_(sizes) {}

PhotonMaps::~PhotonMaps() = default;

std::shared_ptr<PhotonMaps::Building> PhotonMaps::find(uint64_t number) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(stored_.begin(), stored_.end(),
                                  [number](const auto& building) { return building->number == number; });
  if (found != stored_.end()) {
    stored_.splice(stored_.begin(), stored_, found);
  } else {
    stored_.push_front(std::make_shared<Building>(number, sizes_.paths));
    if (stored_.size() > kMaxStored) stored_.pop_back(); // threads that still read it have it
  }
  return stored_.front();
}

PhotonMaps::Map PhotonMaps::of_sample(uint32_t sample, const Trace& trace, const std::function<bool()>& stopped) {
  const std::shared_ptr<Building> building = find(sample / sizes_.samples);
  try {
    if (building->help(trace, stopped)) {
      // Else this thread might take a task of a pilot, which would wait for the map.
      tbb::this_task_arena::isolate([&] { building->build(); });
      building->end(Building::State::complete);
    }
  } catch (...) {
    building->end(Building::State::failed);
    throw;
  }
  const Building::State state = building->wait(stopped);
  if (state == Building::State::failed) throw std::runtime_error("the photons of another thread could not be traced");
  return state == Building::State::complete ? building->map : nullptr;
}

bool BatchPhotonMaps::take(uint32_t first, uint32_t end, PhotonMaps& maps, const PhotonMaps::Trace& trace,
                           const std::function<bool()>& stopped) {
  samples_per_map_ = maps.samples_per_map();
  first_map_ = first / samples_per_map_;
  maps_.clear();
  for (uint32_t map = first_map_; map <= (end - 1) / samples_per_map_; ++map) {
    PhotonMaps::Map taken = maps.of_sample(map * samples_per_map_, trace, stopped);
    if (!taken) {
      maps_.clear();
      return false;
    }
    maps_.push_back(std::move(taken));
  }
  return true;
}

} // namespace kindling
