// Lens and shutter of cameras, from valid, invalid and foreign extras.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

Loaded with_extras(json extras) {
  GltfBuilder builder;
  builder.push(
      "cameras",
      {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}, {"extras", std::move(extras)}});
  return load(builder);
}

TEST(CameraExtras, ReadsAllKeys) {
  const Loaded loaded = with_extras(json::parse(R"({"kindling": {
    "fStop": 2.8, "focalLength": 0.05, "focusDistance": 3.2, "focusPoint": [0.5, 0.6], "apertureBlades": 6,
    "apertureRotation": 0.2, "anamorphicRatio": 1.33, "catsEye": 0.25, "shutterOpen": -0.01, "shutterClose": 0.02}})"));
  ASSERT_TRUE(loaded.scene) << loaded.error;
  EXPECT_TRUE(loaded.warnings.empty());
  const SceneCamera& camera = loaded.scene->cameras[0];
  EXPECT_EQ(camera.lens.f_stop, 2.8f);
  EXPECT_EQ(camera.lens.focal_length_m, 0.05f);
  EXPECT_EQ(camera.lens.focus_distance_m, 3.2f);
  EXPECT_EQ(camera.lens.focus_point, V2f(0.5f, 0.6f));
  EXPECT_EQ(camera.lens.aperture_blades, 6);
  EXPECT_EQ(camera.lens.aperture_rotation_rad, 0.2f);
  EXPECT_EQ(camera.lens.anamorphic_ratio, 1.33f);
  EXPECT_EQ(camera.lens.cats_eye, 0.25f);
  ASSERT_TRUE(camera.shutter);
  EXPECT_NEAR(camera.shutter->open_s, -0.01, 1e-9);
  EXPECT_NEAR(camera.shutter->close_s, 0.02, 1e-9);
}

TEST(CameraExtras, EachKeyIsOptional) {
  for (const char* text : {"{}", R"({"kindling": {}})", R"("a note")", R"([1, 2])", R"({"other": {"fStop": "x"}})"}) {
    const Loaded loaded = with_extras(json::parse(text));
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warnings.empty()) << text;
    EXPECT_TRUE(loaded.scene->cameras[0].lens.is_pinhole());
    EXPECT_FALSE(loaded.scene->cameras[0].shutter);
  }
  const Loaded stop = with_extras({{"kindling", {{"fStop", 4}}}});
  EXPECT_EQ(stop.scene->cameras[0].lens.f_stop, 4.0f);
  EXPECT_FALSE(stop.scene->cameras[0].lens.focal_length_m);
  const Loaded close = with_extras({{"kindling", {{"shutterClose", 0.5}}}});
  EXPECT_EQ(close.scene->cameras[0].shutter->open_s, 0.0);
  EXPECT_EQ(close.scene->cameras[0].shutter->close_s, 0.5);
}

struct Broken {
  const char* own;     // value of extras.kindling
  const char* warning; // without the file's name
};

TEST(CameraExtras, WarnsOfIgnoredValues) {
  for (const Broken& broken : {
           Broken{R"({"fStop": 0})", "fStop: '0' is ignored, expected a number from 0.001 to 1e6"},
           Broken{R"({"fStop": "2.8"})", R"(fStop: '"2.8"' is ignored, expected a number from 0.001 to 1e6)"},
           Broken{R"({"focalLength": -1})",
                  "focalLength: '-1' is ignored, expected a length from 1e-9 to 1e9, in meters"},
           Broken{R"({"focusDistance": null})", "focusDistance: 'null' is ignored, expected a length from 1e-9 to 1e9"},
           Broken{R"({"focusPoint": [0.5]})", "focusPoint: '[0.5]' is ignored, expected [x, y]"},
           Broken{R"({"focusPoint": [0.5, 2]})", "focusPoint: '[0.5,2]' is ignored, expected [x, y]"},
           Broken{R"({"apertureBlades": 2.5})", "apertureBlades: '2.5' is ignored, expected a whole number"},
           Broken{R"({"apertureBlades": 1e300})", "apertureBlades: '1e+300' is ignored"},
           Broken{R"({"anamorphicRatio": 0})", "anamorphicRatio: '0' is ignored, expected a number from 0.1 to 10"},
           Broken{R"({"catsEye": 1.5})", "catsEye: '1.5' is ignored, expected a number from 0 to 1"},
           Broken{R"({"shutterOpen": 1, "shutterClose": 0.5})",
                  "shutterClose: '0.5' is ignored, expected a time not before"},
           Broken{R"({"shutterOpen": 1})", "shutterOpen: '1' is ignored, expected a time not after shutterClose"},
           Broken{R"({"fstop": 2})", "'fstop' is ignored, expected one of fStop, focalLength, focusDistance"},
           Broken{"7", "'7' is ignored, expected an object"},
       }) {
    const Loaded loaded = with_extras({{"kindling", json::parse(broken.own)}});
    ASSERT_TRUE(loaded.scene) << loaded.error;
    EXPECT_TRUE(loaded.warned("/cameras/0/extras/kindling"));
    EXPECT_TRUE(loaded.warned(broken.warning)) << (loaded.warnings.empty() ? "no warning" : loaded.warnings[0]);
    EXPECT_EQ(loaded.warnings.size(), 1U);
    const SceneCamera& camera = loaded.scene->cameras[0];
    EXPECT_TRUE(camera.lens.is_pinhole());
    EXPECT_FALSE(camera.shutter);
  }
}

// Numbers that are 0, denormal or infinite in single precision are named, not used.
TEST(CameraExtras, WarnsOfNumbersBeyondSinglePrecision) {
  for (const char* key : {"fStop", "focalLength", "focusDistance", "anamorphicRatio", "catsEye", "shutterClose"})
    for (const char* number : {"1e-42", "1e-60", "-1e-42", "1e39", "1e300"}) {
      SCOPED_TRACE(key);
      const Loaded loaded = with_extras({{"kindling", {{key, json::parse(number)}}}});
      ASSERT_TRUE(loaded.scene) << loaded.error;
      EXPECT_TRUE(loaded.warned("/cameras/0/extras/kindling/" + std::string(key) + ": '" + json::parse(number).dump() +
                                "' is ignored"))
          << number;
    }
  const Loaded zero = with_extras({{"kindling", {{"catsEye", 0.0}}}});
  EXPECT_TRUE(zero.warnings.empty());
}

std::string camera_error(const char* type, json lens) {
  GltfBuilder builder;
  builder.push("cameras", {{"type", type}, {type, std::move(lens)}});
  return load(builder).error;
}

TEST(Cameras, RefusesNumbersBeyondReach) {
  const std::string expected = ", expected a number from 1e-18 to 1e18 in size (VALUE_NOT_IN_RANGE)";
  EXPECT_EQ(camera_error("perspective", {{"yfov", 1e-30}, {"znear", 1}}),
            "/cameras/0/perspective/yfov: 1e-30" + expected);
  EXPECT_EQ(camera_error("perspective", {{"yfov", 1}, {"aspectRatio", 1e30}, {"znear", 1}}),
            "/cameras/0/perspective/aspectRatio: 1e+30" + expected);
  EXPECT_EQ(camera_error("perspective", {{"yfov", 1}, {"znear", 1e30}}),
            "/cameras/0/perspective/znear: 1e+30" + expected);
  EXPECT_EQ(camera_error("orthographic", {{"xmag", 1e30}, {"ymag", 1}, {"znear", 0}, {"zfar", 1}}),
            "/cameras/0/orthographic/xmag: 1e+30" + expected);
  EXPECT_EQ(camera_error("orthographic", {{"xmag", 1}, {"ymag", -1e-44}, {"znear", 0}, {"zfar", 1}}),
            "/cameras/0/orthographic/ymag: -1e-44" + expected);
  EXPECT_EQ(camera_error("perspective", {{"yfov", 1}, {"znear", 0.1}, {"zfar", 3.4e38}}), "");
}

} // namespace
} // namespace kindling::test
