// Combines measured shares with those of other scenes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/noise_shares.h"

#include <algorithm>

namespace kindling {
namespace {

constexpr NoiseShares kMean{0.55, 0.19};

struct Covariance {
  double lights = 0.0, both = 0.0, reflections = 0.0;
};
constexpr Covariance kPrior{0.25 * 0.25, -0.7 * 0.25 * 0.15, 0.15 * 0.15};

// A share that is open alone.
constexpr double kMeanAlone = 0.4, kPriorAlone = 0.3 * 0.3;

// The ratios of sums over the blocks, and their covariance by the jackknife (Efron and Stein 1981):
// without a block that has most of the noise they would be quite different.
struct Measured {
  NoiseShares shares;
  Covariance covariance;
};

Measured measured_in(std::span<const BlockShares> blocks) {
  BlockShares sum;
  for (const BlockShares& block : blocks) {
    sum.all += block.all;
    sum.lights += block.lights;
    sum.reflections += block.reflections;
  }
  Measured measured{.shares = {sum.lights / sum.all, sum.reflections / sum.all}, .covariance = {}};
  for (const BlockShares& block : blocks) {
    const double others = sum.all - block.all;
    if (!(others > 0.0)) continue;
    const double lights = (block.lights - measured.shares.lights * block.all) / others;
    const double reflections = (block.reflections - measured.shares.reflections * block.all) / others;
    measured.covariance.lights += lights * lights;
    measured.covariance.both += lights * reflections;
    measured.covariance.reflections += reflections * reflections;
  }
  return measured;
}

double likely_alone(double measured, double variance) {
  return (measured * kPriorAlone + kMeanAlone * variance) / (kPriorAlone + variance);
}

} // namespace

NoiseShares likely_shares(std::span<const BlockShares> blocks, bool lights_open, bool reflections_open) {
  const Measured measured = measured_in(blocks);
  NoiseShares likely;
  if (lights_open && reflections_open) {
    const double lights = measured.shares.lights - kMean.lights;
    const double reflections = measured.shares.reflections - kMean.reflections;
    const Covariance sum{kPrior.lights + measured.covariance.lights, kPrior.both + measured.covariance.both,
                         kPrior.reflections + measured.covariance.reflections};
    const double determinant = sum.lights * sum.reflections - sum.both * sum.both;
    const double of_lights = (sum.reflections * lights - sum.both * reflections) / determinant;
    const double of_reflections = (sum.lights * reflections - sum.both * lights) / determinant;
    likely.lights = kMean.lights + kPrior.lights * of_lights + kPrior.both * of_reflections;
    likely.reflections = kMean.reflections + kPrior.both * of_lights + kPrior.reflections * of_reflections;
  } else if (lights_open) {
    likely.lights = likely_alone(measured.shares.lights, measured.covariance.lights);
  } else if (reflections_open) {
    likely.reflections = likely_alone(measured.shares.reflections, measured.covariance.reflections);
  }
  // Stratified light samples may take away more than their share, reflection samples do not.
  likely.reflections = std::clamp(likely.reflections, 0.0, 1.0);
  likely.lights = std::clamp(likely.lights, 0.0, 1.0 - likely.reflections);
  return likely;
}

} // namespace kindling
