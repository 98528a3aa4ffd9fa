// The sRGB transfer function, and tables of it for stored integers, made at compile time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling {

// IEC 61966-2-1: encoded [0, 1] to linear [0, 1]. x^2.4 as x^2 times the fifth root of x^2, by Newton's method.
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

// 16 bits: a table of all values would push everything else out of the cache. Linear interpolation between 1025 values
// is wrong by at most 4e-7, and by less than an eighth of a stored step near black.
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

} // namespace kindling
