// Tests of display transforms: published values of the views, and user configurations.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/display_transform.h"

#include "renderer/image/pbr_neutral.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <unistd.h>

namespace kindling {
namespace {

// The sRGB curve (IEC 61966-2-1).
float encode_srgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

// Clears $OCIO, so that the setting of the machine has no effect.
class Display : public testing::Test {
 protected:
  void SetUp() override {
    unsetenv("OCIO");
    path_ = testing::TempDir() + "kindling_display_" + std::to_string(getpid()) + ".ocio";
  }
  void TearDown() override {
    unsetenv("OCIO");
    std::filesystem::remove(path_);
  }

  // Writes a configuration in which linear Rec. 709 is named `linear_name` and the view Half halves
  // values.
  void write_config(const std::string& linear_name, const std::string& roles) const {
    std::ofstream(path_) << "ocio_profile_version: 2\n"
                            "roles: {" +
                                roles +
                                "}\n"
                                "file_rules:\n  - !<Rule> {name: Default, colorspace: raw}\n"
                                "displays:\n  Screen:\n"
                                "    - !<View> {name: Plain, colorspace: raw}\n"
                                "    - !<View> {name: Half, colorspace: half}\n"
                                "active_views: [Half, Plain]\n"
                                "colorspaces:\n"
                                "  - !<ColorSpace>\n    name: " +
                                linear_name +
                                "\n"
                                "  - !<ColorSpace>\n    name: raw\n"
                                "  - !<ColorSpace>\n    name: half\n"
                                "    from_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, "
                                "0, 0.5, 0, 0, 0, 0, 1]}\n";
  }

  std::string path_;
};

DisplayTransform make(const std::string& view, float stops = 0.0f, const std::string& config = "") {
  Result<DisplayTransform> transform = DisplayTransform::create({view, stops, config});
  EXPECT_TRUE(transform.ok()) << (transform.ok() ? "" : transform.error().message);
  return std::move(transform).value();
}

Rgb apply(const DisplayTransform& transform, const Rgb& scene) {
  float pixel[4] = {scene.x, scene.y, scene.z, 0.25f};
  transform.apply(pixel);
  EXPECT_EQ(pixel[3], 0.25f);
  return {pixel[0], pixel[1], pixel[2]};
}

void expect_near(const Rgb& a, const Rgb& b, float tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance);
}

TEST_F(Display, ListsViewsStandardFirst) {
  const auto views = DisplayTransform::list_views("");
  ASSERT_TRUE(views.ok());
  EXPECT_EQ(views.value(), (std::vector<std::string>{"Standard", "ACES 1.0 SDR", "Khronos PBR Neutral", "AgX", "Raw"}));
  EXPECT_EQ(make("").view(), "Standard");
  EXPECT_EQ(make("Raw").view(), "Raw");
}

// The tolerance allows for two inverse matrices in single precision and a power.
TEST_F(Display, StandardMatchesSrgbCurve) {
  const DisplayTransform standard = make("Standard");
  EXPECT_NEAR(apply(standard, Rgb(0.18f)).x, 0.461356f, 1e-5f); // code value 117.6 of 255
  for (const Rgb& scene : {Rgb(0.0f), Rgb(1.0f), Rgb(0.002f), Rgb(0.9f, 0.1f, 0.5f), Rgb(0.0f, 1.0f, 0.0f)}) {
    expect_near(apply(standard, scene), {encode_srgb(scene.x), encode_srgb(scene.y), encode_srgb(scene.z)}, 1e-5f);
  }
}

TEST_F(Display, ExposureIsInStops) {
  expect_near(apply(make("Standard", 1.0f), Rgb(0.09f, 0.2f, 0.3f)), apply(make("Standard"), Rgb(0.18f, 0.4f, 0.6f)),
              1e-6f);
  expect_near(apply(make("Khronos PBR Neutral", -2.0f), Rgb(4.0f, 0.2f, 2.0f)),
              apply(make("Khronos PBR Neutral"), Rgb(1.0f, 0.05f, 0.5f)), 1e-6f);
  expect_near(apply(make("Raw", 3.0f), Rgb(1.0f, 2.0f, 3.0f)), Rgb(8.0f, 16.0f, 24.0f), 0.0f);
}

TEST_F(Display, RefusesExposureOutOfRange) {
  for (const float stops : {65.0f, -1e9f, std::nanf(""), kInfinity}) {
    const auto transform = DisplayTransform::create({"Standard", stops, ""});
    ASSERT_FALSE(transform.ok());
    EXPECT_EQ(transform.error().kind, ErrorKind::usage);
    EXPECT_NE(transform.error().message.find("use -64 to 64"), std::string::npos);
  }
}

TEST_F(Display, RawIsIdentityBitForBit) {
  const DisplayTransform raw = make("Raw");
  for (const Rgb& scene : {Rgb(0.1f, -2.0f, 1e9f), Rgb(0.0f, 0.333f, 1e-30f)}) EXPECT_EQ(apply(raw, scene), scene);
}

// ---- Khronos PBR Neutral

// Values computed by hand from the formula of the specification.
TEST_F(Display, NeutralMatchesSpecification) {
  // Base colors between 0.08 and 0.8 are reduced by 0.04.
  expect_near(tone_map_pbr_neutral({0.5f, 0.08f, 0.8f}), {0.46f, 0.04f, 0.76f}, 1e-7f);
  // Values near black: x - (x - x^2 / 0.16) = x^2 / 0.16.
  expect_near(tone_map_pbr_neutral(Rgb(0.02f)), Rgb(0.0025f), 1e-7f);
  expect_near(tone_map_pbr_neutral(Rgb(0.0f)), Rgb(0.0f), 0.0f);
  // Grays above: p = 9.96, 1 - 0.0576 / (p - 0.52).
  expect_near(tone_map_pbr_neutral(Rgb(10.0f)), Rgb(1.0f - 0.0576f / 9.44f), 1e-6f);
  // Pure red 2: f = 0, p = 2, p_n = 1 - 0.0576 / 1.48, g = 1 / (0.15 (p - p_n) + 1).
  const float new_peak = 1.0f - 0.0576f / 1.48f;
  const float g = 1.0f / (0.15f * (2.0f - new_peak) + 1.0f);
  expect_near(tone_map_pbr_neutral({2.0f, 0.0f, 0.0f}), {new_peak, new_peak * (1.0f - g), new_peak * (1.0f - g)},
              1e-6f);
}

TEST_F(Display, NeutralIsMonotonicAndBelowOne) {
  float last = -1.0f;
  for (int i = 0; i <= 4000; ++i) {
    const float scene = std::exp2(static_cast<float>(i) * 0.01f - 20.0f); // 2^-20 to 2^20
    const Rgb mapped = tone_map_pbr_neutral(Rgb(scene));
    EXPECT_GE(mapped.x, last - 2e-7f); // allows for rounding
    EXPECT_LE(mapped.x, 1.0f);
    last = mapped.x;
  }
  EXPECT_EQ(tone_map_pbr_neutral(Rgb(-1.0f)), Rgb(0.0f));
  expect_near(tone_map_pbr_neutral(Rgb(kInfinity)), Rgb(1.0f), 0.0f);
}

TEST_F(Display, NeutralViewAppliesSrgbCurve) {
  const Rgb scene(1.5f, 0.3f, 0.05f);
  const Rgb mapped = tone_map_pbr_neutral(scene);
  expect_near(apply(make("Khronos PBR Neutral"), scene),
              {encode_srgb(mapped.x), encode_srgb(mapped.y), encode_srgb(mapped.z)}, 1e-5f);
}

// ---- ACES

// The reference rendering transform maps a scene gray of 0.18 to 4.8 of 48 nits; the SDR video
// transform then raises luminance to the power 0.9811 for dim surroundings.
TEST_F(Display, AcesMapsMidGrayToOneTenth) {
  const Rgb gray = apply(make("ACES 1.0 SDR"), Rgb(0.18f));
  EXPECT_NEAR(gray.x, encode_srgb(std::pow(0.1f, 0.9811f)), 1e-3f);
  // The white of Rec. 709 remains neutral through AP0 and back.
  EXPECT_NEAR(gray.x, gray.y, 1e-3f);
  EXPECT_NEAR(gray.x, gray.z, 1e-3f);
}

TEST_F(Display, AcesIsMonotonicAndReachesWhite) {
  const DisplayTransform aces = make("ACES 1.0 SDR");
  float last = -1.0f;
  for (int i = 0; i <= 200; ++i) {
    const float shown = apply(aces, Rgb(std::exp2(static_cast<float>(i) * 0.1f - 10.0f))).x;
    EXPECT_GE(shown, last - 1e-6f);
    last = shown;
  }
  // A scene value of 16.3, 6.5 stops above gray, is the display's white.
  EXPECT_NEAR(apply(aces, Rgb(16.3f)).x, 1.0f, 0.01f);
}

// Long spans are processed in pieces; each pixel is transformed independently.
TEST_F(Display, PixelsDoNotDependOnTheirNeighbors) {
  for (const char* view : {"Standard", "ACES 1.0 SDR", "Khronos PBR Neutral", "AgX"}) {
    const DisplayTransform transform = make(view);
    std::vector<float> pixels(4 * 5003);
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(i % 1009) * 0.002f;
    std::vector<float> all = pixels;
    transform.apply(all);
    for (size_t i = 0; i < pixels.size(); i += 4) {
      transform.apply(std::span(pixels).subspan(i, 4));
      for (size_t c = 0; c < 4; ++c) ASSERT_EQ(pixels[i + c], all[i + c]) << view << " at " << i;
    }
  }
}

TEST_F(Display, ConfigurationOfANewerVersionIsRefusedWithOnesThatFit) {
  std::ofstream(path_) << "ocio_profile_version: 9.4\n";
  const auto transform = DisplayTransform::create({"", 0.0f, path_});
  ASSERT_FALSE(transform.ok());
  EXPECT_EQ(transform.error().kind, ErrorKind::input_output);
  EXPECT_NE(transform.error().message.find("its version is 9.4, and the OpenColorIO 2."), std::string::npos)
      << transform.error().message;
  EXPECT_NE(transform.error().message.find("ocio-v2.1 fit"), std::string::npos) << transform.error().message;
}

// ---- configurations of users

TEST_F(Display, RefusesUnknownViewAndListsViews) {
  const auto transform = DisplayTransform::create({"Filmic", 0.0f, ""});
  ASSERT_FALSE(transform.ok());
  EXPECT_EQ(transform.error().kind, ErrorKind::usage);
  EXPECT_EQ(transform.error().message, "view 'Filmic' is not in the built-in configuration; use one of 'Standard', "
                                       "'ACES 1.0 SDR', 'Khronos PBR Neutral', 'AgX', 'Raw'");
}

TEST_F(Display, UsesDefaultViewOfUserConfiguration) {
  write_config("lin_rec709", "scene_linear: half");
  const auto views = DisplayTransform::list_views(path_);
  ASSERT_TRUE(views.ok()) << views.error().message;
  EXPECT_EQ(views.value(), (std::vector<std::string>{"Half", "Plain"}));
  // lin_rec709 is found by its name, not by the role, which is another space here.
  expect_near(apply(make("", 0.0f, path_), Rgb(0.5f, 2.0f, -1.0f)), Rgb(0.25f, 1.0f, -0.5f), 1e-6f);
  expect_near(apply(make("Plain", 1.0f, path_), Rgb(0.5f)), Rgb(1.0f), 1e-6f);
}

TEST_F(Display, EnvironmentVariableSelectsConfiguration) {
  write_config("anything", "scene_linear: anything");
  setenv("OCIO", path_.c_str(), 1);
  const DisplayTransform transform = make("");
  EXPECT_EQ(transform.view(), "Half");
  expect_near(apply(transform, Rgb(1.0f)), Rgb(0.5f), 1e-6f);
  setenv("OCIO", "", 1);
  EXPECT_EQ(make("").view(), "Standard");
}

// If only ACES2065-1 is available, colors are converted to it: AP0 components of Rec. 709 red
// (Bradford) are below 1.
TEST_F(Display, UsesAcesInterchangeWithoutRec709) {
  write_config("ap0", "scene_linear: half, aces_interchange: ap0");
  const Rgb red = apply(make("Plain", 0.0f, path_), Rgb(1.0f, 0.0f, 0.0f));
  expect_near(red, Rgb(0.4396f, 0.0898f, 0.0175f), 2e-4f);
}

TEST_F(Display, RefusesInvalidConfigurationsInOneLine) {
  const auto message = [&](const std::string& config) {
    const auto views = DisplayTransform::list_views(config);
    EXPECT_FALSE(views.ok());
    EXPECT_EQ(views.error().kind, ErrorKind::input_output);
    EXPECT_EQ(views.error().message.find('\n'), std::string::npos);
    return views.ok() ? "" : views.error().message;
  };
  testing::internal::CaptureStderr();
  EXPECT_EQ(message("/no/such.ocio").find("/no/such.ocio: cannot use this OpenColorIO configuration: "), 0U);
  std::ofstream(path_) << "ocio_profile_version: [";
  EXPECT_EQ(message(path_).find(path_), 0U);
  write_config("anything", "compositing_log: raw");
  EXPECT_NE(message(path_).find("aces_interchange or scene_linear"), std::string::npos);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

} // namespace
} // namespace kindling
