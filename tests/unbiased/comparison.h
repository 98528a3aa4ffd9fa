// Statistical test that two render strategies have the same mean, by block and as a whole.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace kindling::test {

// Images of one strategy, one for each seed, as means over blocks of 8 x 8 pixels and the three
// color components.
class Images {
 public:
  static constexpr int kBlock = 8;

  // Both sides of the size are multiples of kBlock.
  explicit Images(const V2i& size_px) : size_px_(size_px) {}

  // Three floats for each pixel, row by row.
  void add(std::span<const float> rgb);
  // Adds the images of `part`, seed by seed, since light adds up. An empty collection becomes a
  // copy of it.
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

// The mean of one set of independent values minus that of another, with its uncertainty.
struct Difference {
  double value = 0.0;
  double standard_error = 0.0; // estimated from the values
  double freedom = 1.0;        // degrees of freedom of that estimate

  // Returns the z of a normal distribution with the probability of this difference in Student's t
  // distribution.
  [[nodiscard]] double z() const { return normal_score(value); }
  // Returns the expected z() for a true difference of `difference`.
  [[nodiscard]] double normal_score(double difference) const;
};
// The difference of independent sets of at least two values each (Welch 1947).
[[nodiscard]] Difference difference_of(std::span<const double> a, std::span<const double> b);
// The difference of paired sets: values of the same index share random numbers. Uses the indices
// that both sets have.
[[nodiscard]] Difference paired_difference_of(std::span<const double> a, std::span<const double> b);

// Returns the z that a normal variable exceeds, on either side, with this probability.
[[nodiscard]] double two_sided_z(double probability);

// A family of comparisons. Its level is the probability that any of them fails although nothing is
// wrong: half of it is for whole images, half for blocks, each divided evenly (Bonferroni).
struct Family {
  double level = 1e-5; // for one test: a scene, or a closed form
  size_t comparisons = 1;

  [[nodiscard]] double whole_threshold() const { return two_sided_z(level / 2.0 / static_cast<double>(comparisons)); }
  [[nodiscard]] double block_threshold(size_t blocks) const {
    return two_sided_z(level / 2.0 / static_cast<double>(comparisons * blocks));
  }
};

struct Verdict {
  double relative = 0.0; // tested mean over reference mean, minus 1
  double error = 0.0;    // its standard error
  double whole_z = 0.0;
  double worst_block_z = 0.0;
  size_t worst_block = 0;
  bool agrees = false;
  double power = 0.0; // probability of detecting a bias of kBias of the mean in the image as a whole

  static constexpr double kBias = 0.01;
  static constexpr double kMinPower = 0.9; // minimum of a meaningful test
  [[nodiscard]] std::string text() const;  // one line
};
// Compares images of the same size; `plain` is the reference.
[[nodiscard]] Verdict compare(const Images& tested, const Images& plain, bool paired, const Family& family);

} // namespace kindling::test
