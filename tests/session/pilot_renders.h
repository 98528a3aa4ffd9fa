// Renders that are long enough for a pilot, of which few samples are taken.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <utility>
#include <vector>

namespace kindling::test {

inline constexpr V2i kPilotSize(40, 30);

inline RenderSettings long_render(uint32_t samples) {
  RenderSettings settings = small_render(kPilotSize, samples);
  settings.planned_samples = 1024;
  return settings;
}

inline RenderOutcome render_open(const World& world, const RenderSettings& settings, RenderContinuity continuity = {},
                                 const CancelToken* cancel = nullptr) {
  Result<RenderOutcome> outcome =
      render(world, glass_camera(settings.size_px), settings, cancel, nullptr, std::move(continuity));
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  return std::move(outcome).value();
}

// Returns the variance of all components over their squared mean plus `floor`, summed; by eight
// seeds.
inline double relative_noise(const World& world, RenderSettings settings, double floor) {
  constexpr uint32_t kSeeds = 8;
  std::vector<double> sums, squares;
  for (settings.seed = 0; settings.seed < kSeeds; ++settings.seed) {
    const std::vector<float> image = render_open(world, settings).film.resolve(Aov::beauty);
    sums.resize(image.size());
    squares.resize(image.size());
    for (size_t i = 0; i < image.size(); ++i) {
      sums[i] += static_cast<double>(image[i]);
      squares[i] += static_cast<double>(image[i]) * static_cast<double>(image[i]);
    }
  }
  double relative = 0.0;
  for (size_t i = 0; i < sums.size(); ++i) {
    const double mean = sums[i] / kSeeds;
    relative += (squares[i] / kSeeds - mean * mean) / (mean * mean + floor);
  }
  return relative;
}

} // namespace kindling::test
