// Films to pixels, pixels to JPEG.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/frame.h"

#include "renderer/image/write_image.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling {

namespace {

constexpr int kMovingQuality = 80, kStaticQuality = 94; // of JPEG

// Calls body(first pixel, end) for parts of an image, in parallel.
template <typename Body>
void for_pixels(size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 16384),
                    [&](const auto& range) { body(range.begin(), range.end()); });
}

float luminance_of(const float* rgb) { return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]; }

void count_luminances(const std::vector<float>& rgba, DisplayedFrame& result) {
  constexpr float kBinsPerStop = kHistogramBins / (kHistogramMaxStops - kHistogramMinStops);
  for (size_t i = 0; i + 3 < rgba.size(); i += 4) {
    const float value = luminance_of(&rgba[i]);
    const float stops = value > 0.0f ? std::log2(value) : kHistogramMinStops;
    const float bin = std::clamp((stops - kHistogramMinStops) * kBinsPerStop, 0.0f, kHistogramBins - 1.0f);
    ++result.histogram[static_cast<size_t>(bin)];
  }
}

// Rows of false colors. Values are shown between the 1st and 99th percentile of those above 0, or
// by their logarithm if these differ by more than a factor of 50.
std::vector<float> false_colors(const std::vector<float>& values, std::array<float, 2>& range) {
  std::vector<float> sorted;
  sorted.reserve(values.size());
  for (const float value : values)
    if (std::isfinite(value) && value > 0.0f) sorted.push_back(value);
  float low = 0.0f, high = 1.0f;
  if (!sorted.empty()) {
    const auto percentile = [&](size_t percent) {
      const auto at = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) * percent / 100);
      std::nth_element(sorted.begin(), at, sorted.end());
      return *at;
    };
    low = percentile(1);
    high = std::max(percentile(99), low * 1.0001f);
  }
  range = {low, high};
  const bool logarithmic = low > 0.0f && high > 50.0f * low;
  std::vector<float> rgb(values.size() * 3);
  for_pixels(values.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float value = values[i];
      if (!(value > 0.0f)) continue; // black: no surface
      const float t = logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
      const std::array<float, 3> color = turbo(t);
      std::copy(color.begin(), color.end(), &rgb[3 * i]);
    }
  });
  return rgb;
}

std::vector<float> luminances(const std::vector<float>& pixels, size_t channels) {
  std::vector<float> result(pixels.size() / channels);
  for (size_t i = 0; i < result.size(); ++i) result[i] = luminance_of(&pixels[i * channels]);
  return result;
}

// RGBA through the view, composited over black.
std::vector<float> through_view(std::vector<float> rgba, const DisplayTransform& transform) {
  const size_t count = rgba.size() / 4;
  std::vector<float> rgb(count * 3);
  for_pixels(count, [&](size_t begin, size_t end) {
    transform.apply(std::span(rgba).subspan(begin * 4, (end - begin) * 4));
    for (size_t i = begin; i < end; ++i) std::copy_n(&rgba[4 * i], 3, &rgb[3 * i]);
  });
  return rgb;
}

std::vector<float> as_rgba(const std::vector<float>& rgb) {
  std::vector<float> rgba(rgb.size() / 3 * 4, 1.0f);
  for (size_t i = 0; i < rgb.size() / 3; ++i) std::copy_n(&rgb[3 * i], 3, &rgba[4 * i]);
  return rgba;
}

// Positions by their place in the bounds of those that are seen.
std::vector<float> by_bounds(std::vector<float> positions) {
  Box3f box;
  const auto seen = [&](size_t i) {
    return positions[i] != 0.0f || positions[i + 1] != 0.0f || positions[i + 2] != 0.0f;
  };
  for (size_t i = 0; i + 2 < positions.size(); i += 3)
    if (seen(i)) box.extendBy(V3f(positions[i], positions[i + 1], positions[i + 2]));
  if (box.isEmpty()) return positions;
  const V3f size = box.size();
  for (size_t i = 0; i + 2 < positions.size(); i += 3)
    for (int c = 0; c < 3; ++c) {
      float& value = positions[i + static_cast<size_t>(c)];
      value = size[c] > 0.0f ? (value - box.min[c]) / size[c] : 0.0f;
    }
  return positions;
}

// Directions of motion as red and green, relative to the longest in the image.
std::vector<float> by_length(const std::vector<float>& vectors) {
  float longest = 0.0f;
  for (const float value : vectors) longest = std::max(longest, std::abs(value));
  std::vector<float> rgb(vectors.size() / 4 * 3, 0.5f);
  for (size_t i = 0; i < vectors.size() / 4 && longest > 0.0f; ++i)
    for (size_t c = 0; c < 2; ++c) rgb[3 * i + c] = 0.5f + 0.5f * vectors[4 * i + c] / longest;
  return rgb;
}

// Display values of the AOV that is shown.
std::vector<float> display_of_aov(const LinearFrame& frame, const ViewState& state, const DisplayTransform& transform,
                                  std::array<float, 2>& range) {
  const std::vector<float>& values = frame.shown;
  switch (frame.state.shown) {
  case Aov::normal:
  case Aov::denoising_normal: {
    std::vector<float> rgb(values);
    for (float& value : rgb) value = 0.5f + 0.5f * value;
    return rgb;
  }
  case Aov::position:
  case Aov::position_nearest: return by_bounds(values);
  case Aov::vector:
  case Aov::motion: return by_length(values);
  case Aov::alpha: {
    std::vector<float> rgb(values.size() * 3);
    for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = values[i / 3];
    return rgb;
  }
  case Aov::depth:
  case Aov::depth_nearest:
  case Aov::object_id:
  case Aov::material_id:
  case Aov::samples:
  case Aov::variance: return false_colors(values, range);
  default:
    return state.false_color ? false_colors(luminances(values, 3), range) : through_view(as_rgba(values), transform);
  }
}

} // namespace

std::array<float, 3> turbo(float t) {
  // Coefficients of the powers 0 to 5 of t.
  constexpr std::array<std::array<float, 6>, 3> kPolynomials{
      {{0.13572138f, 4.61539260f, -42.66032258f, 132.13108234f, -152.94239396f, 59.28637943f},
       {0.09140261f, 2.19418839f, 4.84296658f, -14.18503333f, 4.27729857f, 2.82956604f},
       {0.10667330f, 12.64194608f, -60.58204836f, 110.36276771f, -89.90310912f, 27.34824973f}}};
  t = std::clamp(t, 0.0f, 1.0f);
  std::array<float, 3> color{};
  for (size_t c = 0; c < 3; ++c) {
    float value = 0.0f;
    for (size_t power = 6; power-- > 0;) value = value * t + kPolynomials[c][power];
    color[c] = std::clamp(value, 0.0f, 1.0f);
  }
  return color;
}

LinearFrame make_linear_frame(const Film& film, const ViewState& state) {
  LinearFrame frame;
  frame.state = state;
  frame.size_px = V2i(film.crop().width(), film.crop().height());
  frame.rgba = film.resolve_rgba();
  if (state.shown != Aov::beauty) frame.shown = film.resolve(state.shown);
  if (film.aovs().contains(Aov::denoising_albedo) && film.aovs().contains(Aov::denoising_normal)) {
    frame.albedo = film.resolve(Aov::denoising_albedo);
    frame.normal = film.resolve(Aov::denoising_normal);
  }
  return frame;
}

Result<void> FrameDisplay::choose(const std::string& view, double exposure_stops, const std::string& ocio_config) {
  if (transform_ && view == view_ && exposure_stops == exposure_stops_ && ocio_config == config_) return {};
  Result<DisplayTransform> transform =
      DisplayTransform::create({view, static_cast<float>(exposure_stops), ocio_config});
  if (!transform.ok()) return transform.error();
  transform_.emplace(std::move(transform).value());
  view_ = view;
  config_ = ocio_config;
  exposure_stops_ = exposure_stops;
  return {};
}

Result<DisplayedFrame> FrameDisplay::display(const LinearFrame& frame, const ViewState& state,
                                             const Denoiser* denoiser) const {
  DisplayedFrame result;
  if (denoiser && state.denoise && frame.shown.empty() && !frame.albedo.empty()) {
    Result<std::vector<float>> denoised =
        denoiser->denoise({frame.size_px, frame.rgba, frame.albedo, frame.normal}, Denoising::fast, {});
    if (!denoised.ok()) return denoised.error();
    result.denoised = std::move(denoised).value();
  }
  const std::vector<float>& pixels = result.denoised.empty() ? frame.rgba : result.denoised;
  count_luminances(pixels, result);
  std::vector<float> rgb;
  if (!frame.shown.empty())
    rgb = display_of_aov(frame, state, *transform_, result.range);
  else if (state.false_color)
    rgb = false_colors(luminances(pixels, 4), result.range);
  else
    rgb = through_view(pixels, *transform_);
  Result<std::string> jpeg = encode_jpeg(rgb, frame.size_px, frame.moving ? kMovingQuality : kStaticQuality);
  if (!jpeg.ok()) return jpeg.error();
  result.jpeg = std::move(jpeg).value();
  return result;
}

} // namespace kindling
