// Tests of animation channels against hand-computed values.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/animation.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

std::vector<float> sample(const AnimationChannel& channel, double time_s) {
  std::vector<float> out(static_cast<size_t>(channel.components));
  sample_channel(channel, time_s, out);
  return out;
}

void expect_values(const std::vector<float>& found, const std::vector<float>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-6f) << "component " << i;
}

AnimationChannel translation(Interpolation interpolation) {
  AnimationChannel channel;
  channel.node = 0;
  channel.interpolation = interpolation;
  channel.times_s = {1.0f, 2.0f, 4.0f};
  channel.values = {0, 0, 0, 10, 20, 30, 12, 20, 26};
  return channel;
}

AnimationChannel rotation(std::vector<float> times, std::vector<float> values, Interpolation interpolation) {
  AnimationChannel channel;
  channel.node = 0;
  channel.property = AnimatedProperty::rotation;
  channel.interpolation = interpolation;
  channel.components = 4;
  channel.times_s = std::move(times);
  channel.values = std::move(values);
  return channel;
}

// Returns the quaternion (x, y, z, w) of a rotation about z.
std::vector<float> about_z(float degrees) {
  const float half = degrees * kPi / 360.0f;
  return {0.0f, 0.0f, std::sin(half), std::cos(half)};
}

std::vector<float> concatenate(std::initializer_list<std::vector<float>> parts) {
  std::vector<float> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST(Animation, StepHoldsPreviousKey) {
  const AnimationChannel channel = translation(Interpolation::step);
  expect_values(sample(channel, 1.0), {0, 0, 0});
  expect_values(sample(channel, 1.999), {0, 0, 0});
  expect_values(sample(channel, 2.0), {10, 20, 30});
  expect_values(sample(channel, 3.999), {10, 20, 30});
  expect_values(sample(channel, 4.0), {12, 20, 26});
}

TEST(Animation, LinearInterpolatesBetweenUnevenKeys) {
  const AnimationChannel channel = translation(Interpolation::linear);
  expect_values(sample(channel, 1.25), {2.5f, 5.0f, 7.5f});
  expect_values(sample(channel, 2.5), {10.5f, 20.0f, 29.0f});
  expect_values(sample(channel, 2.0), {10, 20, 30});
}

TEST(Animation, ClampsTimeToFirstAndLastKey) {
  for (const auto mode : {Interpolation::step, Interpolation::linear}) {
    const AnimationChannel channel = translation(mode);
    expect_values(sample(channel, -5.0), {0, 0, 0});
    expect_values(sample(channel, 0.5), {0, 0, 0});
    expect_values(sample(channel, 100.0), {12, 20, 26});
  }
}

TEST(Animation, SingleKeyIsConstant) {
  for (const auto mode : {Interpolation::step, Interpolation::linear}) {
    AnimationChannel channel;
    channel.interpolation = mode;
    channel.times_s = {1.0f};
    channel.values = {7, 8, 9};
    for (const double t : {0.0, 1.0, 2.0}) expect_values(sample(channel, t), {7, 8, 9});
  }
  AnimationChannel spline;
  spline.interpolation = Interpolation::cubic_spline;
  spline.times_s = {1.0f};
  spline.values = {1, 1, 1, 7, 8, 9, 2, 2, 2};
  for (const double t : {0.0, 1.0, 2.0}) expect_values(sample(spline, t), {7, 8, 9});
}

TEST(Animation, CubicSplineMatchesSpecification) {
  AnimationChannel channel;
  channel.property = AnimatedProperty::weights;
  channel.components = 1;
  channel.interpolation = Interpolation::cubic_spline;
  channel.times_s = {1.0f, 3.0f};
  // In-tangent, value and out-tangent of each key.
  channel.values = {100, 2, 0.5f, -1.5f, 6, 100};
  expect_values(sample(channel, 1.0), {2});
  expect_values(sample(channel, 3.0), {6});
  // t = 0.25, duration 2: h00 = 0.84375, h10 = 0.140625, h01 = 0.15625, h11 = -0.046875
  expect_values(sample(channel, 1.5), {0.84375f * 2 + 2 * 0.140625f * 0.5f + 0.15625f * 6 + 2 * -0.046875f * -1.5f});
  // Outside of the keys: the values, never the tangents.
  expect_values(sample(channel, 0.0), {2});
  expect_values(sample(channel, 9.0), {6});
}

TEST(Animation, SlerpHasConstantSpeed) {
  const auto channel = rotation({0, 1}, concatenate({about_z(0), about_z(120)}), Interpolation::linear);
  expect_values(sample(channel, 0.25), about_z(30));
  expect_values(sample(channel, 0.5), about_z(60));
  expect_values(sample(channel, 0.9), about_z(108));
}

TEST(Animation, SlerpTakesShorterArc) {
  std::vector<float> negated = about_z(60);
  for (float& c : negated) c = -c; // the same rotation with opposite sign
  const auto channel = rotation({0, 1}, concatenate({about_z(0), negated}), Interpolation::linear);
  const std::vector<float> half_way = sample(channel, 0.5);
  const std::vector<float> expected = about_z(30);
  float dot = 0.0f;
  for (size_t c = 0; c < 4; ++c) dot += half_way[c] * expected[c];
  EXPECT_NEAR(std::abs(dot), 1.0f, 1e-6f);

  // 350 degrees equal -10 degrees: the middle is -5.
  const auto wrap = rotation({0, 1}, concatenate({about_z(0), about_z(350)}), Interpolation::linear);
  const std::vector<float> wrapped = sample(wrap, 0.5);
  EXPECT_NEAR(std::abs(wrapped[2]), std::sin(2.5f * kPi / 180.0f), 1e-6f);
  EXPECT_LT(wrapped[2] * wrapped[3], 0.0f); // negative rotation
}

TEST(Animation, SlerpHandlesNearlyEqualRotations) {
  const auto same = rotation({0, 1}, concatenate({about_z(40), about_z(40)}), Interpolation::linear);
  expect_values(sample(same, 0.3), about_z(40));
  const auto close = rotation({0, 1}, concatenate({about_z(40), about_z(40.01f)}), Interpolation::linear);
  expect_values(sample(close, 0.5), about_z(40.005f));
}

TEST(Animation, RotationsAreNormalized) {
  // Keys of half the length, as an exaggerated case of quantized files, in all modes.
  std::vector<float> short_key = about_z(90);
  for (float& c : short_key) c *= 0.5f;
  const auto step = rotation({0, 1}, concatenate({short_key, short_key}), Interpolation::step);
  expect_values(sample(step, 0.5), about_z(90));
  const auto linear = rotation({0, 1}, concatenate({about_z(0), short_key}), Interpolation::linear);
  expect_values(sample(linear, 0.5), about_z(45));

  const std::vector<float> zero(4, 0.0f);
  const auto spline =
      rotation({0, 2}, concatenate({zero, about_z(0), zero, zero, about_z(90), zero}), Interpolation::cubic_spline);
  // Halfway with flat tangents is the normalized mean of both keys, which is half the angle.
  expect_values(sample(spline, 1.0), about_z(45));
}

} // namespace
} // namespace kindling
