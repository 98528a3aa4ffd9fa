// The division of light paths and samples among photon maps.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/photons/photon_map.h"

#include <algorithm>
#include <cstdint>

namespace kindling {

// Samples [n `samples`, (n + 1) `samples`) of all pixels gather from map n, whose photons are those
// of the light paths [n `paths`, (n + 1) `paths`).
struct PhotonMapSizes {
  uint64_t paths = 0;   // light paths of a map; 0: there are no maps
  uint32_t samples = 1; // of a pixel

  // Returns the sizes of a render with so many light paths for each sample of all pixels. Small
  // images have maps of more samples, since small maps cost more to search.
  [[nodiscard]] static constexpr PhotonMapSizes of(uint64_t paths_per_sample) {
    constexpr uint64_t kSmallMap = 1U << 18; // paths; those of fewer are shared
    constexpr uint64_t kMaxSamples = 16;     // which have the same noise of photons
    const uint64_t shared = std::clamp(kSmallMap / std::max<uint64_t>(paths_per_sample, 1), uint64_t{1}, kMaxSamples);
    return {paths_per_sample * shared, static_cast<uint32_t>(shared)};
  }
  [[nodiscard]] bool empty() const { return paths == 0; }
  // Returns the photons of a map, at most: two of each path are more than scenes of water and glass
  // have.
  [[nodiscard]] uint64_t max_photons() const { return 2 * paths; }
  [[nodiscard]] uint64_t bytes() const { return max_photons() * PhotonMap::kBytes; }

  // Light paths that are traced together.
  static constexpr uint64_t kChunk = 1024;
  // Returns a number by which the photons of a map are sorted: by chunk, then by the number of
  // surfaces that their path met before, then by path. `path`: its number in the map.
  [[nodiscard]] static constexpr uint64_t order_of(uint64_t path, uint32_t surfaces_before) {
    constexpr uint32_t kPathBits = 10, kSurfaceBits = 16;
    static_assert(kChunk == uint64_t{1} << kPathBits);
    return (path / kChunk << kSurfaceBits | surfaces_before) << kPathBits | path % kChunk;
  }
};

} // namespace kindling
