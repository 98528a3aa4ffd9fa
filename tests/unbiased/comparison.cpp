// Statistics of the comparison: t-tests of block and image means over seeds.
// SPDX-License-Identifier: Apache-2.0
#include "tests/unbiased/comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace kindling::test {
namespace {

struct Moments {
  double mean = 0.0;
  double variance = 0.0; // of the mean
  double freedom = 1.0;
};

Moments moments_of(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  Moments moments;
  for (const double v : values) moments.mean += v / n;
  for (const double v : values) moments.variance += (v - moments.mean) * (v - moments.mean) / (n * (n - 1.0));
  moments.freedom = n - 1.0;
  return moments;
}

// Relative rounding error of sums of floats, the only error of images without noise.
constexpr double kRounding = 2e-6;

double upper_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

} // namespace

void Images::add(std::span<const float> rgb) {
  const int columns = size_px_.x / kBlock;
  std::vector<double> blocks(this->blocks());
  double whole = 0.0;
  for (int y = 0; y < size_px_.y; ++y)
    for (int x = 0; x < size_px_.x; ++x)
      for (size_t c = 0; c < 3; ++c) {
        const double value = rgb[static_cast<size_t>(y * size_px_.x + x) * 3 + c];
        blocks[static_cast<size_t>(y / kBlock * columns + x / kBlock)] += value / (3.0 * kBlock * kBlock);
        whole += value / (3.0 * size_px_.x * size_px_.y);
      }
  whole_.push_back(whole);
  blocks_.push_back(std::move(blocks));
}

void Images::add_light(const Images& part) {
  if (whole_.empty()) {
    *this = part;
    return;
  }
  for (size_t seed = 0; seed < seeds(); ++seed) {
    whole_[seed] += part.whole_[seed];
    for (size_t i = 0; i < blocks(); ++i) blocks_[seed][i] += part.blocks_[seed][i];
  }
}

size_t Images::blocks() const { return static_cast<size_t>((size_px_.x / kBlock) * (size_px_.y / kBlock)); }

std::vector<double> Images::block(size_t index) const {
  std::vector<double> values;
  for (const std::vector<double>& image : blocks_) values.push_back(image[index]);
  return values;
}

double Images::mean() const { return moments_of(whole_).mean; }

// Wallace 1959, "Bounds on Normal Approximations to Student's and the Chi-Square Distributions":
// within 0.02 for all t from 10 degrees of freedom on.
double Difference::normal_score(double difference) const {
  const double t2 = difference * difference / (standard_error * standard_error);
  const double score = std::sqrt(freedom * std::log1p(t2 / freedom)) * (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0);
  return std::copysign(score, difference);
}

Difference difference_of(std::span<const double> a, std::span<const double> b) {
  const Moments ma = moments_of(a), mb = moments_of(b);
  Difference result;
  result.value = ma.mean - mb.mean;
  const double rounding = kRounding * (std::fabs(ma.mean) + std::fabs(mb.mean)) + 1e-30;
  const double variance = ma.variance + mb.variance;
  result.standard_error = std::sqrt(variance + rounding * rounding);
  const double squares = ma.variance * ma.variance / ma.freedom + mb.variance * mb.variance / mb.freedom;
  result.freedom = squares > 0.0 ? variance * variance / squares : ma.freedom + mb.freedom;
  return result;
}

Difference paired_difference_of(std::span<const double> a, std::span<const double> b) {
  std::vector<double> differences;
  double mean = 0.0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    differences.push_back(a[i] - b[i]);
    mean += 0.5 * (a[i] + b[i]);
  }
  const auto n = static_cast<double>(differences.size());
  const Moments moments = moments_of(differences);
  const double rounding = 2.0 * kRounding * mean / n + 1e-30;
  return {moments.mean, std::sqrt(moments.variance + rounding * rounding), moments.freedom};
}

double two_sided_z(double probability) {
  double low = 0.0, high = 38.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (2.0 * upper_tail(middle) > probability ? low : high) = middle;
  }
  return high;
}

Verdict compare(const Images& tested, const Images& plain, bool paired, const Family& family) {
  const auto difference = paired ? paired_difference_of : difference_of;
  const double mean = plain.mean();
  const Difference whole = difference(tested.whole(), plain.whole());
  Verdict verdict;
  verdict.relative = whole.value / mean;
  verdict.error = whole.standard_error / mean;
  verdict.whole_z = whole.z();
  const double threshold = family.whole_threshold();
  verdict.power = upper_tail(threshold - whole.normal_score(Verdict::kBias * mean));
  for (size_t i = 0; i < plain.blocks(); ++i) {
    const double z = difference(tested.block(i), plain.block(i)).z();
    if (std::fabs(z) <= std::fabs(verdict.worst_block_z)) continue;
    verdict.worst_block_z = z;
    verdict.worst_block = i;
  }
  verdict.agrees = std::fabs(verdict.whole_z) <= threshold &&
                   std::fabs(verdict.worst_block_z) <= family.block_threshold(plain.blocks());
  return verdict;
}

std::string Verdict::text() const {
  char line[160];
  std::snprintf(line, sizeof line, "%+.3f %% +- %.3f %%, z %+.2f, worst block %zu z %+.2f, power %.3f",
                100.0 * relative, 100.0 * error, whole_z, worst_block, worst_block_z, power);
  return line;
}

} // namespace kindling::test
