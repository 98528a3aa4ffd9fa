// The quality of denoising as a setting: `--denoise`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class Denoising : uint8_t {
  off,
  fast, // a smaller network; albedo and normal as they are
  best  // the largest network; albedo and normal are denoised first
};
[[nodiscard]] std::string_view denoising_name(Denoising denoising); // "off", "fast", "best"
[[nodiscard]] std::optional<Denoising> denoising_from_name(std::string_view name);

} // namespace kindling
