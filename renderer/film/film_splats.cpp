// The Film's light of light paths, which any thread adds to any pixel.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"

#include <mutex>

namespace kindling {

// Rows share locks, so that films of any height have the same memory.
struct SplatLocks {
  std::mutex& of_row(int y) { return mutexes[static_cast<size_t>(y) % mutexes.size()]; }
  std::array<std::mutex, 256> mutexes;
};

void Film::enable_splats() {
  splats_ = ZeroedArray<SplatSum>(sums_.size());
  splat_locks_ = std::make_shared<SplatLocks>();
}

void Film::add_splat(const V2i& pixel, const Rgb& radiance) {
  SplatSum& sum = splats_[index_of(pixel)];
  const std::lock_guard lock(splat_locks_->of_row(pixel.y));
  for (int c = 0; c < 3; ++c) sum.rgb[c].add(static_cast<double>(radiance[c]));
}

double Film::light_paths() const {
  uint64_t paths = 0;
  for (const SplatSum& sum : splats_) paths += sum.paths;
  return static_cast<double>(paths);
}

} // namespace kindling
