// Waves of the path tracer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device_wave.h"
#include "renderer/device/kernels/path_wave.h"
#include "renderer/device/photon_maps_on_device.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// Returns the bytes on a device that its waves take without a photon map, at most: one sample for
// each pixel.
[[nodiscard]] uint64_t path_wave_bytes(const WaveSetup& setup);

// The kernels that waves launch. `filters_hits`: World::filters_hits.
[[nodiscard]] std::vector<Kernel> path_wave_kernels(bool filters_hits, const WaveSetup& setup);

// With photons the samples of a wave are of at most WaveSetup::photon_maps maps, which follow each
// other; with sample rates of one.
class PathWaveRunner final : public DeviceWave {
 public:
  PathWaveRunner(Device& device, const World& world, const DeviceScene* scene, const WaveSetup& setup);

  [[nodiscard]] bool run(const Film& film) override;
  void take_results(std::span<BlockWork> work, Film& film) override;

 private:
  // Counts of the queues, which are cleared and read together.
  struct QueueCounts {
    uint32_t next = 0, shadows = 0, links = 0, photons = 0;
  };
  // For paths that are sorted by the kind of their hit.
  struct KindCounts {
    std::array<uint32_t, kHitKinds> paths, places;
  };

  // Return false if the render was abandoned.
  [[nodiscard]] bool take_photons(); // of the samples of the wave
  // Takes the photons of the light paths [first, first + count), counted from `maps_begin`, that of
  // the first map that is built.
  [[nodiscard]] bool follow_photon_paths(uint64_t maps_begin, uint64_t first, uint32_t count);
  [[nodiscard]] bool follow_camera_paths();
  [[nodiscard]] bool follow_light_paths(uint64_t first, uint32_t count); // of those of the wave
  // Finds the hits of the active paths; sorts them by their kind, if that helps a GPU.
  void find_hits(uint32_t active, bool sort);
  void share_paths();               // between pixels, once they have ended
  QueueCounts take_next();          // makes the paths of the next bounce the active ones
  void take_splats(uint32_t count); // that the camera sees

  void place_split(uint32_t light_groups); // makes room for the parts of light

  bool filters_hits_, has_light_paths_, splits_, sorts_, adds_together_;
  Kernel shade_;
  PhotonMapSizes map_sizes_;
  PixelFilter filter_; // of the image
  PathWave wave_;
  DeviceArray<PathState> states_;
  DeviceArray<MediumStack> media_;
  DeviceArray<accel::Ray> rays_, shadow_rays_;
  DeviceArray<accel::Hit> hits_;
  DeviceArray<uint32_t> active_, next_, sorted_;
  DeviceArray<uint8_t> kinds_;
  DeviceArray<KindCounts> kind_counts_;
  DeviceArray<QueueCounts> queue_counts_;
  DeviceArray<WaveShadow> shadow_records_;
  DeviceArray<WaveLightPath> light_paths_;
  DeviceArray<WaveSplat> splats_;
  DeviceArray<ReusedPath> reused_;
  DeviceArray<ReuseLink> links_;
  DeviceArray<uint32_t> traced_links_;
  DeviceArray<SplitView::Classes> split_groups_;
  DeviceArray<SplitView::Passes> split_passes_;
  DeviceArray<FirstEvent> split_firsts_;
  DeviceArray<LobeColors> split_colors_;
  DeviceArray<SplitShadow> split_shadows_;
  DeviceArray<Rgb> split_tails_;
  DeviceArray<uint8_t> second_groups_;
  DeviceArray<SplatParts> splat_parts_;
  std::vector<WaveSplat> downloaded_, found_;              // of one bounce, and of the wave
  std::vector<SplatParts> downloaded_parts_, found_parts_; // likewise, if light is split
  DeviceArray<WavePhoton> left_photons_;
  std::vector<WavePhoton> downloaded_photons_; // of one bounce
  PhotonMapsOnDevice photon_maps_;
};

} // namespace kindling
