// When the samples of a pixel suffice: decided from the pixel's own samples at fixed counts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace kindling {

struct AdaptiveSettings {
  double noise_threshold = 0.0; // relative standard error at which a pixel is done (Film::relative_error()); 0: off
  uint32_t min_samples_per_pixel = 128; // at least 16
  [[nodiscard]] bool enabled() const { return noise_threshold > 0.0; }
};

// At n = 2^k samples of a pixel the error that it will have after 2n is foreseen from the variance so far; if that suffices,
// the pixel stops at 2n. So a decision never sees the second half of the samples that it ends with. Deciding and averaging
// by the same samples is biased towards pixels that happened to miss what is rare and bright (Kirk and Arvo 1991,
// "Unbiased Sampling Techniques for Image Synthesis"); this loses less of it, but some. What is left falls with the minimum.
// Powers of two (Dammertz et al. 2009, "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination")
// also end pixels where the sampler's points are evenly spread.
//
// A decision depends on the pixel, its samples and the settings alone. The largest count of samples only cuts it short.
// A pixel's entry is touched by the thread that owns its tile, as in Film.
class AdaptiveSampling {
 public:
  AdaptiveSampling(const PixelRect& crop, const AdaptiveSettings& settings);

  // The first decision: the least power of two that leaves the minimum of samples when it is doubled.
  [[nodiscard]] uint32_t first_decision() const { return first_decision_; }
  // Samples that may be taken after `done` before the next decision or stop: the range to its next power of two.
  [[nodiscard]] uint32_t samples_to_decision(uint32_t done) const;

  // What of `block` still wants samples after `done` of them; may be empty.
  [[nodiscard]] PixelBlock remaining(const PixelRect& block, uint32_t done) const;
  // To be called when the pixels of `block` that are not stopped have `done` samples; does nothing at counts that are not for
  // decisions. Returns how many pixels stop here.
  uint32_t decide(const PixelRect& block, uint32_t done, const Film& film);

 private:
  static constexpr uint32_t kUndecided = std::numeric_limits<uint32_t>::max();
  [[nodiscard]] size_t index_of(int x, int y) const {
    return static_cast<size_t>(y - crop_.min.y) * static_cast<size_t>(crop_.width()) +
           static_cast<size_t>(x - crop_.min.x);
  }

  PixelRect crop_;
  double noise_threshold_;
  uint32_t first_decision_;
  std::vector<uint32_t> stop_at_; // samples, by pixel
};

} // namespace kindling
