// The Film: sums of samples per pixel, and the pictures made of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/film/aov.h"
#include "renderer/film/outliers.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
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
};

// Every mean is sum(weight * value) / sum(weight); where the weights do not sum to more than 0 (few samples under
// negative lobes), the count of samples takes their place.
//
// A pixel is written only by the thread that owns its tile, in the order of its samples; so sums, which are in double
// precision, are the same to the bit for any number of threads.
class Film {
 public:
  Film(const V2i& size_px, const PixelRect& crop, AovSet aovs);

  // `pixel` must be inside crop().
  void add(const V2i& pixel, const FilmSample& sample) {
    const size_t index = index_of(pixel);
    const double weight = sample.weight;
    PixelSum& sum = sums_[index];
    for (int c = 0; c < 3; ++c) sum.rgb[c] += weight * static_cast<double>(sample.radiance[c]);
    sum.alpha += weight * static_cast<double>(sample.alpha);
    sum.weight += weight;
    sum.samples += 1;
    if (!luminance_.empty()) luminance_[index].add(luminance(sample.radiance), weight);
    if (!blocks_.empty())
      blocks_[index * kOutlierBlocks + sample.index % kOutlierBlocks].add(sample.radiance, sample.weight);
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
    return {{sum.rgb[0], sum.rgb[1], sum.rgb[2]}, sum.weight};
  }
  // The part of this film that lies in `crop`, a rectangle inside of crop().
  [[nodiscard]] Film cut(const PixelRect& crop) const;

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
  struct PixelSum {
    double rgb[3];
    double alpha;
    double weight;
    uint64_t samples;
  };
  struct SurfaceSum {
    double albedo[3];
    double normal[3];
    double position[3];
    double emission[3];
    double direct[3];
    double depth;
    double hit_weight;
    uint64_t hits;
  };
  // Moments of a weighted value y: what the variance of the ratio sum(w y) / sum(w) needs.
  struct Moments {
    double w2;
    double w2_y;
    double w2_y2;
    void add(double y, double weight) {
      const double square_weight = weight * weight;
      w2 += square_weight;
      w2_y += square_weight * y;
      w2_y2 += square_weight * y * y;
    }
  };

  [[nodiscard]] size_t index_of(const V2i& pixel) const {
    assert(pixel.x >= crop_.min.x && pixel.x < crop_.max.x && pixel.y >= crop_.min.y && pixel.y < crop_.max.y);
    return static_cast<size_t>(pixel.y - crop_.min.y) * static_cast<size_t>(crop_.width()) +
           static_cast<size_t>(pixel.x - crop_.min.x);
  }

  void resolve_pixel(Aov aov, size_t index, float* out) const;
  [[nodiscard]] static double variance_of_mean(const PixelSum& sum, const Moments& y, double mean);

  V2i size_px_;
  PixelRect crop_;
  AovSet aovs_;
  std::vector<PixelSum> sums_;
  std::vector<Moments> luminance_;   // only with Aov::variance
  std::vector<SurfaceSum> surfaces_; // only where the set needs it
  std::vector<BlockSum> blocks_;     // kOutlierBlocks for each pixel; only with trim_outliers()
};

} // namespace kindling
