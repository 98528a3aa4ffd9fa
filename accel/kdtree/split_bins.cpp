// The binned search for nodes of many references: starts and ends are counted in bins, then swept.
// After Shevtsov, Soupikov and Kapustin, "Highly parallel fast kd-tree construction for interactive ray tracing of dynamic
// scenes", 2007 (min/max binning).
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/split.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>

namespace kindling::accel::kd {
namespace {

constexpr size_t kChunk = 32768; // fixed, so that results do not depend on the number of threads

struct Occupied {
  Imath::V3f min{std::numeric_limits<float>::max()}, max{std::numeric_limits<float>::lowest()};
};

struct Histogram {
  std::array<std::array<uint32_t, kBins>, 3> starts{}, ends{};
};

// Calls f(chunk number, references of the chunk) for all chunks, in parallel if there are several.
template <class F>
void for_each_chunk(std::span<const Reference> references, const F& f) {
  const size_t chunks = (references.size() + kChunk - 1) / kChunk;
  const auto run = [&](size_t c) {
    f(c, references.subspan(c * kChunk, std::min(kChunk, references.size() - c * kChunk)));
  };
  if (chunks == 1) {
    run(0);
  } else {
    tbb::parallel_for(size_t{0}, chunks, run);
  }
}

struct Binning {
  float low = 0.0f, width = 0.0f, scale = 0.0f; // scale 0: the axis has no extent
  [[nodiscard]] uint32_t bin(float x) const {
    return std::min(kBins - 1, static_cast<uint32_t>(std::max(0.0f, (x - low) * scale)));
  }
  [[nodiscard]] float border(uint32_t i) const { return low + static_cast<float>(i) * width; }
};

} // namespace

std::optional<Split> best_split_binned(const Config& config, const Imath::Box3f& box,
                                       std::span<const Reference> references) {
  const CostModel model(config, box);
  std::optional<Split> best;
  if (!model.splittable()) return best;
  const size_t chunks = (references.size() + kChunk - 1) / kChunk;

  std::vector<Occupied> occupied(chunks);
  for_each_chunk(references, [&](size_t c, std::span<const Reference> part) {
    for (const Reference& reference : part)
      for (int k = 0; k < 3; ++k) {
        occupied[c].min[k] = std::min(occupied[c].min[k], reference.min[k]);
        occupied[c].max[k] = std::max(occupied[c].max[k], reference.max[k]);
      }
  });
  Occupied all;
  std::array<Binning, 3> binning;
  for (int k = 0; k < 3; ++k) {
    for (const Occupied& part : occupied) {
      all.min[k] = std::min(all.min[k], part.min[k]);
      all.max[k] = std::max(all.max[k], part.max[k]);
    }
    const float extent = all.max[k] - all.min[k];
    Binning& b = binning[static_cast<size_t>(k)];
    b.low = all.min[k];
    b.width = extent / static_cast<float>(kBins);
    b.scale = extent > 1e-30f ? static_cast<float>(kBins) / extent : 0.0f;
  }

  std::vector<Histogram> histograms(chunks);
  for_each_chunk(references, [&](size_t c, std::span<const Reference> part) {
    for (const Reference& reference : part)
      for (size_t k = 0; k < 3; ++k) {
        ++histograms[c].starts[k][binning[k].bin(reference.min[static_cast<int>(k)])];
        ++histograms[c].ends[k][binning[k].bin(reference.max[static_cast<int>(k)])];
      }
  });

  for (int axis = 0; axis < 3; ++axis) {
    const auto offer = [&](float position, size_t left, size_t right) {
      if (!(position > box.min[axis] && position < box.max[axis])) return;
      const double cost = model.split_cost(axis, position, left, right);
      const bool planar_left = right == 0 || (left != 0 && left < right);
      if (!best || cost < best->cost) best = Split{cost, position, axis, planar_left};
    };
    offer(all.min[axis], 0, references.size());
    offer(all.max[axis], references.size(), 0);
    const auto k = static_cast<size_t>(axis);
    if (binning[k].scale == 0.0f) continue;
    size_t left = 0, right = references.size();
    for (uint32_t i = 1; i < kBins; ++i) {
      for (const Histogram& histogram : histograms) {
        left += histogram.starts[k][i - 1];
        right -= histogram.ends[k][i - 1];
      }
      offer(binning[k].border(i), left, right);
    }
  }
  return best;
}

} // namespace kindling::accel::kd
