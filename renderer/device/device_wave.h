// A wave on a device: which samples it has, and what they add to the film.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/kernels/wave.h"
#include "renderer/device/tile_pager.h"
#include "renderer/integrator/integrator.h"
#include "renderer/integrator/photons/photon_map_sizes.h"
#include "renderer/integrator/stages/outside_pixels.h"
#include "renderer/sampling/pixel_filter.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

class FirstHits;

// Settings of the waves of a render.
struct WaveSetup {
  uint32_t paths = kWaveSize; // that are followed together, at least those of a block with the highest rates
  AovSet aovs;
  const FirstHits* first_hits = nullptr; // what the film records of first surfaces; null: nothing
  uint32_t light_groups = 0;             // of the film
  uint32_t max_shadow_rays = 1;          // IntegratorSettings::max_shadow_rays()
  uint32_t path_reuse = 1;               // IntegratorSettings::path_reuse: above 1, waves have whole blocks
  V2i image_px{0};                       // size
  bool trims_outliers = false;
  bool has_rates = false;             // sample rates
  bool manifolds = false;             // PathStages::manifolds is set
  float light_paths = 0.0f;           // fraction of the samples that have one; 0: none are traced
  OutsidePixels outside;              // of the crop: theirs are traced, too
  PixelFilter filter = PixelFilter(); // of the light that they bring
  PhotonMapSizes photons;             // empty: none are gathered
  uint32_t photon_maps = 1;           // of the samples of a wave
  TilePager* pager = nullptr;         // null: all texels are in memory

  // True if light is split by light group and first event.
  [[nodiscard]] bool splits() const {
    return light_groups > 0 || aovs.needs_light_passes() || aovs.needs_lobe_colors();
  }
};

// Returns the bytes on a device that waves of all tracers take, at most: one sample for each pixel.
[[nodiscard]] uint64_t common_wave_bytes(const WaveSetup& setup);

// The plan of a wave and the memory that waves of all tracers have; derived classes follow the
// samples. It is used for one wave after the other.
class DeviceWave : public ThreadContext {
 public:
  // Takes samples of a block, the first of `samples`, as many as there is room for; returns how
  // many of each pixel, or with rates how many levels. `number`: the block's index in the list of
  // take_results().
  uint32_t take(size_t number, const PixelRect& block, const SampleRange& samples, const SampleRates* rates = nullptr);
  [[nodiscard]] bool empty() const { return taken_.empty(); }
  // Follows all samples to their end. False if the render was abandoned.
  [[nodiscard]] virtual bool run(const Film& film) = 0;
  // Adds the sums and the counts of the wave, and empties the plan.
  virtual void take_results(std::span<BlockWork> work, Film& film);

 protected:
  // `world`: for World::abandoned(). All references must outlive this. `with_surfaces`: records
  // the first surface of each sample.
  DeviceWave(Device& device, const World& world, const WaveSetup& setup, bool with_surfaces);

  // Sets `wave` to the plan, with cleared sums for `film`.
  void start(const Film& film, Wave& wave);
  void download_sums();
  template <typename Argument>
  void launch(Kernel kernel, const Argument& argument, uint32_t count) {
    device_.launch(kernel, std::as_bytes(std::span(&argument, 1)), count);
  }
  // Launches a kernel that shades, again and again for the paths that wait for tiles.
  template <typename Argument>
  void launch_shading(Kernel kernel, Argument& argument, uint32_t count) {
    if (pager_ == nullptr)
      launch(kernel, argument, count);
    else
      pager_->run(
          argument.tiles, count, [&](uint32_t launched) { launch(kernel, argument, launched); },
          [this] { return abandoned(); });
  }
  [[nodiscard]] bool abandoned() const { return world_.abandoned(); }
  [[nodiscard]] Device& device() const { return device_; }
  [[nodiscard]] uint32_t capacity() const { return capacity_; } // samples
  [[nodiscard]] uint32_t sample_count() const { return sample_count_; }
  // Returns a range of indices in their pixels, or levels, that has all samples of the wave.
  [[nodiscard]] const SampleRange& samples() const { return samples_taken_; }
  [[nodiscard]] uint32_t pixel_count() const { return pixel_count_; }
  [[nodiscard]] uint64_t light_path_count() const { return light_path_count_; }

 private:
  // Sums of pixels or blocks, on the device and here.
  template <typename Sum>
  struct Sums {
    DeviceArray<Sum> on_device;
    HostArray<Sum> here;

    // Makes room for `size` sums and clears them.
    std::span<Sum> start(Device& device, size_t size) {
      on_device.grow(device, size);
      on_device.clear(size);
      here.resize(device, size);
      return on_device.span().first(size);
    }
    void download() { on_device.download(here.span()); }
  };

  // The part of the plan that a block has.
  struct Taken {
    size_t number = 0;    // of the block in the caller's list
    uint32_t levels = 0;  // or samples of each pixel
    uint64_t samples = 0; // of all pixels
    uint64_t light_paths = 0;
  };

  // Adds what the film records of the first surfaces of all samples.
  void add_first_hits(std::span<const BlockWork> work, Film& film) const;
  void add_sums(const WaveBlock& from, const PixelRect& to, Film& film); // `to`: pixels of the block
  void plan_pixels(const PixelRect& block, const SampleRange& levels, const SampleRates& rates);

  Device& device_;
  const World& world_;
  TilePager* pager_;
  const FirstHits* first_hit_records_;
  uint32_t capacity_;
  bool whole_blocks_;
  V2i image_px_;
  float light_paths_; // fraction
  OutsidePixels outside_;
  uint32_t sample_count_ = 0, pixel_count_ = 0;
  uint64_t light_path_count_ = 0;
  SampleRange samples_taken_; // by all blocks
  std::vector<WaveBlock> blocks_;
  std::vector<WavePixel> pixels_; // empty without rates
  std::vector<Taken> taken_;      // by block

  DeviceArray<WaveBlock> device_blocks_;
  DeviceArray<WavePixel> device_pixels_;
  DeviceArray<CameraSample> samples_;
  DeviceArray<FilmSurface> surfaces_;
  DeviceArray<WaveFirstHit> first_hits_;
  std::vector<CameraSample> samples_here_; // with first hits alone
  std::vector<WaveFirstHit> first_hits_here_;
  DeviceArray<WaveRays<uint32_t>> rays_;
  DeviceArray<WaveLosses> losses_;
  Sums<PixelSum> sums_;
  Sums<MomentSum> moments_;
  Sums<SurfaceSum> surface_sums_;
  Sums<GuideSum> guides_;
  Sums<ComponentSum> components_;
  Sums<ColorSum> outlier_blocks_;
  Sums<RadianceSum> groups_, passes_;
  Sums<LobeColorSum> colors_;
  size_t light_groups_ = 0; // of the film, and its passes
  LightPassPlaces pass_places_;
  Sums<WaveRays<uint64_t>> block_rays_;
};

} // namespace kindling
