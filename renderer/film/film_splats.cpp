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
}

void Film::add_splat(const V2i& pixel, const Rgb& radiance) {
  SplatSum& sum = splats_[splat_index(pixel)];
  const std::lock_guard lock(splat_locks_->of_row(pixel.y));
  for (int c = 0; c < 3; ++c) sum.rgb[c].add(static_cast<double>(radiance[c]));
}

const SplatSum& Film::splat_at(size_t index) const {
  const auto width = static_cast<size_t>(crop_.width());
  return splats_[splat_index(crop_.min + V2i(static_cast<int>(index % width), static_cast<int>(index / width)))];
}

void Film::cut_splats(Film& part) const {
  if (splats_.empty()) return;
  part.enable_splats();
  for (int y = part.crop_.min.y; y < part.crop_.max.y; ++y)
    std::copy_n(splats_.data() + splat_index({part.crop_.min.x, y}), part.crop_.width(),
                part.splats_.data() + part.splat_index({part.crop_.min.x, y}));
  // Paths of samples outside of the crop have reached pixels inside of it.
  if (!part.splats_.empty()) part.splats_[0].paths += static_cast<uint64_t>(light_paths() - part.light_paths());
}

double Film::light_paths() const {
  uint64_t paths = 0;
  for (const SplatSum& sum : splats_) paths += sum.paths;
  return static_cast<double>(paths);
}

} // namespace kindling
