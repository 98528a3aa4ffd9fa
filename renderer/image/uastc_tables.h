// Modes and partition patterns of UASTC.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace kindling::image_detail {

// A mode (UASTC LDR 4x4 Texture Specification, "List of UASTC Modes").
struct UastcMode {
  uint8_t code;        // code of the mode; the lowest bit is stored first
  uint8_t code_bits;   // 2 to 7
  uint8_t hint_bits;   // hints for transcoding to other formats, which are skipped
  uint8_t components;  // 2 (LA), 3 or 4; all modes except solid color use ASTC's direct endpoints
  uint8_t subsets;     // 1 to 3; 0 for solid color
  uint8_t planes;      // number of weights per pixel, 1 or 2
  uint8_t weight_bits; // bits of one weight
  uint8_t endpoint_bits;
  uint8_t endpoint_base; // 3: plus a trit each; 5: plus a quint each; 1: bits only
};

constexpr int kUastcSolidMode = 8;
constexpr int kUastcReservedMode = 19;
constexpr int kUastcModes = 19;
extern const std::array<UastcMode, kUastcModes> kUastcMode;

// Returns the mode for the lowest 7 bits of a block: 0 to 18, or kUastcReservedMode.
[[nodiscard]] int uastc_mode_of(uint32_t low_bits);

struct UastcPattern {
  std::array<uint8_t, 16> subset; // of each pixel
  std::array<uint8_t, 3> anchors; // the first pixel of each subset, whose weight is stored with one bit less
};

// Returns ASTC's partition of 4 x 4 pixels into 2 or 3 subsets by its seed (Khronos Data Format
// Specification 1.3, 23.21).
[[nodiscard]] UastcPattern make_astc_pattern(uint32_t seed, int subsets);

// Returns one of the patterns that ASTC and BC7 have in common: 30 with 2 subsets, 11 with 3, and
// 19 with 2 for mode 7. Null if the index is past the end.
[[nodiscard]] const UastcPattern* uastc_pattern(int mode, uint32_t index);

// Returns the number of bits of a pattern index in this mode.
[[nodiscard]] constexpr int uastc_pattern_bits(const UastcMode& mode) {
  return mode.subsets < 2 ? 0 : mode.subsets == 2 ? 5 : 4;
}

// Returns an endpoint value of this mode, unquantized to 0 to 255 (Khronos Data Format
// Specification 1.3, 23.13).
[[nodiscard]] uint8_t uastc_endpoint(int mode, uint32_t value);

} // namespace kindling::image_detail
