// sRGB transfer function, and its tables for 8-bit and 16-bit integers, computed at compile time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace kindling {

// Maps encoded [0, 1] to linear [0, 1] (IEC 61966-2-1). x^2.4 is computed as x^2 times the fifth
// root of x^2, by Newton's method.
[[nodiscard]] constexpr double decode_srgb(double encoded) {
  if (encoded <= 0.04045) return encoded / 12.92;
  const double x = (encoded + 0.055) / 1.055;
  const double square = x * x;
  double root = 1.0;
  for (int i = 0; i < 12; ++i) {
    const double root2 = root * root;
    root = (4.0 * root + square / (root2 * root2)) / 5.0;
  }
  return square * root;
}

inline constexpr std::array<float, 256> kSrgbU8 = [] {
  std::array<float, 256> table{};
  for (size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(decode_srgb(static_cast<double>(i) / 255.0));
  return table;
}();

// Knots for 16-bit values, because a table of all values would evict other data from the cache.
// Linear interpolation between the 1025 knots has an error of at most 4e-7, and less than an eighth
// of a stored step near black.
inline constexpr std::array<float, 1025> kSrgbU16Knots = [] {
  std::array<float, 1025> table{};
  for (size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<float>(decode_srgb(static_cast<double>(i) * 64.0 / 65535.0));
  return table;
}();

[[nodiscard]] inline float decode_srgb_u8(uint8_t stored) { return kSrgbU8[stored]; }

[[nodiscard]] inline float decode_srgb_u16(uint16_t stored) {
  const float low = kSrgbU16Knots[stored >> 6];
  const float high = kSrgbU16Knots[(stored >> 6) + 1];
  return low + (high - low) * (static_cast<float>(stored & 63) * (1.0f / 64.0f));
}

// Encoding rounds in the encoded space: round(255 srgb(x)), and likewise for 16 bits; NaN gives 0.
// kSrgbU8Ends[c] is the linear value at which code c ends.
inline constexpr std::array<float, 256> kSrgbU8Ends = [] {
  std::array<float, 256> table{};
  for (size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<float>(decode_srgb((static_cast<double>(i) + 0.5) / 255.0));
  table[255] = std::numeric_limits<float>::infinity();
  return table;
}();
// The first code of [(i / 1024)^2, ((i + 1) / 1024)^2). The curve is nearly a square, so at most
// the next code starts in the same interval.
inline constexpr std::array<uint8_t, 1025> kSrgbU8Guess = [] {
  std::array<uint8_t, 1025> table{};
  size_t code = 0;
  for (size_t i = 0; i < table.size(); ++i) {
    const float low = static_cast<float>(i) * static_cast<float>(i) * 0x1p-20f;
    while (low >= kSrgbU8Ends[code]) ++code;
    table[i] = static_cast<uint8_t>(code);
  }
  return table;
}();

[[nodiscard]] inline uint8_t encode_srgb_u8(float linear) {
  if (!(linear > 0.0f)) return 0;
  if (linear >= 1.0f) return 255;
  size_t code = kSrgbU8Guess[static_cast<size_t>(std::sqrt(linear) * 1024.0f)];
  if (code > 0 && linear < kSrgbU8Ends[code - 1]) --code; // corrects rounding of the root
  while (linear >= kSrgbU8Ends[code]) ++code;
  return static_cast<uint8_t>(code);
}

// Inverts decode_srgb_u16() by bisection.
[[nodiscard]] inline uint16_t encode_srgb_u16(float linear) {
  if (!(linear > 0.0f)) return 0;
  if (linear >= 1.0f) return 65535;
  uint32_t low = 0, high = 65535; // decode(low) <= linear < decode(high)
  while (high - low > 1) {
    const uint32_t middle = (low + high) / 2;
    (decode_srgb_u16(static_cast<uint16_t>(middle)) <= linear ? low : high) = middle;
  }
  const float below = linear - decode_srgb_u16(static_cast<uint16_t>(low));
  const float above = decode_srgb_u16(static_cast<uint16_t>(high)) - linear;
  return static_cast<uint16_t>(below <= above ? low : high);
}

} // namespace kindling
