// From sums of samples to means.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling {

namespace {

// What a sum of weighted values is divided by: never zero or negative.
double divisor(double weight, uint64_t count) { return weight > 0.0 ? weight : static_cast<double>(count); }

double mean_luminance(const double (&rgb)[3], double by) {
  return (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) / by;
}

void store_mean(const double (&sum)[3], double by, float* out) {
  for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c] / by);
}

} // namespace

Film::Film(const V2i& size_px, const PixelRect& crop, AovSet aovs) : size_px_(size_px), crop_(crop), aovs_(aovs) {
  const size_t count = crop.empty() ? 0 : static_cast<size_t>(crop.pixel_count());
  sums_.assign(count, PixelSum{});
  if (aovs.contains(Aov::variance)) luminance_.assign(count, Moments{});
  if (aovs.needs_surface() || aovs.needs_components()) surfaces_.assign(count, SurfaceSum{});
}

void Film::add_surface(const V2i& pixel, const FilmSurface& surface, float weight) {
  if (surfaces_.empty()) return;
  SurfaceSum& sum = surfaces_[index_of(pixel)];
  const double w = weight;
  for (int c = 0; c < 3; ++c) {
    sum.emission[c] += w * static_cast<double>(surface.emission[c]);
    sum.direct[c] += w * static_cast<double>(surface.direct[c]);
  }
  if (!surface.hit) return;
  for (int c = 0; c < 3; ++c) {
    sum.albedo[c] += w * static_cast<double>(surface.albedo[c]);
    sum.normal[c] += w * static_cast<double>(surface.normal[c]);
    sum.position[c] += w * static_cast<double>(surface.position[c]);
  }
  sum.depth += w * static_cast<double>(surface.depth);
  sum.hit_weight += w;
  sum.hits += 1;
}

// The mean is the ratio r = sum(w y) / sum(w); to first order its variance is sum(w^2 (y - r)^2) / sum(w)^2 (Cochran,
// "Sampling Techniques", 3rd ed., section 6.4), times n / (n - 1). With equal weights that is exactly the unbiased s^2
// / n.
double Film::variance_of_mean(const PixelSum& sum, const Moments& y, double mean) {
  if (sum.samples < 2) return 0.0;
  const double n = static_cast<double>(sum.samples);
  const double by = divisor(sum.weight, sum.samples);
  const double squares = y.w2_y2 - 2.0 * mean * y.w2_y + mean * mean * y.w2;
  return std::max(squares, 0.0) / (by * by) * n / (n - 1.0);
}

void Film::trim_outliers() { blocks_.assign(sums_.size() * kOutlierBlocks, {}); }

Film Film::cut(const PixelRect& crop) const {
  Film part(size_px_, crop, aovs_);
  if (!blocks_.empty()) part.trim_outliers();
  const auto width = static_cast<std::ptrdiff_t>(crop.width());
  for (int y = crop.min.y; y < crop.max.y; ++y) {
    const auto from = static_cast<std::ptrdiff_t>(index_of(V2i(crop.min.x, y)));
    const auto to = static_cast<std::ptrdiff_t>(part.index_of(V2i(crop.min.x, y)));
    const auto copy_row = [&](const auto& whole, auto& cut, std::ptrdiff_t per_pixel = 1) {
      if (!whole.empty())
        std::copy_n(whole.begin() + from * per_pixel, width * per_pixel, cut.begin() + to * per_pixel);
    };
    copy_row(sums_, part.sums_);
    copy_row(luminance_, part.luminance_);
    copy_row(surfaces_, part.surfaces_);
    copy_row(blocks_, part.blocks_, kOutlierBlocks);
  }
  return part;
}

void Film::resolve_pixel(Aov aov, size_t index, float* out) const {
  const PixelSum& sum = sums_[index];
  if (sum.samples == 0) return;
  const double by = divisor(sum.weight, sum.samples);
  switch (aov) {
  case Aov::beauty:
    if (!blocks_.empty()) {
      const std::span<const BlockSum, kOutlierBlocks> blocks(blocks_.data() + index * kOutlierBlocks, kOutlierBlocks);
      if (const std::optional<Rgb> trimmed = outliers_trimmed(blocks)) {
        for (int c = 0; c < 3; ++c) out[c] = (*trimmed)[c];
        return;
      }
    }
    store_mean(sum.rgb, by, out);
    return;
  // Negative lobes may push the mean past the ends at edges; coverage has none outside [0, 1].
  case Aov::alpha: out[0] = static_cast<float>(std::clamp(sum.alpha / by, 0.0, 1.0)); return;
  case Aov::samples: out[0] = static_cast<float>(sum.samples); return;
  case Aov::variance:
    if (!luminance_.empty())
      out[0] = static_cast<float>(variance_of_mean(sum, luminance_[index], mean_luminance(sum.rgb, by)));
    return;
  default: break;
  }
  if (surfaces_.empty()) return;
  const SurfaceSum& surface = surfaces_[index];
  const double hits = divisor(surface.hit_weight, surface.hits);
  switch (aov) {
  case Aov::albedo: store_mean(surface.albedo, by, out); return;
  case Aov::normal: store_mean(surface.normal, by, out); return;
  case Aov::emission: store_mean(surface.emission, by, out); return;
  case Aov::direct: store_mean(surface.direct, by, out); return;
  case Aov::indirect:
    for (int c = 0; c < 3; ++c) {
      const double difference = sum.rgb[c] - surface.emission[c] - surface.direct[c];
      // Radiance was added up in single precision: a difference within its rounding is none.
      const double rounding =
          1e-6 * (std::abs(sum.rgb[c]) + std::abs(surface.emission[c]) + std::abs(surface.direct[c]));
      out[c] = std::abs(difference) <= rounding ? 0.0f : static_cast<float>(difference / by);
    }
    return;
  case Aov::depth:
    if (surface.hits > 0) out[0] = static_cast<float>(surface.depth / hits);
    return;
  case Aov::position:
    if (surface.hits > 0) store_mean(surface.position, hits, out);
    return;
  default: return;
  }
}

std::vector<float> Film::resolve(Aov aov) const {
  const auto channels = static_cast<size_t>(aov_info(aov).channels);
  std::vector<float> values(sums_.size() * channels, 0.0f);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) resolve_pixel(aov, i, values.data() + i * channels);
  });
  return values;
}

std::vector<float> Film::resolve_rgba() const {
  std::vector<float> values(sums_.size() * 4, 0.0f);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      resolve_pixel(Aov::beauty, i, values.data() + i * 4);
      resolve_pixel(Aov::alpha, i, values.data() + i * 4 + 3);
    }
  });
  return values;
}

uint64_t Film::total_samples() const {
  uint64_t total = 0;
  for (const PixelSum& sum : sums_) total += sum.samples;
  return total;
}

size_t Film::memory_bytes() const {
  return sums_.size() * sizeof(PixelSum) + luminance_.size() * sizeof(Moments) + surfaces_.size() * sizeof(SurfaceSum) +
         blocks_.size() * sizeof(BlockSum);
}

} // namespace kindling
