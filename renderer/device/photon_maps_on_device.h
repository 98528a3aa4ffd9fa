// The photon maps that waves gather from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/kernels/path_wave.h"
#include "renderer/integrator/photons/photon_map_sizes.h"
#include "renderer/sampling/sample_range.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

// Several maps in a device's memory. A device takes their photons from the light paths of all maps
// that a wave needs together; the processor sorts them and builds the trees.
class PhotonMapsOnDevice {
 public:
  struct Maps {
    uint32_t first = 0, end = 0; // numbers

    [[nodiscard]] bool empty() const { return first == end; }
    [[nodiscard]] uint32_t count() const { return end - first; }
  };

  // Maps in memory at the same time, at most.
  static constexpr uint32_t kMaxStored = 8;

  // Makes room for so many maps with PhotonMapSizes::max_photons(). Throws DeviceError.
  PhotonMapsOnDevice(Device& device, const PhotonMapSizes& sizes, uint32_t stored);

  // Returns the number of maps whose samples of all pixels of an image fill a wave of so many
  // paths: 1 to kMaxStored.
  [[nodiscard]] static uint32_t filling(uint32_t wave_size, const PhotonMapSizes& sizes, uint64_t pixels);

  // Returns the maps of these samples that have to be built: those from the first to the last one
  // that is absent. The samples have as many maps as can be stored, at most.
  [[nodiscard]] Maps absent(const SampleRange& samples) const;
  // Builds maps; each call of begin() forgets the photons of the one before. add() takes the
  // photons that light paths [first, ...) of these maps have left, counted over all of them, where
  // their paths have met `surfaces` before. Throws DeviceError.
  void begin(const Maps& maps);
  void add(uint64_t first, uint32_t surfaces, std::span<const WavePhoton> photons);
  void build();
  // Returns the maps of samples, or of levels.
  [[nodiscard]] WavePhotonMaps of_samples(const SampleRange& samples);

 private:
  struct Stored {
    std::optional<uint32_t> number; // of the map
    DeviceArray<PhotonMapView::Node> nodes;
    DeviceArray<Photon> photons;
    PhotonMapView view;
  };
  struct Left {
    uint64_t order = 0; // PhotonMapSizes::order_of()
    Photon photon;
  };

  [[nodiscard]] Maps of(const SampleRange& samples) const;

  Device& device_;
  PhotonMapSizes sizes_;
  std::vector<Stored> stored_; // map n at n modulo their number
  DeviceArray<PhotonMapView> views_;
  Maps building_;
  std::vector<std::vector<Left>> left_; // by map that is built
};

} // namespace kindling
