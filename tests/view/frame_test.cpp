// Frames: false colors, histogram, encoded images, saved files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "renderer/view/frame.h"
#include "renderer/view/frame_header.h"
#include "renderer/view/view_server.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>

namespace kindling {
namespace {

LinearFrame gray_frame(float value, const V2i& size = V2i(8, 4)) {
  LinearFrame frame;
  frame.size_px = size;
  frame.rgba.assign(static_cast<size_t>(size.x * size.y) * 4, value);
  for (size_t i = 3; i < frame.rgba.size(); i += 4) frame.rgba[i] = 1.0f;
  frame.image.spp = frame.image.planned_spp = 4;
  return frame;
}

FrameDisplay standard_display() {
  FrameDisplay display;
  EXPECT_TRUE(display.choose("Standard", 0.0, "").ok());
  return display;
}

TEST(Frame, TurboGoesFromBlueToRed) {
  const auto low = turbo(0.1f), middle = turbo(0.5f), high = turbo(0.95f);
  EXPECT_GT(low[2], low[0]);
  EXPECT_GT(middle[1], middle[0]);
  EXPECT_GT(middle[1], middle[2]);
  EXPECT_GT(high[0], high[2]);
  EXPECT_EQ(turbo(-1.0f), turbo(0.0f));
  EXPECT_EQ(turbo(2.0f), turbo(1.0f));
}

TEST(Frame, HistogramCountsEveryPixelByStops) {
  const FrameDisplay display = standard_display();
  const auto bin_of = [&](float value) {
    const Result<DisplayedFrame> shown = display.display(gray_frame(value), ViewState{}, nullptr);
    EXPECT_TRUE(shown.ok());
    const auto& bins = shown.value().histogram;
    EXPECT_EQ(std::accumulate(bins.begin(), bins.end(), 0U), 32U);
    return std::max_element(bins.begin(), bins.end()) - bins.begin();
  };
  EXPECT_EQ(bin_of(1.0f), 40); // 10 of 16 stops
  EXPECT_EQ(bin_of(2.0f), 44);
  EXPECT_EQ(bin_of(0.0f), 0);
  EXPECT_EQ(bin_of(1e30f), 63);
  EXPECT_EQ(bin_of(-1.0f), 0);
}

TEST(Frame, FalseColorsAndHistogramShowTheDenoisedImage) {
  ASSERT_EQ(setenv("KINDLING_OIDN", KINDLING_FAKE_OIDN, 1), 0);
  const Result<Denoiser> denoiser = Denoiser::open(1);
  unsetenv("KINDLING_OIDN");
  ASSERT_TRUE(denoiser.ok()) << denoiser.error().message;
  const FrameDisplay display = standard_display();
  LinearFrame frame = gray_frame(1.0f);
  frame.albedo.assign(32 * 3, 0.0f);
  frame.normal.assign(32 * 3, 0.0f);
  for (const bool false_color : {false, true}) {
    const auto shown = [&](bool denoise) {
      return display.display(frame, {.false_color = false_color, .denoise = denoise}, &denoiser.value()).value();
    };
    const DisplayedFrame noisy = shown(false), denoised = shown(true); // the stand-in halves colors
    EXPECT_TRUE(noisy.denoised.empty());
    ASSERT_EQ(denoised.denoised.size(), frame.rgba.size());
    EXPECT_EQ(denoised.denoised[0], 0.5f);
    EXPECT_EQ(noisy.histogram[40], 32U) << "luminance 1";
    EXPECT_EQ(denoised.histogram[36], 32U) << "luminance 1/2";
    EXPECT_EQ(noisy.range[0], false_color ? 1.0f : 0.0f);
    EXPECT_EQ(denoised.range[0], false_color ? 0.5f : 0.0f);
  }
  frame.state.shown = Aov::albedo; // that is not denoised
  frame.shown = frame.albedo;
  EXPECT_TRUE(display.display(frame, {.denoise = true}, &denoiser.value()).value().denoised.empty());
}

TEST(Frame, PixelsHaveTheirDenoisedColorToo) {
  const LinearFrame frame = gray_frame(0.5f);
  const auto noisy = nlohmann::json::parse(describe_pixel(frame, V2i(1, 2), std::nullopt, nullptr));
  EXPECT_EQ(noisy["rgb"][0], 0.5);
  EXPECT_FALSE(noisy.contains("denoised"));
  const auto both = nlohmann::json::parse(describe_pixel(frame, V2i(1, 2), Rgb(0.25f, 1, 2), nullptr));
  EXPECT_EQ(both["rgb"][0], 0.5);
  EXPECT_EQ(both["denoised"], nlohmann::json({0.25, 1.0, 2.0}));
}

TEST(Frame, EncodesAllKindsOfImages) {
  const FrameDisplay display = standard_display();
  for (const AovInfo& info : kAovs) {
    LinearFrame frame = gray_frame(0.5f);
    frame.state.shown = info.aov;
    if (info.aov != Aov::beauty) {
      frame.shown.assign(32 * static_cast<size_t>(info.channels), 0.25f);
      frame.shown[0] = std::numeric_limits<float>::quiet_NaN();
      frame.shown[1] = 1000.0f;
    }
    for (const bool false_color : {false, true}) {
      const Result<DisplayedFrame> shown = display.display(frame, ViewState{.false_color = false_color}, nullptr);
      ASSERT_TRUE(shown.ok()) << info.name;
      EXPECT_EQ(shown.value().jpeg.substr(0, 2), "\xff\xd8") << info.name;
    }
  }
}

TEST(Frame, HeaderIsJson) {
  const LinearFrame frame = gray_frame(0.5f);
  const Result<DisplayedFrame> shown = standard_display().display(frame, ViewState{}, nullptr);
  const HeaderFacts facts{.status = "rendering", .error = "a \"name\" with \xff", .camera = {}, .command = "kindling"};
  const auto header = nlohmann::json::parse(header_json(ViewState{}, &frame, &shown.value(), facts, 7, 5));
  EXPECT_EQ(header["version"], 7);
  EXPECT_EQ(header["image"], 5);
  EXPECT_EQ(header["frame"]["samples"], 4);
  EXPECT_TRUE(nlohmann::json::parse(header_json(ViewState{}, nullptr, nullptr, facts, 1, 0))["frame"].is_null());
}

TEST(Frame, CamerasBecomeOrbitsAndBack) {
  for (const V3f& angles : {V3f(0, 90, 1), V3f(33, 20, 4), V3f(-170, 150, 0.25f)}) {
    const PlacedCamera placed = orbit_camera({angles.x, angles.y, angles.z, V3f(1, 2, 3), 40.0f});
    const CameraSeen seen = as_orbit(placed, angles.z);
    EXPECT_NEAR(seen.orbit.x, angles.x, 1e-3f);
    EXPECT_NEAR(seen.orbit.y, angles.y, 1e-3f);
    EXPECT_LT((seen.target - V3f(1, 2, 3)).length(), 1e-5f);
    EXPECT_NEAR(seen.yfov_deg, 40.0, 1e-4);
  }
  PlacedCamera flat = orbit_camera({0, 90, 2, V3f(0), 40});
  flat.camera.kind = SceneCamera::Kind::orthographic;
  flat.camera.ymag = 2.0f;
  EXPECT_NEAR(as_orbit(flat, 2.0).yfov_deg, 90.0, 1e-4) << "the same height at the target";
  EXPECT_EQ(as_orbit(flat, 2.0).orthographic_m, 4.0);
  EXPECT_FALSE(as_orbit(orbit_camera({}), 2.0).orthographic_m.has_value());
}

TEST(Frame, CamerasKeepTheirRoll) {
  for (const V3f& angles : {V3f(0, 90, 1), V3f(33, 20, 4), V3f(-170, 150, 0.25f), V3f(80, 90, 3)})
    for (const double roll_deg : {0.0, 15.0, -100.0, 179.0}) {
      const V3f target(1, 2, 3);
      const PlacedCamera level = orbit_camera({angles.x, angles.y, angles.z, target, 40.0f});
      const M44f& m = level.camera_to_world;
      const PlacedCamera rolled = turn_camera(level, roll_deg, V3f(m[2][0], m[2][1], m[2][2]), target);
      const CameraSeen seen = as_orbit(rolled, angles.z);
      EXPECT_NEAR(seen.roll_deg, roll_deg, 1e-2) << angles.x;
      EXPECT_TRUE(roll_deg != 0.0 || seen.roll_deg == 0.0) << "rounding is no roll";
      // The settings that a page makes of it show the same.
      ViewState state{.size_px = V2i(64, 48)};
      state.camera.orbit = seen.orbit;
      state.camera.target = seen.target;
      state.camera.roll_deg = seen.roll_deg;
      const ImageSettings image = image_settings(state, {});
      PlacedCamera again = orbit_camera({image.orbit->x, image.orbit->y, image.orbit->z, image.target, 40.0f});
      if (image.turn) again = turn_camera(again, image.turn->angle_deg, image.turn->axis, *image.turn->around);
      EXPECT_TRUE(again.camera_to_world.equalWithAbsError(rolled.camera_to_world, 1e-4f))
          << angles.x << " " << roll_deg;
    }
}

TEST(Frame, QueriesHaveNumbersInRange) {
  EXPECT_EQ(query_number("x=0.5&y=1", "y", 1.0), 1.0);
  EXPECT_EQ(query_number("xy=3&y=0.25", "y", 1.0), 0.25);
  for (const char* query : {"", "y", "y=", "y=-1", "y=2", "y=nan", "y=inf", "y=1x", "x=1"})
    EXPECT_FALSE(query_number(query, "y", 1.0)) << query;
}

} // namespace
} // namespace kindling
