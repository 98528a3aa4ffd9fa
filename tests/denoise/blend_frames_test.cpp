// Blending of frames: what is added, what is left out, and how much noise remains.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/denoise/blend_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace kindling {
namespace {

constexpr int kWidth = 48, kHeight = 32;

// A frame whose pixels are functions of their position.
struct Frame {
  std::vector<float> rgba = std::vector<float>(4UL * kWidth * kHeight, 1.0f);
  std::vector<float> albedo = std::vector<float>(3UL * kWidth * kHeight, 0.5f);
  std::vector<float> normal = std::vector<float>(3UL * kWidth * kHeight, 0.6f);
  std::vector<float> motion = std::vector<float>(4UL * kWidth * kHeight, 0.0f);
  std::vector<float> samples;

  static size_t at(int x, int y) { return static_cast<size_t>(y) * kWidth + static_cast<size_t>(x); }
  void fill(const std::function<float(int, int)>& gray) {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (size_t c = 0; c < 3; ++c) rgba[4 * at(x, y) + c] = gray(x, y);
  }
  // All surfaces are `previous` further in the frame before, and came from `next` less in the frame
  // after.
  void move(const V2f& to_previous, const V2f& from_next) {
    for (size_t i = 0; i < motion.size(); i += 4) {
      motion[i] = to_previous.x, motion[i + 1] = to_previous.y;
      motion[i + 2] = from_next.x, motion[i + 3] = from_next.y;
    }
  }
  [[nodiscard]] NoisyFrame view() const { return {V2i(kWidth, kHeight), rgba, albedo, normal, motion, samples}; }
  [[nodiscard]] float gray(int x, int y) const { return rgba[4 * at(x, y)]; }
};

BlendedFrame blend(const std::vector<Frame>& frames, size_t center) {
  std::vector<NoisyFrame> views;
  for (const Frame& frame : frames) views.push_back(frame.view());
  return blend_frames(views, center);
}

float gray(const BlendedFrame& frame, int x, int y) { return frame.rgba[4 * Frame::at(x, y)]; }

std::vector<Frame> noisy_frames(size_t count, float mean, float deviation) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(mean, deviation);
  std::vector<Frame> frames(count);
  for (Frame& frame : frames) frame.fill([&](int, int) { return std::max(noise(random), 0.0f); });
  return frames;
}

double variance(const BlendedFrame& frame, float mean) {
  double sum = 0.0;
  for (size_t i = 0; i < frame.rgba.size(); i += 4) sum += std::pow(static_cast<double>(frame.rgba[i] - mean), 2);
  return sum / (kWidth * kHeight);
}

TEST(BlendFrames, NoiseFallsWithTheNumberOfFrames) {
  const std::vector<Frame> frames = noisy_frames(5, 1.0f, 0.2f);
  const BlendedFrame blended = blend(frames, 2);
  // A twentieth of the windows have t^2 > 4 by chance.
  EXPECT_GT(blended.mean_frames, 4.5);
  EXPECT_LE(blended.mean_frames, 5.0);
  EXPECT_NEAR(variance(blended, 1.0f), 0.04 / 5.0, 0.04 / 50.0);
  EXPECT_EQ(blend({frames[0]}, 0).rgba, frames[0].rgba);
  EXPECT_EQ(blend({frames[0]}, 0).mean_frames, 1.0);
}

TEST(BlendFrames, FollowsTheMotion) {
  // A ramp that moves 3 pixels to the right and 2 up from frame to frame. Motion is upwards.
  std::vector<Frame> frames(3);
  for (int f = 0; f < 3; ++f) {
    frames[static_cast<size_t>(f)].fill(
        [&](int x, int y) { return 100.0f + static_cast<float>(x - 3 * f) + 50.0f * static_cast<float>(y + 2 * f); });
    frames[static_cast<size_t>(f)].move(V2f(-3, -2), V2f(-3, -2));
  }
  const BlendedFrame blended = blend(frames, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) EXPECT_FLOAT_EQ(gray(blended, x, y), frames[1].gray(x, y)) << x << " " << y;
  EXPECT_GT(blended.mean_frames, 2.5) << "all but the edges have three frames";
  // Through two frames: the first one as seen from the last.
  EXPECT_GT(blend(frames, 2).mean_frames, 2.5);
  EXPECT_FLOAT_EQ(gray(blend(frames, 2), 20, 10), frames[2].gray(20, 10));
}

TEST(BlendFrames, HiddenPointsAreLeftOut) {
  // The previous frame's surface there comes from elsewhere: the way back leads to another pixel.
  std::vector<Frame> frames(2);
  frames[0].fill([](int, int) { return 5.0f; });
  frames[0].move(V2f(0, 0), V2f(4, 0));
  EXPECT_EQ(blend(frames, 1).rgba, frames[1].rgba);
}

TEST(BlendFrames, OtherSurfacesAreLeftOut) {
  std::vector<Frame> frames(2);
  std::fill(frames[0].albedo.begin(), frames[0].albedo.end(), 0.9f);
  EXPECT_NEAR(blend(frames, 1).mean_frames, 1.0, 1e-3) << "albedo";
  frames[0].albedo = frames[1].albedo;
  std::fill(frames[0].normal.begin(), frames[0].normal.end(), -0.6f);
  EXPECT_NEAR(blend(frames, 1).mean_frames, 1.0, 1e-3) << "normal";
  frames[0].normal = frames[1].normal;
  for (size_t i = 3; i < frames[0].rgba.size(); i += 4) frames[0].rgba[i] = 0.0f;
  EXPECT_NEAR(blend(frames, 1).mean_frames, 1.0, 1e-3) << "alpha";
}

TEST(BlendFrames, PixelsWithoutASurfaceStay) {
  std::vector<Frame> frames = noisy_frames(2, 1.0f, 0.2f);
  for (Frame& frame : frames) std::fill(frame.normal.begin(), frame.normal.end(), 0.0f);
  EXPECT_EQ(blend(frames, 1).rgba, frames[1].rgba);
  for (Frame& frame : frames) frame.normal.clear(); // unknown
  EXPECT_GT(blend(frames, 1).mean_frames, 1.8);
}

TEST(BlendFrames, TexturesAreThoseOfTheFrame) {
  // The same light on albedos that differ a little, as by parts of a pixel.
  std::vector<Frame> frames(2);
  std::fill(frames[0].albedo.begin(), frames[0].albedo.end(), 0.45f);
  frames[0].fill([](int, int) { return 0.5f; });
  frames[1].fill([](int, int) { return 0.55f; }); // (0.5 + 0.05) / (0.45 + 0.05)
  const BlendedFrame blended = blend(frames, 1);
  EXPECT_GT(blended.mean_frames, 1.3);
  EXPECT_NEAR(gray(blended, 7, 7), 0.55f, 1e-6f);
}

TEST(BlendFrames, ShadowsThatMoveAreNotDraggedAlong) {
  // The right half is half as bright in the frame before, with noise that hides no such difference.
  std::vector<Frame> frames = noisy_frames(2, 1.0f, 0.3f);
  for (int y = 0; y < kHeight; ++y)
    for (int x = kWidth / 2; x < kWidth; ++x)
      for (size_t c = 0; c < 3; ++c) frames[0].rgba[4 * Frame::at(x, y) + c] *= 0.5f;
  const BlendedFrame blended = blend(frames, 1);
  const auto changed = [&](int begin, int end) {
    int count = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = begin; x < end; ++x) count += gray(blended, x, y) != frames[1].gray(x, y) ? 1 : 0;
    return count;
  };
  EXPECT_EQ(changed(kWidth / 2 + 5, kWidth), 0);
  EXPECT_GT(changed(0, kWidth / 2 - 5), kHeight * (kWidth / 2 - 5) * 9 / 10);
}

TEST(BlendFrames, SamplesWeigh) {
  std::vector<Frame> frames = noisy_frames(2, 1.0f, 0.2f);
  frames[0].samples.assign(static_cast<size_t>(kWidth * kHeight), 3.0f);
  frames[1].samples.assign(static_cast<size_t>(kWidth * kHeight), 1.0f);
  const BlendedFrame blended = blend(frames, 1);
  int weighted = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const float mean = 0.25f * frames[1].gray(x, y) + 0.75f * frames[0].gray(x, y);
      weighted += std::abs(gray(blended, x, y) - mean) < 1e-5f ? 1 : 0;
    }
  EXPECT_GT(weighted, kWidth * kHeight * 9 / 10);
}

TEST(BlendFrames, ValuesThatAreNotFiniteDoNotSpread) {
  std::vector<Frame> frames = noisy_frames(3, 1.0f, 0.1f);
  frames[0].rgba[4 * Frame::at(10, 10)] = std::numeric_limits<float>::quiet_NaN();
  frames[2].rgba[4 * Frame::at(11, 10)] = std::numeric_limits<float>::infinity();
  frames[1].rgba[4 * Frame::at(20, 20)] = std::numeric_limits<float>::infinity();
  frames[0].motion[4 * Frame::at(30, 20)] = std::numeric_limits<float>::quiet_NaN();
  frames[1].motion[4 * Frame::at(31, 20)] = std::numeric_limits<float>::infinity();
  const BlendedFrame blended = blend(frames, 1);
  for (size_t i = 0; i < blended.rgba.size(); ++i) {
    if (i % 4 == 0 && i / 4 == Frame::at(20, 20)) continue;
    ASSERT_TRUE(std::isfinite(blended.rgba[i])) << i;
  }
  EXPECT_GT(blended.mean_frames, 2.7);
}

} // namespace
} // namespace kindling
