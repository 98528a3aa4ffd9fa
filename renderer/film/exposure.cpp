// Measures the brightness of films.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/exposure.h"

#include "renderer/base/elementary_double.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace kindling {

namespace {

constexpr double kMiddleGray = 0.18;
constexpr double kMaxStops = 16.0;
// The log average skips pixels below this part of the mean, for example a black background.
constexpr double kBlack = 1e-4;

} // namespace

ImageBrightness measure_brightness(const Film& film) { return measure_brightness(film.resolve_rgba()); }

ImageBrightness measure_brightness(std::span<const float> rgba) {
  std::vector<double> luminances;
  luminances.reserve(rgba.size() / 4);
  for (size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = rgba[i + 3];
    const double value = luminance(Rgb(rgba[i], rgba[i + 1], rgba[i + 2])) / static_cast<double>(alpha);
    if (alpha > 0.0f && std::isfinite(value)) luminances.push_back(std::max(value, 0.0));
  }
  ImageBrightness result;
  if (luminances.empty()) return result;
  const auto count = static_cast<double>(luminances.size());
  for (const double value : luminances) result.mean += value;
  result.mean /= count;
  if (result.mean <= 0.0) return result;
  double logs = 0.0;
  size_t logs_count = 0;
  for (const double value : luminances) {
    if (value <= kBlack * result.mean) continue;
    logs += elementary::log(value);
    ++logs_count;
  }
  result.log_average = elementary::exp(logs / static_cast<double>(logs_count));
  return result;
}

double auto_exposure_stops(const ImageBrightness& brightness) {
  if (!(brightness.log_average > 0.0)) return 0.0;
  const double stops = elementary::log2(kMiddleGray / brightness.log_average);
  return std::clamp(std::round(10.0 * stops) / 10.0, -kMaxStops, kMaxStops);
}

} // namespace kindling
