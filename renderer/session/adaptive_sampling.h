// When the samples of a block of pixels suffice: decided from the block's own samples at fixed counts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace kindling {

struct AdaptiveSettings {
  double noise_threshold = 0.0;        // relative error at which a block is done with 64 samples; 0: off
  uint32_t min_samples_per_pixel = 32; // at least 16
  [[nodiscard]] bool enabled() const { return noise_threshold > 0.0; }
};

// What the decisions of adaptive sampling go on from, by block and pixel of its area in scan order; empty where it is off.
struct AdaptiveState {
  [[nodiscard]] bool empty() const { return stop_at.empty(); }
  // Whether it has an entry for each block and pixel of `area`.
  [[nodiscard]] bool fits(const PixelRect& area) const;

  std::vector<uint32_t> stop_at;     // samples, by block
  std::vector<uint64_t> rays;        // by block
  std::vector<Film::Totals> earlier; // by pixel: at the last power of two
};

// At n = 2^k samples the two halves of a pixel's samples are compared: (a - b)^2 / 4 estimates the squared error of the mean
// of n. It sees how evenly the sampler spreads its points, which the variance among samples does not. By itself
// it says little; so it is averaged over the 8 x 8 pixels of a block, which go on or stop together.
//
// The pixel's error is that of its worst channel, divided by the mean's luminance + kNoiseFloor (Rousselle et al. 2011,
// "Adaptive Sampling and Reconstruction using Greedy Error Minimization"). A block stops where its mean squared error
// falls below T^2 n / 64: where variance is v, n is then in proportion to sqrt(v), and not to v as with an equal error for all.
// For independent samples an equal error gives no less mean squared error than the same number of samples for every pixel; sqrt(v)
// is what makes it least (minimize sum v_i / n_i for a given sum n_i).
//
// A decision at n foresees the error at 2n (half of its square), and the block stops there: no decision sees the second half of the
// samples that it ends with. Deciding and averaging by the same samples is biased towards blocks that happened to miss what is
// rare and bright (Kirk and Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis"); this loses less of it, but some.
// Powers of two (Dammertz et al. 2009, "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination")
// also end blocks where the sampler's points are evenly spread.
//
// A decision depends on the block, its samples and the settings alone. The largest count of samples only cuts it short.
// A block's entries are touched by the thread that owns its tile, as in Film.
class AdaptiveSampling {
 public:
  // Radiance below which noise is judged absolutely.
  static constexpr double kNoiseFloor = 0.1;
  // Samples of a pixel, and rays of a sample, for which the threshold is the error at which it stops.
  static constexpr double kReferenceSamples = 64.0;
  static constexpr double kReferenceRays = 8.0;

  // `area` consists of whole blocks of the image's grid, see whole_blocks(). Goes on from `state`, which must fit or be empty, and keeps
  // it up to date: it must outlive this. With settings that are off it is left empty.
  AdaptiveSampling(const PixelRect& area, const AdaptiveSettings& settings, AdaptiveState& state);

  // The blocks that `crop` touches, cut to the image alone.
  [[nodiscard]] static PixelRect whole_blocks(const PixelRect& crop, const V2i& image_size_px);

  // The first decision: the least power of two that leaves the minimum of samples when it is doubled.
  [[nodiscard]] uint32_t first_decision() const { return first_decision_; }
  // Samples that may be taken after `done` before decide() must be called: the range to its next power of two.
  [[nodiscard]] uint32_t samples_to_decision(uint32_t done) const;

  // Whether `block` still wants samples after `done` of them.
  [[nodiscard]] bool wants_samples(const PixelRect& block, uint32_t done) const {
    return state_.stop_at[block_index(block)] > done;
  }
  // To be called with the number of all rays that were traced for samples of `block` since the last call or the start, before
  // decide().
  void count_rays(const PixelRect& block, uint64_t rays) { state_.rays[block_index(block)] += rays; }
  // To be called when the pixels of `block`, which has not stopped before, have `done` samples; does nothing at counts
  // that are not for decisions. Returns how many pixels stop here: all or none.
  uint32_t decide(const PixelRect& block, uint32_t done, const Film& film);

 private:
  static constexpr uint32_t kUndecided = std::numeric_limits<uint32_t>::max();
  [[nodiscard]] size_t block_index(const PixelRect& block) const;
  [[nodiscard]] size_t pixel_index(int x, int y) const;
  // Mean over the pixels of the squared relative error; infinite where there is nothing to judge it by.
  [[nodiscard]] double squared_error(const PixelRect& block, const Film& film) const;

  PixelRect area_;
  double noise_threshold_;
  uint32_t first_decision_;
  AdaptiveState& state_;
};

} // namespace kindling
