// An accelerator with known hits and deliberate errors, its rays, and a race on them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/shootout_measure.h"
#include "renderer/app/shootout/shootout_report.h"

#include <gtest/gtest.h>

namespace kindling::test {

// A half plane: rays along -z meet z = 0 where x < 0. `shift` is added to each distance, and every
// `lie_every`-th answer is wrong (0: none).
class PlaneAccelerator : public accel::Accelerator {
 public:
  PlaneAccelerator(float shift, uint32_t lie_every) : shift_(shift), lie_every_(lie_every) {}

  accel::Hit intersect(const accel::Ray& ray) const override {
    accel::Hit hit;
    const bool lie = lie_every_ > 0 && ray.index % lie_every_ == 0;
    if ((ray.origin.x < 0.0f) == lie) return hit;
    hit.t = ray.origin.z + shift_;
    hit.instance = hit.mesh = 0;
    hit.triangle = lie_every_; // ids differ between accelerators, and must not count
    return hit;
  }
  bool occluded(const accel::Ray& ray) const override { return intersect(ray).is_hit(); }
  void intersect(std::span<const accel::Ray> rays, std::span<accel::Hit> hits) const override {
    batches.push_back(rays.size());
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = intersect(rays[i]);
  }
  void occluded(std::span<const accel::Ray> rays, std::span<uint8_t> occluded) const override {
    for (size_t i = 0; i < rays.size(); ++i) occluded[i] = this->occluded(rays[i]) ? 1 : 0;
  }
  Imath::Box3f bounds() const override { return {}; }
  accel::Statistics statistics() const override { return {}; }

  mutable std::vector<size_t> batches;

 private:
  float shift_;
  uint32_t lie_every_;
};

// 300 rays, of which every other one hits.
inline RaySet plane_rays(const std::string& name, RayQuery query, uint32_t group) {
  RaySet set{name, query, group, {}};
  for (uint32_t i = 0; i < 300; ++i)
    set.rays.push_back({.origin = V3f(i % 2 == 0 ? -1.0f : 1.0f, 0.0f, 2.0f),
                        .direction = V3f(0.0f, 0.0f, -1.0f),
                        .t_max = kInfinity,
                        .index = i});
  return set;
}

// Races on the rays of `sets` by batches of 128.
inline app::SceneResult race(std::span<const accel::Accelerator* const> racers, const std::vector<RaySet>& sets,
                             uint32_t repeat) {
  app::SceneResult result;
  result.accelerators.resize(racers.size());
  app::RaceSettings settings;
  settings.batch_size = 128;
  settings.repeat = repeat;
  EXPECT_TRUE(app::race_traversal(
      sets, racers, settings, [](const std::string&) { return true; }, result));
  return result;
}

} // namespace kindling::test
