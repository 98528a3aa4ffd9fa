// The sums of a film as plain arrays, and the addition of samples to them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/film/film_sums.h"
#include "renderer/film/film_surface.h"
#include "renderer/film/outliers.h"
#include "renderer/film/split_light.h"

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
  std::span<RadianceSum> groups;      // light_groups for each pixel
  std::span<RadianceSum> passes;      // places.count for each pixel
  std::span<LobeColorSum> colors;     // empty unless AovSet::needs_lobe_colors()
  size_t light_groups = 0;
  LightPassPlaces places{};

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
  // Adds the radiance of a sample by light group, in addition to add(): part_at(group) returns one
  // of `light_groups` parts, which sum to sample.radiance up to rounding (split_sample()).
  template <typename PartAt>
  void add_light_groups(size_t pixel, const FilmSample& sample, const PartAt& part_at) const {
    if (light_groups == 0) return;
    RadianceSum* const sums_here = groups.data() + pixel * light_groups;
    split_sample(light_groups, part_at, sample.radiance, sample.weight,
                 [&](size_t part, int channel, const FilmSum& term) { sums_here[part].rgb[channel].add(term); });
  }
  // The same by LightPass: kLightPassCount parts, of which those in the film's AOVs are stored.
  template <typename PartAt>
  void add_light_passes(size_t pixel, const FilmSample& sample, const PartAt& part_at) const {
    if (places.count == 0) return;
    RadianceSum* const sums_here = passes.data() + pixel * places.count;
    split_sample(kLightPassCount, part_at, sample.radiance, sample.weight,
                 [&](size_t part, int channel, const FilmSum& term) {
                   const uint8_t place = places.of_pass[part];
                   if (place != LightPassPlaces::kNotStored) sums_here[place].rgb[channel].add(term);
                 });
  }
  void add_lobe_colors(size_t pixel, const LobeColors& of_sample, float weight) const {
    if (!colors.empty()) colors[pixel].add(of_sample, weight);
  }
};

} // namespace kindling
