// Tables of UASTC: modes, partition patterns and endpoint values.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/uastc_tables.h"

#include "renderer/image/blocks/astc_integers.h"
#include "renderer/image/blocks/astc_partition.h"

#include <algorithm>

namespace kindling::image_detail {

// Modes and pattern seeds are those of the UASTC specification; patterns and endpoint values are
// computed as in ASTC.
const std::array<UastcMode, kUastcModes> kUastcMode = {{
    // code, bits, hints, components, subsets, planes, weight bits, endpoint bits, base
    {0x01, 4, 15, 3, 1, 1, 4, 6, 3}, {0x35, 6, 15, 3, 1, 1, 2, 8, 1}, {0x1d, 5, 15, 3, 2, 1, 3, 4, 1},
    {0x03, 5, 15, 3, 3, 1, 2, 2, 3}, {0x13, 5, 15, 3, 2, 1, 2, 3, 5}, {0x0b, 5, 15, 3, 1, 1, 3, 8, 1},
    {0x1b, 5, 15, 3, 1, 2, 2, 5, 5}, {0x07, 5, 15, 3, 2, 1, 2, 3, 5}, {0x17, 5, 0, 4, 0, 0, 0, 8, 1}, // solid color
    {0x0f, 5, 23, 4, 2, 1, 2, 4, 1}, {0x02, 3, 17, 4, 1, 1, 4, 4, 3}, {0x00, 2, 17, 4, 1, 2, 2, 4, 3},
    {0x06, 3, 17, 4, 1, 1, 3, 6, 3}, {0x1f, 5, 23, 4, 1, 2, 1, 8, 1}, {0x0d, 5, 23, 4, 1, 1, 2, 8, 1},
    {0x05, 7, 23, 2, 1, 1, 4, 8, 1}, {0x15, 6, 23, 2, 2, 1, 2, 8, 1}, {0x25, 6, 23, 2, 1, 2, 2, 8, 1},
    {0x09, 4, 15, 3, 1, 1, 5, 5, 1},
}};

namespace {

constexpr std::array<uint16_t, 30> kSeeds2 = {28, 20,  16,  29, 91,  9,   107, 72,  149, 204, 50,  114, 496, 17,  78,
                                              39, 252, 828, 43, 156, 116, 210, 476, 273, 684, 359, 246, 195, 694, 524};
constexpr std::array<uint16_t, 11> kSeeds3 = {260, 74, 32, 156, 183, 15, 745, 0, 335, 902, 254};
constexpr std::array<uint16_t, 19> kSeeds2Mode7 = {36,  48,  61,  137, 161, 183, 226, 281, 302, 307,
                                                   479, 495, 593, 594, 605, 799, 812, 988, 993};

template <size_t N>
std::array<UastcPattern, N> make_patterns(const std::array<uint16_t, N>& seeds, int subsets) {
  std::array<UastcPattern, N> patterns;
  std::transform(seeds.begin(), seeds.end(), patterns.begin(),
                 [&](uint16_t seed) { return make_astc_pattern(seed, subsets); });
  return patterns;
}

std::array<uint8_t, 128> make_mode_of_bits() {
  std::array<uint8_t, 128> modes;
  modes.fill(kUastcReservedMode);
  for (size_t bits = 0; bits < modes.size(); ++bits) {
    for (size_t mode = 0; mode < kUastcMode.size(); ++mode) {
      const UastcMode& m = kUastcMode[mode];
      if ((bits & ((1U << m.code_bits) - 1U)) == m.code) modes[bits] = static_cast<uint8_t>(mode);
    }
  }
  return modes;
}

using EndpointTable = std::array<std::array<uint8_t, 256>, kUastcModes>;

EndpointTable make_endpoint_table() {
  EndpointTable table{};
  for (size_t mode = 0; mode < kUastcModes; ++mode) {
    const UastcMode& m = kUastcMode[mode];
    const uint32_t values = static_cast<uint32_t>(m.endpoint_base) << m.endpoint_bits;
    for (uint32_t value = 0; value < values; ++value) {
      table[mode][value] = static_cast<uint8_t>(astc_color_value({m.endpoint_base, m.endpoint_bits}, value));
    }
  }
  return table;
}

} // namespace

int uastc_mode_of(uint32_t low_bits) {
  static const std::array<uint8_t, 128> modes = make_mode_of_bits();
  return modes[low_bits & 127U];
}

UastcPattern make_astc_pattern(uint32_t seed, int subsets) {
  const AstcPartition partition(seed, static_cast<uint32_t>(subsets), true);
  UastcPattern pattern{};
  std::array<bool, 3> seen{};
  for (uint32_t i = 0; i < 16; ++i) {
    const auto subset = static_cast<uint8_t>(partition.subset(i % 4, i / 4));
    pattern.subset[i] = subset;
    if (!seen[subset]) pattern.anchors[subset] = static_cast<uint8_t>(i);
    seen[subset] = true;
  }
  return pattern;
}

const UastcPattern* uastc_pattern(int mode, uint32_t index) {
  static const std::array<UastcPattern, 30> patterns2 = make_patterns(kSeeds2, 2);
  static const std::array<UastcPattern, 11> patterns3 = make_patterns(kSeeds3, 3);
  static const std::array<UastcPattern, 19> patterns2_mode7 = make_patterns(kSeeds2Mode7, 2);
  if (mode == 7) return index < patterns2_mode7.size() ? &patterns2_mode7[index] : nullptr;
  if (kUastcMode[static_cast<size_t>(mode)].subsets == 3) {
    return index < patterns3.size() ? &patterns3[index] : nullptr;
  }
  return index < patterns2.size() ? &patterns2[index] : nullptr;
}

uint8_t uastc_endpoint(int mode, uint32_t value) {
  static const EndpointTable table = make_endpoint_table();
  return table[static_cast<size_t>(mode)][value & 255U];
}

} // namespace kindling::image_detail
