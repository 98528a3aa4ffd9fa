// Resolution of a film's sums: means of pixels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/film.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

namespace {

// Returns the divisor of a sum of weighted values, which is positive.
double divisor(double weight, uint64_t count) { return weight > 0.0 ? weight : static_cast<double>(count); }

double mean_luminance(const PixelSum& sum, double by) {
  return (0.2126 * sum.rgb[0].value() + 0.7152 * sum.rgb[1].value() + 0.0722 * sum.rgb[2].value()) / by;
}

template <typename Sum>
void store_mean(const Sum (&sum)[3], double by, float* out) {
  for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c].value() / by);
}

// The mean of samples plus that of light paths.
template <typename Sum>
void store_mean(const Sum (&sum)[3], double by, const Sum (&splats)[3], double light_paths, float* out) {
  for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c].value() / by + splats[c].value() / light_paths);
}

// Returns the variance of the mean r = sum(w y) / sum(w). To first order it is
// sum(w^2 (y - r)^2) / sum(w)^2 (Cochran, "Sampling Techniques", 3rd ed., section 6.4), times
// n / (n - 1). With equal weights that is exactly the unbiased s^2 / n.
double variance_of_mean(const PixelSum& sum, const MomentSum& y, double mean) {
  if (sum.samples < 2) return 0.0;
  const auto n = static_cast<double>(sum.samples);
  const double by = divisor(sum.weight.value(), sum.samples);
  const double squares = y.w2_y2.value() - 2.0 * mean * y.w2_y.value() + mean * mean * y.w2.value();
  return std::max(squares, 0.0) / (by * by) * n / (n - 1.0);
}

} // namespace

std::optional<Rgb> Film::trimmed(size_t index) const {
  std::array<BlockSum, kOutlierBlocks> blocks;
  const PixelSum& sum = sums_[index];
  ColorSum last{{sum.rgb[0], sum.rgb[1], sum.rgb[2]}, sum.weight};
  const auto values = [](const ColorSum& block) {
    return BlockSum{{block.rgb[0].value(), block.rgb[1].value(), block.rgb[2].value()}, block.weight.value()};
  };
  for (size_t i = 0; i + 1 < kOutlierBlocks; ++i) {
    const ColorSum& block = blocks_[index * (kOutlierBlocks - 1) + i];
    last.subtract(block);
    blocks[i] = values(block);
  }
  blocks[kOutlierBlocks - 1] = values(last);
  return outliers_trimmed(blocks);
}

// Returns false for AOVs of other planes.
bool Film::resolve_surface(Aov aov, size_t index, double by, float* out) const {
  const auto hits = [](const SurfaceSum& surface) { return divisor(surface.hit_weight.value(), surface.hits); };
  switch (aov) {
  case Aov::albedo:
    if (!surfaces_.empty()) store_mean(surfaces_[index].albedo, by, out);
    return true;
  case Aov::normal:
    if (!surfaces_.empty()) store_mean(surfaces_[index].normal, by, out);
    return true;
  case Aov::denoising_albedo:
    if (!guides_.empty()) store_mean(guides_[index].albedo, by, out);
    return true;
  case Aov::denoising_normal:
    if (!guides_.empty()) store_mean(guides_[index].normal, by, out);
    return true;
  case Aov::depth:
    if (!surfaces_.empty() && surfaces_[index].hits > 0)
      out[0] = static_cast<float>(surfaces_[index].depth.value() / hits(surfaces_[index]));
    return true;
  case Aov::position:
    if (!surfaces_.empty() && surfaces_[index].hits > 0)
      store_mean(surfaces_[index].position, hits(surfaces_[index]), out);
    return true;
  default: return false;
  }
}

void Film::resolve_pixel(Aov aov, size_t index, double light_paths, float* out) const {
  const PixelSum& sum = sums_[index];
  if (sum.samples == 0) return;
  const double by = divisor(sum.weight.value(), sum.samples);
  switch (aov) {
  case Aov::beauty:
    if (trims_outliers())
      if (const std::optional<Rgb> mean = trimmed(index)) {
        for (int c = 0; c < 3; ++c) out[c] = (*mean)[c];
        return;
      }
    if (light_paths > 0.0)
      store_mean(sum.rgb, by, splats_[splat_index_at(index)].rgb, light_paths, out);
    else
      store_mean(sum.rgb, by, out);
    return;
  // Negative lobes of the filter can move means at edges out of [0, 1].
  case Aov::alpha: out[0] = static_cast<float>(std::clamp(opacity(index) / by, 0.0, 1.0)); return;
  case Aov::samples: out[0] = static_cast<float>(sum.samples); return;
  case Aov::variance:
    if (!moments_.empty()) out[0] = static_cast<float>(variance_of_mean(sum, moments_[index], mean_luminance(sum, by)));
    return;
  default: break;
  }
  if (resolve_surface(aov, index, by, out)) return;
  switch (aov) {
  case Aov::emission:
    if (!components_.empty()) store_mean(components_[index].emission, by, out);
    return;
  case Aov::direct:
    if (!components_.empty()) store_mean(components_[index].direct, by, out);
    return;
  case Aov::indirect:
    for (int c = 0; c < 3 && !components_.empty(); ++c) {
      const double beauty = sum.rgb[c].value();
      const double emission = components_[index].emission[c].value(), direct = components_[index].direct[c].value();
      const double difference = beauty - emission - direct;
      // Radiance was summed in single precision; differences within its rounding count as 0.
      const double rounding = 1e-6 * (std::abs(beauty) + std::abs(emission) + std::abs(direct));
      const double of_samples = std::abs(difference) <= rounding ? 0.0 : difference / by;
      const double of_splats = light_paths > 0.0 ? splats_[splat_index_at(index)].rgb[c].value() / light_paths : 0.0;
      out[c] = static_cast<float>(of_samples + of_splats);
    }
    return;
  default: break;
  }
  if (is_light_pass(aov))
    resolve_light(aov, index, light_paths, out);
  else if (is_of_nearest(aov) && !nearest_.empty())
    nearest_[index].resolve(aov, out);
  else if (aov == Aov::shadow_catcher && !catchers_.empty())
    resolve_behind(index, by, out);
}

// Sum of weights times what hides a background; a shadow does in part.
double Film::opacity(size_t index) const {
  const double objects = sums_[index].alpha.value();
  return catchers_.empty() ? objects : objects + catchers_[index].weight.value() * catchers_[index].shadow();
}

void Film::resolve_behind(size_t index, double by, float* out) const {
  const CatcherSum& caught = catchers_[index];
  const double background = by - sums_[index].alpha.value() - caught.weight.value();
  for (int c = 0; c < 3; ++c)
    out[c] = static_cast<float>(std::max(background + caught.weight.value() * caught.lit(c), 0.0) / by);
}

void Film::resolve_light(Aov aov, size_t index, double light_paths, float* out) const {
  const double by = divisor(sums_[index].weight.value(), sums_[index].samples);
  switch (aov) {
  case Aov::diffuse_color:
    if (!colors_.empty()) store_mean(colors_[index].diffuse, by, out);
    return;
  case Aov::glossy_color:
    if (!colors_.empty()) store_mean(colors_[index].glossy, by, out);
    return;
  case Aov::transmission_color:
    if (!colors_.empty()) store_mean(colors_[index].transmission, by, out);
    return;
  default: break;
  }
  const size_t pass = static_cast<size_t>(aov) - static_cast<size_t>(Aov::diffuse_direct);
  assert(aov >= Aov::diffuse_direct && pass < kLightPassCount);
  if (pass_places_.of_pass[pass] == kNotStored) return;
  const RadianceSum& sum = passes_[index * pass_places_.count + pass_places_.of_pass[pass]];
  const auto* const of_splats = std::find(kSplatPasses.begin(), kSplatPasses.end(), static_cast<LightPass>(pass));
  if (of_splats == kSplatPasses.end() || !(light_paths > 0.0)) {
    store_mean(sum.rgb, by, out);
    return;
  }
  const size_t slot = splat_slots_[static_cast<size_t>(of_splats - kSplatPasses.begin())];
  store_mean(sum.rgb, by, splat_passes_[splat_index_at(index) * splat_pass_count_ + slot].rgb, light_paths, out);
}

std::vector<float> Film::resolve(Aov aov) const {
  const auto channels = static_cast<size_t>(aov_info(aov).channels);
  std::vector<float> values(sums_.size() * channels, 0.0f);
  const double paths = light_paths();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) resolve_pixel(aov, i, paths, values.data() + i * channels);
  });
  return values;
}

std::vector<float> Film::resolve_light_group(size_t group) const {
  assert(group < light_groups_.size());
  std::vector<float> values(sums_.size() * 3, 0.0f);
  const double paths = light_paths();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const PixelSum& sum = sums_[i];
      if (sum.samples == 0) continue;
      const double by = divisor(sum.weight.value(), sum.samples);
      const RadianceSum& of_samples = groups_[i * light_groups_.size() + group];
      if (paths > 0.0)
        store_mean(of_samples.rgb, by, splat_groups_[splat_index_at(i) * light_groups_.size() + group].rgb, paths,
                   values.data() + i * 3);
      else
        store_mean(of_samples.rgb, by, values.data() + i * 3);
    }
  });
  return values;
}

std::vector<float> Film::resolve_rgba() const {
  std::vector<float> values(sums_.size() * 4, 0.0f);
  const double paths = light_paths();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      resolve_pixel(Aov::beauty, i, paths, values.data() + i * 4);
      resolve_pixel(Aov::alpha, i, paths, values.data() + i * 4 + 3);
    }
  });
  return values;
}

std::vector<float> Film::resolve_rgba(const PixelRect& rect) const {
  assert(crop_.contains(rect));
  std::vector<float> values(static_cast<size_t>(rect.pixel_count()) * 4, 0.0f);
  const double paths = light_paths();
  float* out = values.data();
  for (int y = rect.min.y; y < rect.max.y; ++y)
    for (int x = rect.min.x; x < rect.max.x; ++x, out += 4) {
      resolve_pixel(Aov::beauty, index_of({x, y}), paths, out);
      resolve_pixel(Aov::alpha, index_of({x, y}), paths, out + 3);
    }
  return values;
}

std::vector<float> Film::resolve_matte(Matte matte, int levels) const {
  const size_t channels = 2 * static_cast<size_t>(levels);
  std::vector<float> values(sums_.size() * channels, 0.0f);
  if (!aovs_.contains(matte)) return values;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sums_.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
    std::vector<MatteTerm> terms;
    for (size_t i = range.begin(); i != range.end(); ++i) {
      if (sums_[i].samples == 0) continue;
      mattes_.list(i, terms);
      rank_mattes(terms, matte, divisor(sums_[i].weight.value(), sums_[i].samples),
                  std::span(values).subspan(i * channels, channels));
    }
  });
  return values;
}

} // namespace kindling
