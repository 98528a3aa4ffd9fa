// Chooses the time slices of deforming meshes by sample trees, and builds their trees.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/deforming/slices.h"

#include "accel/kdtree/deforming/moving_build.h"
#include "accel/kdtree/layout.h"

#include <tbb/parallel_for.h>

#include <utility>

namespace kindling::accel::kd {
namespace {

constexpr size_t kSample = 4096, kRun = 1024; // in triangles; consecutive triangles of a mesh are neighbors
constexpr double kWorthwhile = 0.8;
constexpr double kMaxReferences = 32.0;           // per triangle, in all slices together
constexpr size_t kMaxTriangles = size_t{1} << 22; // in all slices together

std::vector<LeafReference> sample_of(const std::vector<LeafReference>& triangles) {
  if (triangles.size() <= kSample) return triangles;
  std::vector<LeafReference> sample;
  constexpr size_t kRuns = kSample / kRun;
  for (size_t run = 0; run < kRuns; ++run) {
    const size_t first = run * (triangles.size() - kRun) / (kRuns - 1);
    for (size_t i = first; i < first + kRun; ++i) sample.push_back(triangles[i]);
  }
  return sample;
}

class SliceChooser {
 public:
  SliceChooser(const Config& config, const std::vector<Geometry>& geometries, std::vector<LeafReference> sample,
               uint32_t max_slices, BuildMonitor& monitor)
      : config_(config), geometries_(geometries), sample_(std::move(sample)), max_slices_(max_slices),
        monitor_(monitor) {}

  [[nodiscard]] std::vector<TimeSlice> run() {
    std::vector<TimeSlice> out;
    const TimeSlice whole;
    choose(whole, cost_of(whole), 1, out);
    return out;
  }

 private:
  [[nodiscard]] double cost_of(const TimeSlice& slice) const {
    return build_moving_tree(config_, geometries_, sample_, slice, 0.0, monitor_).cost;
  }
  void choose(const TimeSlice& slice, double cost, uint32_t parts, std::vector<TimeSlice>& out) const {
    if (2 * parts <= max_slices_ && !monitor_.cancelled()) {
      const double costs[2] = {cost_of(slice.half(0)), cost_of(slice.half(1))};
      if (0.5 * (costs[0] + costs[1]) < kWorthwhile * cost) {
        for (int half = 0; half < 2; ++half) choose(slice.half(half), costs[half], 2 * parts, out);
        return;
      }
    }
    out.push_back(slice);
  }

  const Config& config_;
  const std::vector<Geometry>& geometries_;
  std::vector<LeafReference> sample_;
  uint32_t max_slices_;
  BuildMonitor& monitor_;
};

} // namespace

DeformingTrees build_deforming(const Config& config, const std::vector<Geometry>& geometries, BuildMonitor& monitor) {
  DeformingTrees out;
  const std::vector<LeafReference> triangles = triangles_to_sweep(geometries);
  out.triangle_count = triangles.size();
  if (triangles.empty()) return out;
  uint32_t max_slices = DeformingTrees::kMaxSlices;
  while (max_slices > 1 && max_slices * triangles.size() > kMaxTriangles) max_slices /= 2;
  const std::vector<TimeSlice> slices =
      SliceChooser(config, geometries, sample_of(triangles), max_slices, monitor).run();
  Config slice_config = config;
  slice_config.references_per_triangle =
      std::min(config.references_per_triangle, kMaxReferences / static_cast<double>(slices.size()));
  out.slices.resize(slices.size());
  const double weight = static_cast<double>(triangles.size()) / static_cast<double>(slices.size());
  tbb::parallel_for(size_t{0}, slices.size(), [&](size_t i) {
    MovingTree tree = build_moving_tree(slice_config, geometries, triangles, slices[i], weight, monitor);
    if (monitor.cancelled()) return;
    out.slices[i].slice = slices[i];
    out.slices[i].tree = lay_out(std::move(tree.binary), geometries, &slices[i], &monitor);
    out.slices[i].tree.clip_bounds = tree.bounds[0];
    out.slices[i].tree.clip_bounds_at_end = tree.bounds[1];
  });
  if (monitor.cancelled()) return out;
  for (size_t i = 0; i < slices.size(); ++i) {
    out.bounds.extendBy(out.slices[i].tree.bounds);
    for (uint32_t part = 0; part < DeformingTrees::kMaxSlices; ++part)
      if (static_cast<float>(part) >= slices[i].begin * DeformingTrees::kMaxSlices)
        out.slice_of[part] = static_cast<uint8_t>(i);
  }
  return out;
}

} // namespace kindling::accel::kd
