// OpenColorIO configuration of a DisplayTransform: views and source color space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <OpenColorIO/OpenColorIO.h>

#include <string>
#include <vector>

namespace kindling::image_detail {

namespace ocio = OCIO_NAMESPACE;

inline constexpr const char* kNeutralView = "Khronos PBR Neutral";
inline constexpr const char* kAgxView = "AgX";

struct DisplayConfig {
  ocio::ConstConfigRcPtr config;
  std::string name;      // for errors: "the built-in configuration" or the path
  bool built_in = false; // true for Kindling's configuration, whose kNeutralView and kAgxView Kindling evaluates
  std::string display;   // the default display
  std::vector<std::string> views; // of that display, default first
  std::string source;             // color space of the input pixels
  // True if pixels must first be converted to ACES2065-1, because the configuration has no Rec. 709
  // space.
  bool source_is_aces = false;
};

// Opens a configuration. If `path` is empty, $OCIO is used if set, else the built-in configuration.
[[nodiscard]] Result<DisplayConfig> open_display_config(const std::string& path);

// Returns the transform from linear Rec. 709 (D65) to ACES2065-1 (AP0, Bradford adaptation).
[[nodiscard]] ocio::GroupTransformRcPtr rec709_to_aces2065();

} // namespace kindling::image_detail
