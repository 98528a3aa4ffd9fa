// A table of environment samples, which the pixels of an image share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/base/prefetch.h"
#include "renderer/light/environment.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// Samples of an environment image: one for each cell of a grid over the unit square of draws, for a
// random draw in that cell. To read a sample takes one cache line; to draw one takes a search, some
// texels and two angles. Real-time renderers presample lights likewise (Wyman and Panteleev 2021,
// "Rearchitecting Spatiotemporal Resampling for Production").
//
// Draws stay stratified down to the cells, and densities are exact. Another seed gives other
// samples, so that the mean over seeds is that of drawn samples. The error that all pixels share,
// that of a stratified sum over kSide^2 samples, is far below the noise of kMaxSamples samples.
struct PresampledEnvironmentView {
  struct alignas(32) Entry {
    V3f wi{0.0f};
    float pdf = 0.0f; // solid angle
    Rgb radiance{0.0f};
  };
  static constexpr uint32_t kSide = 256;
  // Samples of a pixel from this number on are to be drawn, so that the image converges.
  static constexpr uint32_t kMaxSamples = 4096;

  // Returns the number of the entry for the draw u in [0, 1]^2.
  [[nodiscard]] static uint32_t entry_of(const V2f& u) {
    assert(u.x >= 0.0f && u.x <= 1.0f && u.y >= 0.0f && u.y <= 1.0f);
    const auto cell = [](float x) { return std::min(static_cast<uint32_t>(x * static_cast<float>(kSide)), kSide - 1); };
    return cell(u.y) * kSide + cell(u.x);
  }
  // Sets the sample of u in [0, 1]^2: what EnvironmentView::sample() returns for a draw in the same
  // cell.
  void set_sample(const V2f& u, LightSample& sample) const {
    const Entry& entry = entries[entry_of(u)];
    sample.wi = entry.wi;
    sample.distance = kInfinity;
    sample.radiance = entry.radiance;
    sample.pdf = entry.pdf;
  }
  // Prefetches the memory of set_sample(u).
  void prefetch(const V2f& u) const { kindling::prefetch(entries.data() + entry_of(u)); }

  std::span<const Entry> entries; // kSide rows of kSide
};
static_assert(sizeof(PresampledEnvironmentView::Entry) == 32);

class PresampledEnvironment : public PresampledEnvironmentView {
 public:
  // `environment` has an image that is not black. Takes two milliseconds on one thread; runs on
  // those of the current TBB arena, whose number changes nothing.
  PresampledEnvironment(const EnvironmentView& environment, uint32_t seed);

  [[nodiscard]] size_t memory_bytes() const { return arrays_.bytes(); }

 private:
  OwnedArrays arrays_;
};

} // namespace kindling
