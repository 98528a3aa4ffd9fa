// Which OpenColorIO configuration, view and source color space a DisplayTransform uses.
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
  std::string name;               // for errors: "the built-in configuration" or the path
  bool built_in = false;          // its views are ours, and Kindling evaluates kNeutralView and kAgxView
  std::string display;            // the default one
  std::vector<std::string> views; // of that display, default first
  std::string source;             // color space of the pixels given
  bool source_is_aces =
      false; // the pixels must be converted to ACES2065-1 first: the only space of the config we can name
};

// `path` empty: $OCIO where set, else the built-in configuration.
[[nodiscard]] Result<DisplayConfig> open_display_config(const std::string& path);

// Linear Rec. 709 (D65) to ACES2065-1 (AP0, Bradford adaptation).
[[nodiscard]] ocio::GroupTransformRcPtr rec709_to_aces2065();

} // namespace kindling::image_detail
