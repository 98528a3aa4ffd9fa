// Whether accumulations are of one image, and what keeps them from it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/accumulation_file.h"

#include <string>
#include <string_view>
#include <vector>

namespace kindling {

inline constexpr std::string_view kProgramDiffers = "program", kSceneDiffers = "scene hash";
struct ImageDifference {
  std::string what; // one of these, or a member of the settings: "--seed"
  std::string in_a; // its value as text: "none" if it is not set, "nothing" where there is no such member
  std::string in_b;
  bool operator==(const ImageDifference&) const = default;
};

// Empty: of one image, whichever parts of it, however many samples are wanted in the end, and whoever asked for them where.
[[nodiscard]] std::vector<ImageDifference> image_differences(const AccumulationIdentity& a,
                                                             const AccumulationIdentity& b);

} // namespace kindling
