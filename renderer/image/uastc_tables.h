// What the modes of UASTC are made of, and its partition patterns.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace kindling::image_detail {

// One of the 19 modes (UASTC LDR 4x4 Texture Specification, "List of UASTC Modes").
struct UastcMode {
  uint8_t code;        // of the mode: its first bit is the lowest
  uint8_t code_bits;   // 2 to 7
  uint8_t hint_bits;   // for transcoding to other formats: skipped
  uint8_t components;  // 2 (LA), 3 or 4; all modes but the solid one use ASTC's direct endpoints
  uint8_t subsets;     // 1 to 3; 0 for the solid color
  uint8_t planes;      // 1 or 2 weights a pixel
  uint8_t weight_bits; // of one weight
  uint8_t endpoint_bits;
  uint8_t endpoint_base; // 3: and a trit each, 5: and a quint each, 1: neither
};

constexpr int kUastcSolidMode = 8;
constexpr int kUastcReservedMode = 19;
constexpr int kUastcModes = 19;
extern const std::array<UastcMode, kUastcModes> kUastcMode;

// By the lowest 7 bits of a block: 0 to 18, or kUastcReservedMode.
[[nodiscard]] int uastc_mode_of(uint32_t low_bits);

struct UastcPattern {
  std::array<uint8_t, 16> subset; // of each pixel
  std::array<uint8_t, 3> anchors; // the first pixel of each subset: its weight is stored with one bit less
};

// ASTC's partition of 4 x 4 pixels by its seed (Khronos Data Format Specification 1.3, 23.21). subsets: 2 or 3.
[[nodiscard]] UastcPattern make_astc_pattern(uint32_t seed, int subsets);

// The patterns that ASTC and BC7 have in common: 30 of 2 subsets, 11 of 3, and 19 of 2 for mode 7. Null past the end.
[[nodiscard]] const UastcPattern* uastc_pattern(int mode, uint32_t index);

// Bits of a pattern's index in this mode.
[[nodiscard]] constexpr int uastc_pattern_bits(const UastcMode& mode) {
  return mode.subsets < 2 ? 0 : mode.subsets == 2 ? 5 : 4;
}

// An endpoint value of this mode as 0 to 255 (Khronos Data Format Specification 1.3, 23.13).
[[nodiscard]] uint8_t uastc_endpoint(int mode, uint32_t value);

} // namespace kindling::image_detail
