// Adaptive sampling: decides from the samples of a block, at fixed counts, when it is finished.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace kindling {

struct AdaptiveSettings {
  double noise_threshold = 0.0;        // relative error at which a block stops with 64 samples; 0: off
  uint32_t min_samples_per_pixel = 32; // at least 16
  [[nodiscard]] bool enabled() const { return noise_threshold > 0.0; }
};

// The state that decisions continue from, by block and pixel of the area in scan order; empty if
// adaptive sampling is off.
struct AdaptiveState {
  [[nodiscard]] bool empty() const { return stop_at.empty(); }
  // Returns whether there is an entry for each block and pixel of `area`.
  [[nodiscard]] bool fits(const PixelRect& area) const;

  std::vector<uint32_t> stop_at;     // number of samples, by block
  std::vector<uint64_t> rays;        // traced so far, by block
  std::vector<Film::Totals> earlier; // sums at the last power of two, by pixel
};

// At n = 2^k samples the two halves of a pixel's samples are compared: (a - b)^2 / 4 estimates the
// squared error of the mean of n. Unlike the variance among samples, this estimate includes how
// evenly the sampler spreads its points. A single pixel's estimate is noisy, so it is averaged over
// the 8 x 8 pixels of a block, which continue or stop together.
//
// The pixel's error is that of its worst channel, divided by the mean's luminance + kNoiseFloor
// (Rousselle et al. 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization").
// A block stops when its mean squared error falls below T^2 n / 64: for variance v, n is then
// proportional to sqrt(v), and not to v as with an equal error for all blocks. For independent
// samples an equal error does not reduce the mean squared error below that of equal sample counts;
// n proportional to sqrt(v) minimizes it (minimize sum v_i / n_i for a given sum n_i).
//
// A decision at n predicts the error at 2n (half of its square), and the block stops at 2n: no
// decision sees the second half of the samples that its block ends with. Deciding and averaging by
// the same samples is biased towards blocks that happened to miss rare bright paths (Kirk and Arvo
// 1991, "Unbiased Sampling Techniques for Image Synthesis"); predicting reduces this bias but does
// not remove it. At powers of two (Dammertz et al. 2009, "A Hierarchical Automatic Stopping
// Condition for Monte Carlo Global Illumination") the sampler's points are also evenly spread.
//
// A decision depends only on the block, its samples and the settings; the maximum number of samples
// only cuts it short. A block's entries are accessed by the thread that owns its tile, as in Film.
class AdaptiveSampling {
 public:
  // Radiance below which the absolute error counts.
  static constexpr double kNoiseFloor = 0.1;
  // Samples per pixel, and rays per sample, at which a block stops exactly when its error is the
  // threshold.
  static constexpr double kReferenceSamples = 64.0;
  static constexpr double kReferenceRays = 8.0;

  // `area` must consist of whole blocks of the image's grid (whole_blocks()). Continues from
  // `state`, which must fit or be empty, and updates it; it must outlive this object. If adaptive
  // sampling is off it stays empty.
  AdaptiveSampling(const PixelRect& area, const AdaptiveSettings& settings, AdaptiveState& state);

  // Returns the rectangle of all blocks that `crop` touches, cut to the image.
  [[nodiscard]] static PixelRect whole_blocks(const PixelRect& crop, const V2i& image_size_px);

  // Returns the sample count of the first decision: the smallest power of two whose double is at
  // least the minimum.
  [[nodiscard]] uint32_t first_decision() const { return first_decision_; }
  // Returns how many samples may follow `done` before decide() must be called: up to the next power
  // of two.
  [[nodiscard]] uint32_t samples_to_decision(uint32_t done) const;

  // Returns whether `block` needs more samples after `done` of them.
  [[nodiscard]] bool wants_samples(const PixelRect& block, uint32_t done) const {
    return state_.stop_at[block_index(block)] > done;
  }
  // Adds the rays that were traced for `block` since the last call. Must be called before decide().
  void count_rays(const PixelRect& block, uint64_t rays) { state_.rays[block_index(block)] += rays; }
  // Decides whether `block`, which must not have stopped, stops. Must be called at each count of
  // samples_to_decision(); does nothing at other counts. Returns the number of pixels that stop
  // now: all of the block or none.
  uint32_t decide(const PixelRect& block, uint32_t done, const Film& film);

 private:
  static constexpr uint32_t kUndecided = std::numeric_limits<uint32_t>::max();
  [[nodiscard]] size_t block_index(const PixelRect& block) const;
  [[nodiscard]] size_t pixel_index(int x, int y) const;
  // Returns the mean over the pixels of the squared relative error; infinite if there are too few
  // samples.
  [[nodiscard]] double squared_error(const PixelRect& block, const Film& film) const;

  PixelRect area_;
  double noise_threshold_;
  uint32_t first_decision_;
  AdaptiveState& state_;
};

} // namespace kindling
