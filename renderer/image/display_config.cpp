// Built-in OpenColorIO configuration, and loading of user configurations.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/display_config.h"

#include "renderer/image/decoders.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>

namespace kindling::image_detail {

namespace {

constexpr const char* kSource = "Linear Rec.709";
constexpr const char* kDisplay = "sRGB";

ocio::BuiltinTransformRcPtr builtin(const char* style,
                                    ocio::TransformDirection direction = ocio::TRANSFORM_DIR_FORWARD) {
  auto transform = ocio::BuiltinTransform::Create();
  transform->setStyle(style);
  transform->setDirection(direction);
  return transform;
}

ocio::ViewTransformRcPtr view_transform(const char* name, const ocio::ConstTransformRcPtr& to_display_reference) {
  auto view = ocio::ViewTransform::Create(ocio::REFERENCE_SPACE_SCENE);
  view->setName(name);
  view->setTransform(to_display_reference, ocio::VIEWTRANSFORM_DIR_FROM_REFERENCE);
  return view;
}

// Creates the built-in configuration. The scene reference is linear Rec. 709; the display reference
// is CIE XYZ (D65) with white at Y = 1, as in OpenColorIO's built-in transforms.
ocio::ConstConfigRcPtr make_built_in_config() {
  auto config = ocio::Config::Create()->createEditableCopy();
  config->setMajorVersion(2);
  config->setDescription("Kindling's built-in configuration");

  auto linear = ocio::ColorSpace::Create(ocio::REFERENCE_SPACE_SCENE);
  linear->setName(kSource);
  linear->setEncoding("scene-linear");
  config->addColorSpace(linear);
  auto raw = ocio::ColorSpace::Create(ocio::REFERENCE_SPACE_SCENE);
  raw->setName("Raw");
  raw->setIsData(true);
  config->addColorSpace(raw);
  auto srgb = ocio::ColorSpace::Create(ocio::REFERENCE_SPACE_DISPLAY);
  srgb->setName(kDisplay);
  srgb->setEncoding("sdr-video");
  srgb->setTransform(builtin("DISPLAY - CIE-XYZ-D65_to_sRGB"), ocio::COLORSPACE_DIR_FROM_REFERENCE);
  config->addColorSpace(srgb);
  config->setRole(ocio::ROLE_SCENE_LINEAR, kSource);
  config->setRole(ocio::ROLE_DEFAULT, kSource);

  // Derived from the primaries and white point of ITU-R BT.709 in double precision.
  constexpr double kRec709ToXyz[16] = {0.4123907992659595,
                                       0.35758433938387796,
                                       0.1804807884018343,
                                       0.0, //
                                       0.21263900587151036,
                                       0.7151686787677559,
                                       0.07219231536073371,
                                       0.0, //
                                       0.01933081871559185,
                                       0.11919477979462599,
                                       0.9505321522496606,
                                       0.0, //
                                       0.0,
                                       0.0,
                                       0.0,
                                       1.0};
  auto to_xyz = ocio::MatrixTransform::Create();
  to_xyz->setMatrix(kRec709ToXyz);
  config->addViewTransform(view_transform("Standard", to_xyz));
  const auto aces = rec709_to_aces2065();
  aces->appendTransform(builtin("ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0"));
  config->addViewTransform(view_transform("ACES 1.0 SDR", aces));
  config->setDefaultViewTransformName("Standard");

  const auto add_view = [&](const char* name, const char* transform) {
    config->addDisplayView(kDisplay, name, transform, kDisplay, "", "", "");
  };
  add_view("Standard", "Standard");
  add_view("ACES 1.0 SDR", "ACES 1.0 SDR");
  add_view(kNeutralView, "Standard"); // after tone_map_pbr_neutral()
  add_view(kAgxView, "Standard");     // after tone_map_agx()
  config->addDisplayView(kDisplay, "Raw", "Raw", "");
  config->validate();
  return config;
}

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

// Finds the source space: linear Rec. 709 by its names in published configurations; else ACES2065-1
// by its role, which is unambiguous; else the scene_linear role, which comes last because its
// primaries may differ (ACEScg).
void find_source(DisplayConfig& found) {
  constexpr std::array kNames{"Linear Rec.709 (sRGB)",
                              "Linear Rec.709",
                              "lin_rec709_srgb",
                              "lin_rec709",
                              "lin_srgb",
                              "Linear BT.709",
                              "Linear sRGB",
                              "Utility - Linear - sRGB",
                              "Utility - Linear - Rec.709"};
  for (const char* name : kNames) {
    if (const auto space = found.config->getColorSpace(name)) {
      found.source = space->getName();
      return;
    }
  }
  const auto linear = found.config->getColorSpace(ocio::ROLE_SCENE_LINEAR);
  // In Blender's and Nuke's configurations this plain name has the primaries of Rec. 709.
  if (linear && equals_ignoring_case(linear->getName(), "linear")) {
    found.source = linear->getName();
  } else if (const auto aces = found.config->getColorSpace("aces_interchange")) {
    found.source = aces->getName();
    found.source_is_aces = true;
  } else if (linear) {
    found.source = linear->getName();
  }
}

std::optional<std::string> fill_views(DisplayConfig& found) {
  found.display = found.config->getDefaultDisplay();
  if (found.display.empty()) return "it has no display";
  const std::string default_view = found.config->getDefaultView(found.display.c_str());
  for (int i = 0; i < found.config->getNumViews(found.display.c_str()); ++i) {
    found.views.emplace_back(found.config->getView(found.display.c_str(), i));
  }
  if (found.views.empty()) return "its default display has no view";
  std::stable_partition(found.views.begin(), found.views.end(),
                        [&](const std::string& v) { return v == default_view; });
  return std::nullopt;
}

// Returns the value of "ocio_profile_version" in a configuration's file, or an empty string.
std::string profile_version(const std::string& file) {
  std::ifstream stream(file);
  constexpr std::string_view kKey = "ocio_profile_version:";
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with(kKey)) continue;
    const size_t begin = line.find_first_not_of(' ', kKey.size());
    const size_t end = line.find_first_not_of("0123456789.", begin);
    return begin == std::string::npos ? "" : line.substr(begin, end - begin);
  }
  return {};
}

// Returns true if `version`, as in "2.4", is newer than `major`.`minor`.
bool is_newer(const std::string& version, int major, int minor) {
  const size_t dot = version.find('.');
  const int own_major = std::atoi(version.c_str());
  const int own_minor = dot == std::string::npos ? 0 : std::atoi(version.c_str() + dot + 1);
  return own_major != major ? own_major > major : own_minor > minor;
}

// Returns why this OpenColorIO cannot read a configuration of its kind at all, or an empty string.
std::string too_new(const std::string& file) {
  constexpr const char* kFitting =
      "the ACES configurations that end in ocio-v2.1 fit, cg-config-v1.0.0_aces-v1.3_ocio-v2.1.ocio for example";
  const int hex = ocio::GetVersionHex(), major = hex >> 24, minor = hex >> 16 & 0xff;
  if (file.starts_with("ocio://") && (major < 2 || (major == 2 && minor < 2)))
    return fmt::format(
        "configurations built into OpenColorIO need its version 2.2, and this program has {}; give a file: {}",
        ocio::GetVersion(), kFitting);
  const std::string version = profile_version(file);
  if (!version.empty() && is_newer(version, major, minor))
    return fmt::format("its version is {}, and the OpenColorIO {} of this program reads versions up to {}.{}; {}",
                       version, ocio::GetVersion(), major, minor, kFitting);
  return {};
}

// Disables logging, which OpenColorIO sends to stderr by default.
void silence_ocio() {
  static const bool once = (ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE), true);
  static_cast<void>(once);
}

} // namespace

ocio::GroupTransformRcPtr rec709_to_aces2065() {
  auto group = ocio::GroupTransform::Create();
  group->appendTransform(builtin("UTILITY - ACES-AP1_to_LINEAR-REC709_BFD", ocio::TRANSFORM_DIR_INVERSE));
  group->appendTransform(builtin("ACEScg_to_ACES2065-1"));
  return group;
}

Result<DisplayConfig> open_display_config(const std::string& path) {
  silence_ocio();
  const char* variable = std::getenv("OCIO");
  const std::string file = !path.empty() ? path : variable ? variable : "";
  DisplayConfig found;
  found.built_in = file.empty();
  found.name = found.built_in ? "the built-in configuration" : file;
  const auto failed = [&](const std::string& why) {
    return Error{ErrorKind::input_output,
                 fmt::format("{}: cannot use this OpenColorIO configuration: {}", found.name, first_line(why))};
  };
  std::error_code code; // a pipe would block
  if (std::filesystem::exists(file, code) && !std::filesystem::is_regular_file(file, code))
    return failed("it is not a regular file");
  if (!found.built_in)
    if (const std::string why = too_new(file); !why.empty()) return failed(why);
  try {
    found.config = found.built_in ? make_built_in_config() : ocio::Config::CreateFromFile(file.c_str());
    if (!found.built_in) found.config->validate();
    if (const auto error = fill_views(found)) return failed(*error);
    find_source(found);
    if (found.source.empty()) {
      return failed("it has neither a color space 'Linear Rec.709 (sRGB)' nor a role aces_interchange or scene_linear");
    }
  } catch (const std::exception& e) {
    return failed(e.what());
  }
  return found;
}

} // namespace kindling::image_detail
