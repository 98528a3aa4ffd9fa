// The sums of a film as plain arrays, and the addition of samples to them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/film/film_sums.h"
#include "renderer/film/film_surface.h"
#include "renderer/film/outliers.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// One finished sample of one pixel. `radiance` is premultiplied by alpha.
struct FilmSample {
  Rgb radiance{0.0f};
  float alpha = 1.0f;
  float weight = 1.0f; // of the pixel filter, with mean 1; negative under a negative lobe
  uint32_t index = 0;  // of the sample in its pixel; needed for Film::trim_outliers() only
};

// One record, or kOutlierBlocks - 1 of `blocks`, for each pixel. A pixel must be written by one
// thread at a time.
struct FilmView {
  std::span<PixelSum> sums;
  std::span<MomentSum> moments;       // empty without Aov::variance
  std::span<SurfaceSum> surfaces;     // empty unless AovSet::needs_surface()
  std::span<GuideSum> guides;         // empty unless AovSet::needs_guides()
  std::span<ComponentSum> components; // empty unless AovSet::needs_components()
  std::span<ColorSum> blocks;         // all but the last of kOutlierBlocks blocks; empty without Film::trim_outliers()

  void add(size_t pixel, const FilmSample& sample) const {
    sums[pixel].add(sample.radiance, sample.alpha, sample.weight);
    add_to_others(pixel, sample);
  }
  // The part of add() that only some renders need.
  void add_to_others(size_t pixel, const FilmSample& sample) const {
    if (!moments.empty()) moments[pixel].add(luminance(sample.radiance), sample.weight);
    const uint32_t block = sample.index % kOutlierBlocks;
    if (!blocks.empty() && block != kOutlierBlocks - 1) // the last block is the pixel minus the other blocks
      blocks[pixel * (kOutlierBlocks - 1) + block].add(sample.radiance, sample.weight);
  }
  // Adds the AOV data of a sample, in addition to add(). Does nothing if no AOV needs it.
  void add_surface(size_t pixel, const FilmSurface& surface, float weight) const {
    if (!components.empty()) components[pixel].add(surface.emission, surface.direct, weight);
    if (!surfaces.empty() && surface.hit)
      surfaces[pixel].add(surface.albedo, surface.normal, surface.position, surface.depth, weight);
    if (!guides.empty() && surface.hit) guides[pixel].add(surface.guide_albedo, surface.guide_normal, weight);
  }
};

} // namespace kindling
