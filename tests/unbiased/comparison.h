// Whether two ways to render a scene have the same expectation, told from images of many seeds: per block and as a whole.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kindling::test {

// Images of one way to render, one for each seed, as means over 8 x 8 blocks. A value is the mean of the three components.
class Images {
 public:
  static constexpr int kBlock = 8;

  // Both sides of the size are multiples of kBlock.
  explicit Images(const V2i& size_px) : size_px_(size_px) {}

  // Three floats for each pixel, row by row.
  void add(std::span<const float> rgb);
  // Adds those of `part` to these, seed by seed: light adds up. An empty collection takes them as they are.
  void add_light(const Images& part);

  [[nodiscard]] size_t seeds() const { return whole_.size(); }
  [[nodiscard]] size_t blocks() const;
  [[nodiscard]] const std::vector<double>& whole() const { return whole_; } // by seed
  [[nodiscard]] std::vector<double> block(size_t index) const;              // by seed
  [[nodiscard]] double mean() const;                                        // over all seeds

 private:
  V2i size_px_;
  std::vector<double> whole_;
  std::vector<std::vector<double>> blocks_; // by seed
};

// Mean of one set of independent values less that of another, and how sure that is.
struct Difference {
  double value = 0.0;
  double standard_error = 0.0; // estimated from the values
  double freedom = 1.0;        // degrees, of that estimate

  // The same probability as that of Student's t here, in standard deviations of a normal distribution.
  [[nodiscard]] double z() const { return normal_score(value); }
  // What z() would be expected to be if the true difference were `difference`.
  [[nodiscard]] double normal_score(double difference) const;
};
// Sets that know nothing of each other (Welch 1947); each of two values or more.
[[nodiscard]] Difference difference_of(std::span<const double> a, std::span<const double> b);
// Values of the same index were made with the same random numbers: of the first seeds that both have.
[[nodiscard]] Difference paired_difference_of(std::span<const double> a, std::span<const double> b);

// The z that a normal variable exceeds, on either side, with this probability.
[[nodiscard]] double two_sided_z(double probability);

// One comparison of many. The family's level is the probability that any comparison of it fails although nothing is wrong;
// half of it is for images as a whole, half for blocks, each shared evenly (Bonferroni).
struct Family {
  double level = 1e-5; // of one test program's test: a scene, a known answer
  size_t comparisons = 1;

  [[nodiscard]] double whole_threshold() const { return two_sided_z(level / 2.0 / static_cast<double>(comparisons)); }
  [[nodiscard]] double block_threshold(size_t blocks) const {
    return two_sided_z(level / 2.0 / static_cast<double>(comparisons * blocks));
  }
};

struct Verdict {
  double relative = 0.0; // the tested mean over that of the plain one, less 1
  double error = 0.0;    // its standard error
  double whole_z = 0.0;
  double worst_block_z = 0.0;
  size_t worst_block = 0;
  bool agrees = false;
  double power = 0.0; // probability that a bias of kBias of the mean would have been seen in the image as a whole

  static constexpr double kBias = 0.01;
  static constexpr double kMinPower = 0.9; // a test that is noisier says too little
  [[nodiscard]] std::string text() const;  // one line
};
// Images of one size.
[[nodiscard]] Verdict compare(const Images& tested, const Images& plain, bool paired, const Family& family);

} // namespace kindling::test
