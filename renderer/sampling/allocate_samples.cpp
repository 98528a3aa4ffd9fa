// Sums of variances over windows of pixels, and the numbers of samples that follow.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/allocate_samples.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace kindling {
namespace {

constexpr int kNear = 2; // radii of the windows
constexpr int kFar = kAllocationMargin;

// The sum of predicted costs is kept at this fraction of that of equal numbers, so that both take
// about the same time: pixels next to noisy ones also get many samples, and where there is more
// noise, a sample costs more than its rays. Fitted to thirteen scenes.
constexpr double kCostFraction = 0.9;
constexpr double kMaxRelativeVariance = SampleRates::kPilotLevels; // of samples of which all but one are black

// Returns the logarithm of the power of two that is nearest to planned * scale * sqrt(v / c),
// within the bounds.
uint32_t log2_samples(const GroupNoise& noise, uint32_t planned, double scale) {
  const double samples = static_cast<double>(planned) * scale;
  const double squared = samples * samples * noise.relative_variance / noise.cost;
  const uint32_t min = SampleRates::min_log2(planned), max = SampleRates::max_log2(planned);
  if (!(squared > 1.0)) return min;
  // The power of two x is the nearest of squares from x^2 / 2 to 2 x^2.
  const int log2 = std::isinf(squared) ? static_cast<int>(max) : (std::ilogb(squared) + 1) / 2;
  return std::clamp(static_cast<uint32_t>(log2), min, max);
}

// Sums over rectangles of a map (Crow 1984, "Summed-Area Tables for Texture Mapping").
class SummedArea {
 public:
  explicit SummedArea(const NoiseMap& noise)
      : noise_(noise), columns_(static_cast<size_t>(noise.width) + 1),
        sums_(columns_ * (static_cast<size_t>(noise.height) + 1), 0) {
    size_t at = 0;
    for (size_t y = 1; y <= static_cast<size_t>(noise.height); ++y) {
      uint64_t row = 0;
      for (size_t x = 1; x < columns_; ++x) {
        row += noise.relative_variance[at++];
        sums_[y * columns_ + x] = sums_[(y - 1) * columns_ + x] + row;
      }
    }
  }

  // Returns the mean over the pixels within `radius` of a pixel of the map, without it.
  [[nodiscard]] double mean_around(const V2i& at, int radius) const {
    const auto x0 = static_cast<size_t>(std::max(at.x - radius, 0)),
               y0 = static_cast<size_t>(std::max(at.y - radius, 0)),
               x1 = static_cast<size_t>(std::min(at.x + radius + 1, noise_.width)),
               y1 = static_cast<size_t>(std::min(at.y + radius + 1, noise_.height));
    const size_t others = (x1 - x0) * (y1 - y0) - 1;
    if (others == 0) return 0.0;
    const uint64_t own =
        noise_.relative_variance[static_cast<size_t>(at.y) * (columns_ - 1) + static_cast<size_t>(at.x)];
    const uint64_t sum = sums_[y1 * columns_ + x1] - sums_[y0 * columns_ + x1] - sums_[y1 * columns_ + x0] +
                         sums_[y0 * columns_ + x0] - own;
    return static_cast<double>(sum) * NoiseMap::kVarianceUnit / static_cast<double>(others);
  }

 private:
  const NoiseMap& noise_;
  size_t columns_;
  std::vector<uint64_t> sums_; // over what is above and to the left
};

} // namespace

std::string_view sample_rates_name(SampleRateKind kind) {
  constexpr std::array<std::string_view, 3> kNames{"even", "noise", "auto"};
  return kNames[static_cast<size_t>(kind)];
}

std::optional<SampleRateKind> sample_rates_from_name(std::string_view name) {
  for (const SampleRateKind kind : {SampleRateKind::even, SampleRateKind::noise, SampleRateKind::automatic})
    if (sample_rates_name(kind) == name) return kind;
  return std::nullopt;
}

double relative_variance(double mean, double variance, double floor) {
  const double squared = mean * mean + floor * floor;
  if (!(squared > 0.0)) return 0.0;
  const double relative = variance / squared;
  return relative < kMaxRelativeVariance ? relative : kMaxRelativeVariance; // also if sums have overflowed
}

double rate_scale(std::span<const GroupNoise> groups, uint32_t planned, double min_gain, double& predicted) {
  assert(planned > SampleRates::kPilotLevels);
  double cost = 0.0, variance = 0.0, noise = 0.0;
  for (const GroupNoise& group : groups) {
    assert(group.cost > 0.0);
    cost += group.cost;
    variance += group.relative_variance;
    noise += std::sqrt(group.relative_variance * group.cost);
  }
  // By Cauchy and Schwarz the best numbers leave noise^2 / (variance * cost) of the error.
  predicted = noise > 0.0 ? noise * noise / (variance * cost) : 1.0;
  if (!(noise > 0.0 && predicted * min_gain < 1.0)) return 0.0;
  const double wanted = kCostFraction * cost * static_cast<double>(planned);
  const auto cost_at = [&](double scale) {
    double sum = 0.0;
    for (const GroupNoise& group : groups)
      sum += std::ldexp(group.cost, static_cast<int>(log2_samples(group, planned, scale)));
    return sum;
  };
  // The cost grows with the scale, in steps.
  double low = 0.0, high = cost / noise;
  for (int i = 0; i < 64 && cost_at(high) < wanted; ++i) {
    low = high;
    high *= 2.0;
  }
  constexpr int kSteps = 50;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = 0.5 * (low + high);
    (cost_at(middle) < wanted ? low : high) = middle;
  }
  return high;
}

std::vector<uint8_t> allocate_samples(const NoiseMap& noise, const V2i& corner, int width, int height, uint32_t planned,
                                      const RateRule& rule) {
  assert(corner.x >= noise.corner.x && corner.y >= noise.corner.y);
  assert(corner.x + width <= noise.corner.x + noise.width && corner.y + height <= noise.corner.y + noise.height);
  assert(rule.scale > 0.0);
  const SummedArea sums(noise);
  std::vector<uint8_t> numbers;
  numbers.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const V2i at = corner - noise.corner + V2i(x, y);
      const double variance = std::sqrt(sums.mean_around(at, kNear) * sums.mean_around(at, kFar));
      const float cost =
          noise.cost[static_cast<size_t>(at.y) * static_cast<size_t>(noise.width) + static_cast<size_t>(at.x)];
      numbers.push_back(static_cast<uint8_t>(log2_samples({variance, static_cast<double>(cost)}, planned, rule.scale)));
    }
  return numbers;
}

} // namespace kindling
