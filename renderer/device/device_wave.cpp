// Plans a wave, and brings its sums to the film.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/device_wave.h"

#include "renderer/base/standard_arithmetic.h"
#include "renderer/integrator/camera_stage.h"
#include "renderer/integrator/first_hits.h"
#include "renderer/integrator/stages/light_path_stages.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling {

namespace {

// Returns the number of samples of all pixels of a block.
uint64_t samples_at(const PixelRect& block, const SampleRange& levels, const SampleRates& rates) {
  uint64_t sum = 0;
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) sum += rates.samples_at(V2i(x, y), levels).count();
  return sum;
}

} // namespace

uint64_t common_wave_bytes(const WaveSetup& setup) {
  const AovSet aovs = setup.aovs;
  const uint64_t of_sample = sizeof(CameraSample) + (aovs.needs_film_surface() ? sizeof(FilmSurface) : 0) +
                             (aovs.needs_first_hit() ? sizeof(WaveFirstHit) : 0) + sizeof(WaveRays<uint32_t>);
  const uint64_t of_pixel =
      sizeof(PixelSum) + (aovs.contains(Aov::variance) ? sizeof(MomentSum) : 0) +
      (aovs.needs_surface() ? sizeof(SurfaceSum) : 0) + (aovs.needs_guides() ? sizeof(GuideSum) : 0) +
      (aovs.needs_components() ? sizeof(ComponentSum) : 0) +
      (setup.trims_outliers ? sizeof(ColorSum) * (kOutlierBlocks - 1) : 0) +
      sizeof(RadianceSum) * (setup.light_groups + LightPassPlaces(aovs).count) +
      (aovs.needs_lobe_colors() ? sizeof(LobeColorSum) : 0) + (setup.has_rates ? sizeof(WavePixel) : 0);
  const uint64_t of_block = sizeof(WaveBlock) + sizeof(WaveRays<uint64_t>); // of one pixel, at least
  return setup.paths * (of_sample + of_pixel + of_block) + sizeof(WaveRays<uint64_t>) + sizeof(WaveLosses);
}

DeviceWave::DeviceWave(Device& device, const World& world, const WaveSetup& setup, bool with_surfaces)
    : device_(device), world_(world), pager_(setup.pager), first_hit_records_(setup.first_hits), capacity_(setup.paths),
      whole_blocks_(setup.path_reuse > 1), image_px_(setup.image_px), light_paths_(setup.light_paths),
      outside_(setup.outside), samples_(device, capacity_), surfaces_(device, with_surfaces ? capacity_ : 0),
      first_hits_(device, setup.aovs.needs_first_hit() ? capacity_ : 0), rays_(device, capacity_), losses_(device, 1) {
  assert(capacity_ >= kBlockSize * kBlockSize * SampleRates::kMaxAtLevel);
}

uint32_t DeviceWave::take(size_t number, const PixelRect& wanted, const SampleRange& samples,
                          const SampleRates* rates) {
  const PixelRect block = whole_blocks_ ? whole_block(wanted, image_px_) : wanted;
  const auto pixels = static_cast<uint32_t>(block.pixel_count());
  const uint64_t room = capacity_ - sample_count_;
  uint32_t count = samples.count();
  uint64_t sum = uint64_t{count} * pixels;
  if (!rates) {
    count = static_cast<uint32_t>(std::min<uint64_t>(count, room / pixels));
    sum = uint64_t{count} * pixels;
  } else {
    while (count > 0 && (sum = samples_at(block, {samples.first, samples.first + count}, *rates)) > room) --count;
  }
  if (count == 0) return 0;
  const SampleRange taken{samples.first, samples.first + count};
  samples_taken_ = taken_.empty() ? taken
                                  : SampleRange{std::min(samples_taken_.first, taken.first),
                                                std::max(samples_taken_.end, taken.end)};
  const SampleRange passes = light_path_passes(light_paths_, taken);
  const OutsidePixels::Range outside =
      light_paths_ > 0.0f ? outside_.share_of(block.min, kBlockSize) : OutsidePixels::Range{};
  const uint64_t light_paths = passes.count() * (pixels + outside.count());
  blocks_.push_back({.corner = block.min,
                     .width = static_cast<uint32_t>(block.width()),
                     .height = static_cast<uint32_t>(block.height()),
                     .first_index = samples.first,
                     .samples = rates ? 0 : count,
                     .first_sample = sample_count_,
                     .first_pixel = pixel_count_,
                     .first_light_path = light_path_count_,
                     .first_outside = outside.first,
                     .outside = outside.count(),
                     .first_pass = passes.first});
  taken_.push_back({number, count, sum, light_paths});
  if (rates) plan_pixels(block, taken, *rates);
  sample_count_ += static_cast<uint32_t>(sum);
  pixel_count_ += pixels;
  light_path_count_ += light_paths;
  return count;
}

void DeviceWave::plan_pixels(const PixelRect& block, const SampleRange& levels, const SampleRates& rates) {
  pixels_.resize(pixel_count_); // those of earlier blocks without rates are not read
  uint32_t first = sample_count_;
  for (int y = block.min.y; y < block.max.y; ++y)
    for (int x = block.min.x; x < block.max.x; ++x) {
      const SampleRange samples = rates.samples_at(V2i(x, y), levels);
      pixels_.push_back({samples.first, first, samples.count()});
      first += samples.count();
    }
}

void DeviceWave::start(const Film& film, Wave& wave) {
  device_blocks_.grow(device_, blocks_.size());
  device_blocks_.upload(blocks_);
  device_pixels_.grow(device_, pixels_.size());
  device_pixels_.upload(pixels_);
  losses_.upload(std::array{WaveLosses{}});
  const AovSet aovs = film.aovs();
  wave.blocks = device_blocks_.span().first(blocks_.size());
  wave.pixels = device_pixels_.span().first(pixels_.size());
  wave.samples = samples_.data();
  wave.surfaces = surfaces_.data();
  wave.first_hits = aovs.needs_first_hit() ? first_hits_.data() : nullptr;
  first_hits_here_.resize(aovs.needs_first_hit() ? sample_count_ : 0);
  samples_here_.resize(first_hits_here_.size());
  wave.rays = rays_.data();
  light_groups_ = film.light_groups().size();
  pass_places_ = LightPassPlaces(aovs);
  wave.film = {
      .sums = sums_.start(device_, pixel_count_),
      .moments = moments_.start(device_, aovs.contains(Aov::variance) ? pixel_count_ : 0),
      .surfaces = surface_sums_.start(device_, aovs.needs_surface() ? pixel_count_ : 0),
      .guides = guides_.start(device_, aovs.needs_guides() ? pixel_count_ : 0),
      .components = components_.start(device_, aovs.needs_components() ? pixel_count_ : 0),
      .blocks = outlier_blocks_.start(device_, film.trims_outliers() ? size_t{pixel_count_} * (kOutlierBlocks - 1) : 0),
      .groups = groups_.start(device_, pixel_count_ * light_groups_),
      .passes = passes_.start(device_, size_t{pixel_count_} * pass_places_.count),
      .colors = colors_.start(device_, aovs.needs_lobe_colors() ? pixel_count_ : 0),
      .light_groups = light_groups_,
      .places = pass_places_};
  wave.block_rays = block_rays_.start(device_, blocks_.size() + 1).data();
  wave.losses = losses_.data();
}

void DeviceWave::download_sums() {
  sums_.download();
  moments_.download();
  surface_sums_.download();
  guides_.download();
  components_.download();
  outlier_blocks_.download();
  groups_.download();
  passes_.download();
  colors_.download();
  block_rays_.download();
  if (first_hits_here_.empty()) return;
  samples_.download(samples_here_);
  first_hits_.download(first_hits_here_);
}

void DeviceWave::add_first_hits(std::span<const BlockWork> work, Film& film) const {
  tbb::parallel_for(size_t{0}, blocks_.size(), [&](size_t number) {
    const StandardArithmetic standard_arithmetic;
    const PixelRect& wanted = work[taken_[number].number].block; // the wave may have more of a block that is cut
    const size_t first = blocks_[number].first_sample;
    for (size_t i = first; i < first + taken_[number].samples; ++i)
      if (!first_hits_here_[i].lost && wanted.contains({samples_here_[i].pixel, samples_here_[i].pixel + V2i(1)}))
        first_hit_records_->add(samples_here_[i], first_hits_here_[i].hit, film);
  });
}

// A block that is cut has its pixels row by row.
void DeviceWave::add_sums(const WaveBlock& from, const PixelRect& to, Film& film) {
  const auto add = [&](const PixelRect& rect) {
    const size_t first = from.first_pixel + static_cast<size_t>(rect.min.y - from.corner.y) * from.width +
                         static_cast<size_t>(rect.min.x - from.corner.x);
    const auto pixels = static_cast<size_t>(rect.pixel_count());
    const auto part = [&](auto& sums, size_t per_pixel) {
      const auto all = sums.here.span();
      return all.empty() ? all : all.subspan(first * per_pixel, pixels * per_pixel);
    };
    film.add(rect,
             FilmView{part(sums_, 1), part(moments_, 1), part(surface_sums_, 1), part(guides_, 1), part(components_, 1),
                      part(outlier_blocks_, kOutlierBlocks - 1), part(groups_, light_groups_),
                      part(passes_, pass_places_.count), part(colors_, 1), light_groups_, pass_places_});
  };
  if (static_cast<uint32_t>(to.width()) == from.width) {
    add(to);
    return;
  }
  for (int y = to.min.y; y < to.max.y; ++y) add({V2i(to.min.x, y), V2i(to.max.x, y + 1)});
}

void DeviceWave::take_results(std::span<BlockWork> work, Film& film) {
  if (first_hit_records_ != nullptr && !first_hits_here_.empty()) add_first_hits(work, film);
  tbb::parallel_for(size_t{0}, blocks_.size(),
                    [&](size_t i) { add_sums(blocks_[i], work[taken_[i].number].block, film); });
  const std::span<const WaveRays<uint64_t>> block_rays = block_rays_.here.span();
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const WaveBlock& block = blocks_[i];
    BlockWork& done = work[taken_[i].number];
    film.add_light_paths(done.block.min, taken_[i].light_paths);
    const WaveRays<uint64_t>& rays = block_rays[i];
    const uint64_t samples = taken_[i].samples;
    done.added += taken_[i].levels;
    done.rays += samples + rays.bounces + rays.shadows;
    const auto outside = uint64_t{block.width} * block.height - static_cast<uint64_t>(done.block.pixel_count());
    counters.paths += samples - outside * taken_[i].levels; // none if there are rates
    counters.camera += samples;
    counters.bounce += rays.bounces;
    counters.shadow += rays.shadows;
    counters.whitted.reflection += rays.reflections;
    counters.whitted.transmission += rays.refractions;
  }
  const WaveRays<uint64_t>& outside = block_rays.back();
  counters.bounce += outside.bounces;
  counters.shadow += outside.shadows;
  counters.outside += outside.bounces + outside.shadows;
  std::array<WaveLosses, 1> losses;
  losses_.download(losses);
  if (losses[0].count > 0) {
    const uint64_t first = losses[0].first;
    RayCounters lost;
    lost.non_finite = losses[0].count;
    lost.first_non_finite = {V2i(static_cast<int>(first & 0xffffU), static_cast<int>(first >> 16 & 0xffffU)),
                             static_cast<uint32_t>(first >> 32)};
    counters.add(lost);
  }
  blocks_.clear();
  pixels_.clear();
  taken_.clear();
  sample_count_ = pixel_count_ = 0;
  light_path_count_ = 0;
}

} // namespace kindling
