// The Film's light of light paths, which any thread adds to any pixel.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"

#include <algorithm>
#include <cassert>
#include <mutex>

namespace kindling {

// Rows share locks, so that films of any height have the same memory.
struct SplatLocks {
  std::mutex& of_row(int y) { return mutexes[static_cast<size_t>(y) % mutexes.size()]; }
  std::array<std::mutex, 256> mutexes;
};

void Film::enable_splats(const PixelRect& area) {
  assert(crop_.empty() || area.contains(crop_));
  splat_area_ = area;
  splats_ = ZeroedArray<SplatSum>(area.empty() ? 0 : static_cast<size_t>(area.pixel_count()));
  splat_locks_ = std::make_shared<SplatLocks>();
  splat_pass_count_ = 0;
  for (size_t i = 0; i < kSplatPasses.size(); ++i)
    splat_slots_[i] = aovs_.contains(kSplatPasses[i]) ? static_cast<uint8_t>(splat_pass_count_++) : kNotStored;
  splat_passes_ = ZeroedArray<RadianceSum>(splats_.size() * splat_pass_count_);
  allocate_splat_groups();
}

void Film::allocate_splat_groups() { splat_groups_ = ZeroedArray<RadianceSum>(splats_.size() * light_groups_.size()); }

void Film::add_splat(const V2i& pixel, const Rgb& radiance, const SplatParts& parts) {
  const size_t index = splat_index(pixel);
  const std::lock_guard lock(splat_locks_->of_row(pixel.y));
  const auto add_to = [&radiance](auto& sum) {
    for (int c = 0; c < 3; ++c) sum.rgb[c].add(static_cast<double>(radiance[c]));
  };
  add_to(splats_[index]);
  if (!splat_groups_.empty()) {
    assert(parts.group < light_groups_.size());
    add_to(splat_groups_[index * light_groups_.size() + parts.group]);
  }
  if (splat_passes_.empty()) return;
  std::array<Rgb, kSplatPasses.size()> by_pass;
  for (size_t i = 0; i < by_pass.size(); ++i) by_pass[i] = radiance * parts.passes[i];
  RadianceSum* const sums = splat_passes_.data() + index * splat_pass_count_;
  split_sample(
      by_pass.size(), [&](size_t pass) { return by_pass[pass]; }, radiance, 1.0f,
      [&](size_t pass, int channel, const FilmSum& term) {
        if (splat_slots_[pass] != kNotStored) sums[splat_slots_[pass]].rgb[channel].add(term);
      });
}

size_t Film::splat_index_at(size_t index) const {
  const auto width = static_cast<size_t>(crop_.width());
  return splat_index(crop_.min + V2i(static_cast<int>(index % width), static_cast<int>(index / width)));
}

void Film::cut_splats(Film& part) const {
  if (splats_.empty()) return;
  part.enable_splats();
  const auto copy_row = [&](int y, const auto& from, auto& to, size_t per_pixel) {
    const V2i first(part.crop_.min.x, y);
    if (!to.empty())
      std::copy_n(from.data() + splat_index(first) * per_pixel, static_cast<size_t>(part.crop_.width()) * per_pixel,
                  to.data() + part.splat_index(first) * per_pixel);
  };
  for (int y = part.crop_.min.y; y < part.crop_.max.y; ++y) {
    copy_row(y, splats_, part.splats_, 1);
    copy_row(y, splat_groups_, part.splat_groups_, light_groups_.size());
    copy_row(y, splat_passes_, part.splat_passes_, splat_pass_count_);
  }
  // Paths of samples outside of the crop have reached pixels inside of it.
  if (!part.splats_.empty()) part.splats_[0].paths += static_cast<uint64_t>(light_paths() - part.light_paths());
}

double Film::light_paths() const {
  uint64_t paths = 0;
  for (const SplatSum& sum : splats_) paths += sum.paths;
  return static_cast<double>(paths);
}

} // namespace kindling
