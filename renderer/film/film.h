// The Film: sums of samples per pixel, and the images made of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/film/aov.h"
#include "renderer/film/film_sums.h"
#include "renderer/film/outliers.h"
#include "renderer/film/zeroed_array.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace kindling {

// One finished sample of one pixel. `radiance` is premultiplied by alpha.
struct FilmSample {
  Rgb radiance{0.0f};
  float alpha = 1.0f;
  float weight = 1.0f; // of the pixel filter, 1 in the mean; negative under a negative lobe
  uint32_t index = 0;  // of the sample in its pixel; only trim_outliers() asks
};

// What the AOVs want to know of the sample besides; filled only where AovSet::needs_surface() or needs_components().
struct FilmSurface {
  Rgb albedo{0.0f};
  V3f normal{0.0f};
  float depth = 0.0f;
  V3f position{0.0f};
  bool hit = false;
  Rgb emission{0.0f};
  Rgb direct{0.0f};
};

// A half-open rectangle of pixels.
struct PixelRect {
  V2i min{0, 0};
  V2i max{0, 0};
  [[nodiscard]] int width() const { return max.x - min.x; }
  [[nodiscard]] int height() const { return max.y - min.y; }
  [[nodiscard]] int64_t pixel_count() const { return static_cast<int64_t>(width()) * height(); }
  [[nodiscard]] bool empty() const { return width() <= 0 || height() <= 0; }
  bool operator==(const PixelRect&) const = default;
};

// Every mean is sum(weight * value) / sum(weight); where the weights do not sum to more than 0 (few samples under
// negative lobes), the count of samples takes their place.
//
// All sums are exact (film_sums.h): what a pixel has is a function of the set of its samples. Their order, the threads that add them and
// the films that they were added to first, merged by add(part), do not change a bit. A pixel is written by one thread at a time.
class Film {
 public:
  Film(const V2i& size_px, const PixelRect& crop, AovSet aovs);

  // `pixel` must be inside crop().
  void add(const V2i& pixel, const FilmSample& sample) {
    const size_t index = index_of(pixel);
    sums_[index].add(sample.radiance, sample.alpha, sample.weight);
    if (!moments_.empty()) moments_[index].add(luminance(sample.radiance), sample.weight);
    if (!blocks_.empty()) add_to_block(index, sample);
  }
  // In addition to add(), when the set needs it; does nothing otherwise.
  void add_surface(const V2i& pixel, const FilmSurface& surface, float weight);

  // Lets outliers_trimmed() decide on the beauty of each pixel, and on no other AOV; before the first add().
  void trim_outliers();

  // What a pixel has so far: sums of weight times radiance, and of weights.
  struct Totals {
    std::array<double, 3> rgb{};
    double weight = 0.0;
  };
  [[nodiscard]] Totals totals(const V2i& pixel) const {
    const PixelSum& sum = sums_[index_of(pixel)];
    return {{sum.rgb[0].value(), sum.rgb[1].value(), sum.rgb[2].value()}, sum.weight.value()};
  }
  // The part of this film that lies in `crop`, a rectangle inside of crop().
  [[nodiscard]] Film cut(const PixelRect& crop) const;

  // Adds what another film of the same image, AOVs and treatment of outliers has; its crop must lie inside of crop().
  void add(const Film& part);

  // The sums as they are stored, for files: arrays of fixed-size records by pixel of the crop window, rows from the top, of
  // little-endian words. Which planes there are depends on the AOVs and on trim_outliers() alone; README.md has their layout.
  struct ConstPlane {
    std::string_view name; // unique, at most 31 letters
    size_t bytes_per_pixel = 0;
    std::span<const std::byte> bytes;
  };
  struct Plane {
    std::string_view name;
    size_t bytes_per_pixel = 0;
    std::span<std::byte> bytes;
  };
  [[nodiscard]] std::vector<ConstPlane> planes() const;
  [[nodiscard]] std::vector<Plane> planes();
  [[nodiscard]] bool trims_outliers() const { return !blocks_.empty(); }

  // width * height * channels of the crop window, rows from the top. 0 everywhere for an AOV that neither the set
  // contains nor every film has (beauty, alpha, samples).
  [[nodiscard]] std::vector<float> resolve(Aov aov) const;
  // Interleaved premultiplied RGBA of the crop window.
  [[nodiscard]] std::vector<float> resolve_rgba() const;

  [[nodiscard]] const V2i& size_px() const { return size_px_; }
  [[nodiscard]] const PixelRect& crop() const { return crop_; }
  [[nodiscard]] AovSet aovs() const { return aovs_; }
  [[nodiscard]] uint64_t total_samples() const;
  [[nodiscard]] size_t memory_bytes() const;

 private:
  [[nodiscard]] size_t index_of(const V2i& pixel) const {
    assert(pixel.x >= crop_.min.x && pixel.x < crop_.max.x && pixel.y >= crop_.min.y && pixel.y < crop_.max.y);
    return static_cast<size_t>(pixel.y - crop_.min.y) * static_cast<size_t>(crop_.width()) +
           static_cast<size_t>(pixel.x - crop_.min.x);
  }

  void add_to_block(size_t index, const FilmSample& sample) {
    const uint32_t block = sample.index % kOutlierBlocks;
    if (block != kOutlierBlocks - 1) // the last one is what the others leave of the pixel
      blocks_[index * (kOutlierBlocks - 1) + block].add(sample.radiance, sample.weight);
  }
  void resolve_pixel(Aov aov, size_t index, float* out) const;
  [[nodiscard]] std::optional<Rgb> trimmed(size_t index) const;
  // Calls visit(name, array, records of it by pixel) for each array of sums that this film has.
  template <typename ThisFilm, typename Visit>
  static void for_each_plane(ThisFilm& film, const Visit& visit);

  V2i size_px_;
  PixelRect crop_;
  AovSet aovs_;
  ZeroedArray<PixelSum> sums_;
  ZeroedArray<MomentSum> moments_;       // only with Aov::variance
  ZeroedArray<SurfaceSum> surfaces_;     // only where the set needs it
  ZeroedArray<ComponentSum> components_; // likewise
  ZeroedArray<ColorSum> blocks_;         // all but the last of kOutlierBlocks for each pixel; only with trim_outliers()
};

} // namespace kindling
