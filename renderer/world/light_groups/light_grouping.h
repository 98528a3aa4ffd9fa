// The ways in which lights are put into groups.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class LightGrouping : uint8_t {
  off,
  kind,  // environment, suns, lights, emissive
  name,  // the environment, and lights and materials by their names
  extras // by the extras of nodes, lights and materials; the others are "rest"
};

inline constexpr std::array<std::string_view, 4> kLightGroupingNames{"off", "kind", "name", "extras"}; // by value

[[nodiscard]] constexpr std::string_view light_grouping_name(LightGrouping grouping) {
  return kLightGroupingNames[static_cast<size_t>(grouping)];
}
[[nodiscard]] constexpr std::optional<LightGrouping> light_grouping_from_name(std::string_view name) {
  for (size_t i = 0; i < kLightGroupingNames.size(); ++i)
    if (name == kLightGroupingNames[i]) return static_cast<LightGrouping>(i);
  return std::nullopt;
}

} // namespace kindling
