// Follows pixels from frame to frame, weighs them, and averages.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/denoise/blend_frames.h"

#include "renderer/base/elementary.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace kindling {

namespace {

constexpr float kMaxReturnPx = 1.0f;  // distance from a pixel at which the motion there and back may end
constexpr float kAlbedoWidth = 0.08f; // standard deviations of Gaussians of differences
constexpr float kNormalWidth = 0.2f;  // of the vectors
constexpr float kAlphaWidth = 0.1f;
constexpr float kAlbedoFloor = 0.05f; // below which colors are not relative to the albedo
constexpr int kTestRadius = 4;        // px
constexpr float kSurelyEqual = 4.0f;  // t^2 up to which colors count as equal
constexpr float kSurelyDifferent = 16.0f;
constexpr int32_t kLost = -1;

// Sums over squares of 2 radius + 1 pixels, cut at the edges of the image.
void sum_squares(std::vector<double>& values, const V2i& size_px, int radius) {
  const auto width = static_cast<size_t>(size_px.x), height = static_cast<size_t>(size_px.y);
  const auto sum_line = [&](size_t first, size_t step, size_t count, std::vector<double>& sums) {
    sums.assign(count + 1, 0.0);
    for (size_t i = 0; i < count; ++i) sums[i + 1] = sums[i] + values[first + i * step];
    const auto reach = static_cast<size_t>(radius);
    for (size_t i = 0; i < count; ++i)
      values[first + i * step] = sums[std::min(i + reach + 1, count)] - sums[i > reach ? i - reach : 0];
  };
  std::vector<double> sums;
  for (size_t y = 0; y < height; ++y) sum_line(y * width, 1, width, sums);
  for (size_t x = 0; x < width; ++x) sum_line(x, width, height, sums);
}

float squared_difference(std::span<const float> a, size_t pixel_a, std::span<const float> b, size_t pixel_b) {
  if (a.empty() || b.empty()) return 0.0f;
  float sum = 0.0f;
  for (size_t c = 0; c < 3; ++c) {
    const float difference = a[3 * pixel_a + c] - b[3 * pixel_b + c];
    sum += difference * difference;
  }
  return sum;
}

bool is_finite(std::span<const float> rgba, size_t pixel) {
  return std::isfinite(rgba[4 * pixel]) && std::isfinite(rgba[4 * pixel + 1]) && std::isfinite(rgba[4 * pixel + 2]);
}

double product(float a, float b) { return static_cast<double>(a) * static_cast<double>(b); }

// A pixel without a normal shows no surface: it has no noise that other frames could lower.
bool shows_surface(const NoisyFrame& frame, size_t pixel) {
  if (frame.normal.empty()) return true;
  return frame.normal[3 * pixel] != 0.0f || frame.normal[3 * pixel + 1] != 0.0f || frame.normal[3 * pixel + 2] != 0.0f;
}

float samples_of(const NoisyFrame& frame, size_t pixel) { return frame.samples.empty() ? 1.0f : frame.samples[pixel]; }

class Blend {
 public:
  Blend(std::span<const NoisyFrame> frames, size_t center)
      : frames_(frames), center_(frames[center]), at_(center), size_px_(center_.size_px),
        pixels_(static_cast<size_t>(size_px_.x) * static_cast<size_t>(size_px_.y)) {}

  BlendedFrame run() {
    find_white();
    std::vector<float> weights(pixels_);
    std::vector<double> sums(3 * pixels_);
    for (size_t i = 0; i < pixels_; ++i) {
      weights[i] = samples_of(center_, i);
      for (size_t c = 0; c < 3; ++c) sums[3 * i + c] = product(weights[i], center_.rgba[4 * i + c]);
    }
    double frames_used = static_cast<double>(pixels_);
    for (const int step : {-1, 1}) {
      start_at_center();
      for (size_t from = at_; step < 0 ? from > 0 : from + 1 < frames_.size(); from += static_cast<size_t>(step)) {
        const NoisyFrame& other = frames_[from + static_cast<size_t>(step)];
        follow(frames_[from], other, step);
        weigh(other);
        for (size_t i = 0; i < pixels_; ++i) {
          if (!(shares_[i] > 0.0f)) continue;
          const auto there = static_cast<size_t>(place_[i]);
          const float weight = shares_[i] * samples_of(other, there);
          for (size_t c = 0; c < 3; ++c) sums[3 * i + c] += product(weight, color(other, there, i, c));
          weights[i] += weight;
          frames_used += static_cast<double>(shares_[i]);
        }
      }
    }
    BlendedFrame blended{{center_.rgba.begin(), center_.rgba.end()}, frames_used / static_cast<double>(pixels_)};
    for (size_t i = 0; i < pixels_; ++i)
      if (weights[i] > samples_of(center_, i))
        for (size_t c = 0; c < 3; ++c)
          blended.rgba[4 * i + c] = static_cast<float>(sums[3 * i + c] / static_cast<double>(weights[i]));
    return blended;
  }

 private:
  // The mean of the frame's channels, relative to which differences of colors are judged.
  void find_white() {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < pixels_; ++i) {
      if (!is_finite(center_.rgba, i)) continue;
      for (size_t c = 0; c < 3; ++c) sum += static_cast<double>(std::max(center_.rgba[4 * i + c], 0.0f));
      ++count;
    }
    white_ = count > 0 && sum > 0.0 ? static_cast<float>(sum / (3.0 * static_cast<double>(count))) : 1.0f;
  }

  void start_at_center() {
    x_.resize(pixels_), y_.resize(pixels_), place_.resize(pixels_), shares_.resize(pixels_);
    for (size_t i = 0; i < pixels_; ++i) {
      x_[i] = static_cast<float>(i % static_cast<size_t>(size_px_.x));
      y_[i] = static_cast<float>(i / static_cast<size_t>(size_px_.x));
      place_[i] = is_finite(center_.rgba, i) && shows_surface(center_, i) ? static_cast<int32_t>(i) : kLost;
    }
  }

  // The way of a pixel to the frame before (step -1) or after (1); y downwards.
  static V2f way(const NoisyFrame& frame, size_t pixel, int step) {
    const float* const motion = &frame.motion[4 * pixel];
    return step < 0 ? V2f(motion[0], -motion[1]) : V2f(-motion[2], motion[3]);
  }

  // Moves positions from `frame` to `other`, and ends those that do not come back from there.
  void follow(const NoisyFrame& frame, const NoisyFrame& other, int step) {
    for (size_t i = 0; i < pixels_; ++i) {
      if (place_[i] == kLost) continue;
      const V2f there = way(frame, static_cast<size_t>(place_[i]), step);
      x_[i] += there.x;
      y_[i] += there.y;
      const float column = std::round(x_[i]), row = std::round(y_[i]);
      const bool inside = column >= 0.0f && row >= 0.0f && column < static_cast<float>(size_px_.x) &&
                          row < static_cast<float>(size_px_.y); // false for NaN
      if (!inside) {
        place_[i] = kLost;
        continue;
      }
      place_[i] = static_cast<int32_t>(row) * size_px_.x + static_cast<int32_t>(column);
      const V2f back = way(other, static_cast<size_t>(place_[i]), -step);
      if (!((there + back).length2() < kMaxReturnPx * kMaxReturnPx)) place_[i] = kLost;
    }
  }

  // A channel of another frame with the albedo of this one: textures are not shifted by parts of a
  // pixel.
  [[nodiscard]] float color(const NoisyFrame& other, size_t there, size_t pixel, size_t c) const {
    const float value = other.rgba[4 * there + c];
    if (other.albedo.empty() || center_.albedo.empty()) return value;
    const float ratio = (std::max(center_.albedo[3 * pixel + c], 0.0f) + kAlbedoFloor) /
                        (std::max(other.albedo[3 * there + c], 0.0f) + kAlbedoFloor);
    return std::isfinite(ratio) ? value * ratio : value;
  }

  // A difference of colors that highlights do not dominate.
  [[nodiscard]] double difference(const NoisyFrame& other, size_t pixel, size_t there) const {
    double sum = 0.0;
    for (size_t c = 0; c < 3; ++c)
      for (const auto& [value, sign] :
           {std::pair(color(other, there, pixel, c), 1.0), {center_.rgba[4 * pixel + c], -1.0}})
        sum += sign * static_cast<double>(std::max(value, 0.0f) / (std::max(value, 0.0f) + white_));
    return sum;
  }

  // Sets shares_ of the places in `other`, 0 to 1.
  void weigh(const NoisyFrame& other) {
    std::vector<double> count(pixels_), sum(pixels_), squares(pixels_);
    for (size_t i = 0; i < pixels_; ++i) {
      shares_[i] = 0.0f;
      if (place_[i] == kLost) continue;
      const auto there = static_cast<size_t>(place_[i]);
      if (!is_finite(other.rgba, there)) continue;
      const float alpha = (other.rgba[4 * there + 3] - center_.rgba[4 * i + 3]) / kAlphaWidth;
      const float exponent =
          squared_difference(center_.albedo, i, other.albedo, there) / (kAlbedoWidth * kAlbedoWidth) +
          squared_difference(center_.normal, i, other.normal, there) / (kNormalWidth * kNormalWidth) + alpha * alpha;
      const float share = elementary::exp(-0.5f * exponent);
      if (!(share > 0.0f)) continue;
      shares_[i] = share;
      const double d = difference(other, i, there);
      count[i] = static_cast<double>(share);
      sum[i] = count[i] * d;
      squares[i] = count[i] * d * d;
    }
    for (std::vector<double>* const values : {&count, &sum, &squares}) sum_squares(*values, size_px_, kTestRadius);
    for (size_t i = 0; i < pixels_; ++i) {
      if (!(shares_[i] > 0.0f)) continue;
      const double mean = sum[i] / count[i];
      const double variance = std::max(squares[i] / count[i] - mean * mean, 0.0) / count[i];
      constexpr double kRounding = 1e-8;
      const double t2 = mean * mean / (variance + kRounding);
      shares_[i] *=
          std::clamp((kSurelyDifferent - static_cast<float>(t2)) / (kSurelyDifferent - kSurelyEqual), 0.0f, 1.0f);
    }
  }

  std::span<const NoisyFrame> frames_;
  const NoisyFrame& center_;
  size_t at_;
  V2i size_px_;
  size_t pixels_;
  float white_ = 1.0f;
  // follow() moves every pixel of the center from frame to frame. The arrays have its state in the
  // frame that follow() reached last.
  std::vector<float> x_, y_;   // position
  std::vector<int32_t> place_; // pixel, or kLost
  std::vector<float> shares_;  // weight of its samples relative to the center's
};

} // namespace

BlendedFrame blend_frames(std::span<const NoisyFrame> frames, size_t center) {
  assert(center < frames.size());
  return Blend(frames, center).run();
}

} // namespace kindling
