// ASTC's endpoint modes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/astc_endpoints.h"

#include <algorithm>
#include <utility>

namespace kindling::image_detail {

namespace {

using Color = std::array<int, 4>;
using Values = std::array<int, 8>;

constexpr int kHdrOne = 0x780; // logarithmic 1

Color clamped(const Color& color, int max) {
  Color result;
  std::transform(color.begin(), color.end(), result.begin(), [&](int value) { return std::clamp(value, 0, max); });
  return result;
}

// Pulls red and green towards blue, which encodes colors near gray more precisely.
Color contract_blue(const Color& c) { return {(c[0] + c[2]) >> 1, (c[1] + c[2]) >> 1, c[2], c[3]}; }

// Moves the highest bit of `offset` to `base` and leaves a number of -32 to 31.
void transfer_bit(int& offset, int& base) {
  base = base >> 1 | (offset & 0x80);
  offset = offset >> 1 & 0x3f;
  if ((offset & 0x20) != 0) offset -= 0x40;
}

// RGB(A) as two colors, of which the second is the brighter one unless blue is contracted.
AstcEndpoints ldr_direct(const Values& v, bool alpha) {
  const Color first = {v[0], v[2], v[4], alpha ? v[6] : 255}, second = {v[1], v[3], v[5], alpha ? v[7] : 255};
  if (v[1] + v[3] + v[5] >= v[0] + v[2] + v[4]) return {first, second};
  return {contract_blue(second), contract_blue(first)};
}

// RGB(A) as a color and a difference.
AstcEndpoints ldr_offset(Values v, bool alpha) {
  for (size_t i = 0; i < (alpha ? 8U : 6U); i += 2) transfer_bit(v[i + 1], v[i]);
  const Color base = {v[0], v[2], v[4], alpha ? v[6] : 255};
  const Color sum = {v[0] + v[1], v[2] + v[3], v[4] + v[5], alpha ? v[6] + v[7] : 255};
  const bool contract = v[1] + v[3] + v[5] < 0;
  return {clamped(contract ? contract_blue(sum) : base, 255), clamped(contract ? contract_blue(base) : sum, 255)};
}

AstcEndpoints ldr_luminance_alpha_offset(Values v) {
  transfer_bit(v[1], v[0]);
  transfer_bit(v[3], v[2]);
  const int luminance = v[0] + v[1];
  return {clamped({v[0], v[0], v[0], v[2]}, 255), clamped({luminance, luminance, luminance, v[2] + v[3]}, 255)};
}

// RGB as a color and a scale; alpha as two values or 1.
AstcEndpoints ldr_scale(const Values& v, bool alpha) {
  return {{v[0] * v[3] >> 8, v[1] * v[3] >> 8, v[2] * v[3] >> 8, alpha ? v[4] : 255},
          {v[0], v[1], v[2], alpha ? v[5] : 255}};
}

AstcEndpoints hdr_gray(int low, int high) {
  return {{low, low, low, kHdrOne}, {high, high, high, kHdrOne}, true, true};
}

AstcEndpoints hdr_luminance_large(const Values& v) {
  if (v[1] >= v[0]) return hdr_gray(v[0] << 4, v[1] << 4);
  return hdr_gray((v[1] << 4) + 8, (v[0] << 4) - 8);
}

AstcEndpoints hdr_luminance_small(const Values& v) {
  const bool coarse = (v[0] & 0x80) != 0;
  const int low = coarse ? (v[1] & 0xe0) << 4 | (v[0] & 0x7f) << 2 : (v[1] & 0xf0) << 4 | (v[0] & 0x7f) << 1;
  const int step = coarse ? (v[1] & 0x1f) << 2 : (v[1] & 0x0f) << 1;
  return hdr_gray(low, std::min(low + step, 0xfff));
}

constexpr int bit(int value, int at) { return value >> at & 1; }

// RGB as a color and a scale. The tables of 23.15 ("HDR RGB, base + scale"): which of the
// spare bits belong where in each of six modes, here a set of modes for each place.
AstcEndpoints hdr_scale(const Values& v) {
  const int code = (v[0] & 0xc0) >> 6 | (v[1] & 0x80) >> 5 | (v[2] & 0x80) >> 4;
  const int major = (code & 0xc) != 0xc ? code >> 2 : code != 0xf ? code & 3 : 0;
  const int mode = (code & 0xc) != 0xc ? code & 3 : code != 0xf ? 4 : 5;
  int red = v[0] & 0x3f, green = v[1] & 0x1f, blue = v[2] & 0x1f, scale = v[3] & 0x1f;
  const std::array<int, 7> x = {bit(v[1], 6), bit(v[1], 5), bit(v[2], 6), bit(v[2], 5),
                                bit(v[3], 7), bit(v[3], 6), bit(v[3], 5)};
  const auto add = [&](int modes, int& value, size_t from, int to) {
    if (bit(modes, mode) != 0) value |= x[from] << to;
  };
  add(0x30, green, 0, 6);
  add(0x3a, green, 1, 5);
  add(0x30, blue, 2, 6);
  add(0x3a, blue, 3, 5);
  add(0x3d, scale, 6, 5);
  add(0x2d, scale, 5, 6);
  add(0x04, scale, 4, 7);
  add(0x3b, red, 4, 6);
  add(0x04, red, 3, 6);
  add(0x10, red, 5, 7);
  add(0x0f, red, 2, 7);
  add(0x05, red, 1, 8);
  add(0x0a, red, 0, 8);
  add(0x05, red, 0, 9);
  add(0x02, red, 6, 9);
  add(0x01, red, 3, 10);
  add(0x02, red, 5, 10);
  constexpr std::array<int, 6> kShifts = {1, 1, 2, 3, 4, 5};
  for (int* value : {&red, &green, &blue, &scale}) *value <<= kShifts[static_cast<size_t>(mode)];
  if (mode != 5) {
    green = red - green;
    blue = red - blue;
  }
  Color high = {red, green, blue, kHdrOne};
  if (major > 0) std::swap(high[0], high[static_cast<size_t>(major)]);
  const Color low = {high[0] - scale, high[1] - scale, high[2] - scale, kHdrOne};
  return {clamped(low, 0xfff), clamped(high, 0xfff), true, true};
}

int as_signed(int value, int bits) {
  const int low = value & ((1 << bits) - 1);
  return low >= 1 << (bits - 1) ? low - (1 << bits) : low;
}

// RGB as two colors (23.15, "HDR RGB, direct").
AstcEndpoints hdr_direct(const Values& v) {
  const int major = bit(v[4], 7) | bit(v[5], 7) << 1;
  if (major == 3) {
    return {{v[0] << 4, v[2] << 4, (v[4] & 0x7f) << 5, kHdrOne},
            {v[1] << 4, v[3] << 4, (v[5] & 0x7f) << 5, kHdrOne},
            true,
            true};
  }
  const int mode = bit(v[1], 7) | bit(v[2], 7) << 1 | bit(v[3], 7) << 2;
  constexpr std::array<int, 8> kDifferenceBits = {7, 6, 7, 6, 5, 6, 5, 6};
  const int width = kDifferenceBits[static_cast<size_t>(mode)];
  int a = v[0] | (v[1] & 0x40) << 2, b0 = v[2] & 0x3f, b1 = v[3] & 0x3f, c = v[1] & 0x3f;
  int d0 = as_signed(v[4], width), d1 = as_signed(v[5], width);
  const std::array<int, 6> x = {bit(v[2], 6), bit(v[3], 6), bit(v[4], 6), bit(v[5], 6), bit(v[4], 5), bit(v[5], 5)};
  const auto add = [&](int modes, int& value, size_t from, int to) {
    if (bit(modes, mode) != 0) value |= x[from] << to;
  };
  add(0xa4, a, 0, 9);
  add(0x08, a, 2, 9);
  add(0x50, a, 4, 9);
  add(0x50, a, 5, 10);
  add(0xa0, a, 1, 10);
  add(0xc0, a, 2, 11);
  add(0x04, c, 1, 6);
  add(0xe8, c, 3, 6);
  add(0x20, c, 2, 7);
  add(0x5b, b0, 0, 6);
  add(0x5b, b1, 1, 6);
  add(0x12, b0, 2, 7);
  add(0x12, b1, 3, 7);
  const int factor = 1 << (mode >> 1 ^ 3);
  for (int* value : {&a, &b0, &b1, &c, &d0, &d1}) *value *= factor;
  Color low = {a - c, a - b0 - c - d0, a - b1 - c - d1, kHdrOne}, high = {a, a - b0, a - b1, kHdrOne};
  if (major > 0) {
    std::swap(low[0], low[static_cast<size_t>(major)]);
    std::swap(high[0], high[static_cast<size_t>(major)]);
  }
  return {clamped(low, 0xfff), clamped(high, 0xfff), true, true};
}

AstcEndpoints hdr_direct_ldr_alpha(const Values& v) {
  AstcEndpoints ends = hdr_direct(v);
  ends.low[3] = v[6];
  ends.high[3] = v[7];
  ends.hdr_alpha = false;
  return ends;
}

AstcEndpoints hdr_direct_hdr_alpha(const Values& v) {
  AstcEndpoints ends = hdr_direct(v);
  const int mode = bit(v[6], 7) | bit(v[7], 7) << 1;
  int low = v[6] & 0x7f, high = v[7] & 0x7f;
  if (mode == 3) {
    low <<= 5;
    high <<= 5;
  } else {
    low |= high << (mode + 1) & 0x780;
    high = ((high & 0x3f >> mode) ^ 0x20 >> mode) - (0x20 >> mode);
    low *= 1 << (4 - mode);
    high = std::clamp(low + high * (1 << (4 - mode)), 0, 0xfff);
  }
  ends.low[3] = low;
  ends.high[3] = high;
  return ends;
}

} // namespace

AstcEndpoints astc_endpoints(uint32_t mode, std::span<const uint32_t> values) {
  Values v{};
  for (size_t i = 0; i < astc_endpoint_values(mode); ++i) v[i] = static_cast<int>(values[i]);
  switch (mode) {
  case 0: return {{v[0], v[0], v[0], 255}, {v[1], v[1], v[1], 255}};
  case 1: {
    const int low = v[0] >> 2 | (v[1] & 0xc0), high = std::min(low + (v[1] & 0x3f), 255);
    return {{low, low, low, 255}, {high, high, high, 255}};
  }
  case 2: return hdr_luminance_large(v);
  case 3: return hdr_luminance_small(v);
  case 4: return {{v[0], v[0], v[0], v[2]}, {v[1], v[1], v[1], v[3]}};
  case 5: return ldr_luminance_alpha_offset(v);
  case 6: return ldr_scale(v, false);
  case 7: return hdr_scale(v);
  case 8: return ldr_direct(v, false);
  case 9: return ldr_offset(v, false);
  case 10: return ldr_scale(v, true);
  case 11: return hdr_direct(v);
  case 12: return ldr_direct(v, true);
  case 13: return ldr_offset(v, true);
  case 14: return hdr_direct_ldr_alpha(v);
  default: return hdr_direct_hdr_alpha(v);
  }
}

} // namespace kindling::image_detail
