// Decoder of BC6H blocks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/bc6h_block.h"

#include "renderer/image/blocks/bptc_tables.h"

#include <string_view>

namespace kindling::image_detail {

namespace {

struct Bc6hMode {
  uint8_t code; // the lowest 2 bits if these are 0 or 1, else the lowest 5
  uint8_t regions;
  uint8_t base_bits;                 // of the first endpoint
  std::array<uint8_t, 3> other_bits; // of the others' red, green and blue
  bool deltas;                       // the others are differences to the first
  // Bits in the order in which they are stored after the code: channel, endpoint and the first and
  // last bit of each run.
  std::string_view layout;
};

constexpr std::array<Bc6hMode, 14> kBc6hModes = {{
    {0,
     2,
     10,
     {5, 5, 5},
     true,
     "g2:4-4 b2:4-4 b3:4-4 r0:0-9 g0:0-9 b0:0-9 r1:0-4 g3:4-4 g2:0-3 g1:0-4 b3:0-0 g3:0-3 b1:0-4 b3:1-1 b2:0-3 "
     "r2:0-4 b3:2-2 r3:0-4 b3:3-3"},
    {1,
     2,
     7,
     {6, 6, 6},
     true,
     "g2:5-5 g3:4-5 r0:0-6 b3:0-1 b2:4-4 g0:0-6 b2:5-5 b3:2-2 g2:4-4 b0:0-6 b3:3-3 b3:5-4 r1:0-5 g2:0-3 g1:0-5 "
     "g3:0-3 b1:0-5 b2:0-3 r2:0-5 r3:0-5"},
    {2,
     2,
     11,
     {5, 4, 4},
     true,
     "r0:0-9 g0:0-9 b0:0-9 r1:0-4 r0:10-10 g2:0-3 g1:0-3 g0:10-10 b3:0-0 g3:0-3 b1:0-3 b0:10-10 b3:1-1 b2:0-3 "
     "r2:0-4 b3:2-2 r3:0-4 b3:3-3"},
    {6,
     2,
     11,
     {4, 5, 4},
     true,
     "r0:0-9 g0:0-9 b0:0-9 r1:0-3 r0:10-10 g3:4-4 g2:0-3 g1:0-4 g0:10-10 g3:0-3 b1:0-3 b0:10-10 b3:1-1 b2:0-3 "
     "r2:0-3 b3:0-0 b3:2-2 r3:0-3 g2:4-4 b3:3-3"},
    {10,
     2,
     11,
     {4, 4, 5},
     true,
     "r0:0-9 g0:0-9 b0:0-9 r1:0-3 r0:10-10 b2:4-4 g2:0-3 g1:0-3 g0:10-10 b3:0-0 g3:0-3 b1:0-4 b0:10-10 b2:0-3 "
     "r2:0-3 b3:1-2 r3:0-3 b3:4-3"},
    {14,
     2,
     9,
     {5, 5, 5},
     true,
     "r0:0-8 b2:4-4 g0:0-8 g2:4-4 b0:0-8 b3:4-4 r1:0-4 g3:4-4 g2:0-3 g1:0-4 b3:0-0 g3:0-3 b1:0-4 b3:1-1 b2:0-3 "
     "r2:0-4 b3:2-2 r3:0-4 b3:3-3"},
    {18,
     2,
     8,
     {6, 5, 5},
     true,
     "r0:0-7 g3:4-4 b2:4-4 g0:0-7 b3:2-2 g2:4-4 b0:0-7 b3:3-4 r1:0-5 g2:0-3 g1:0-4 b3:0-0 g3:0-3 b1:0-4 b3:1-1 "
     "b2:0-3 r2:0-5 r3:0-5"},
    {22,
     2,
     8,
     {5, 6, 5},
     true,
     "r0:0-7 b3:0-0 b2:4-4 g0:0-7 g2:5-4 b0:0-7 g3:5-5 b3:4-4 r1:0-4 g3:4-4 g2:0-3 g1:0-5 g3:0-3 b1:0-4 b3:1-1 "
     "b2:0-3 r2:0-4 b3:2-2 r3:0-4 b3:3-3"},
    {26,
     2,
     8,
     {5, 5, 6},
     true,
     "r0:0-7 b3:1-1 b2:4-4 g0:0-7 b2:5-5 g2:4-4 b0:0-7 b3:5-4 r1:0-4 g3:4-4 g2:0-3 g1:0-4 b3:0-0 g3:0-3 b1:0-5 "
     "b2:0-3 r2:0-4 b3:2-2 r3:0-4 b3:3-3"},
    {30,
     2,
     6,
     {6, 6, 6},
     false,
     "r0:0-5 g3:4-4 b3:0-1 b2:4-4 g0:0-5 g2:5-5 b2:5-5 b3:2-2 g2:4-4 b0:0-5 g3:5-5 b3:3-3 b3:5-4 r1:0-5 g2:0-3 "
     "g1:0-5 g3:0-3 b1:0-5 b2:0-3 r2:0-5 r3:0-5"},
    {3, 1, 10, {10, 10, 10}, false, "r0:0-9 g0:0-9 b0:0-9 r1:0-9 g1:0-9 b1:0-9"},
    {7, 1, 11, {9, 9, 9}, true, "r0:0-9 g0:0-9 b0:0-9 r1:0-8 r0:10-10 g1:0-8 g0:10-10 b1:0-8 b0:10-10"},
    {11, 1, 12, {8, 8, 8}, true, "r0:0-9 g0:0-9 b0:0-9 r1:0-7 r0:11-10 g1:0-7 g0:11-10 b1:0-7 b0:11-10"},
    {15, 1, 16, {4, 4, 4}, true, "r0:0-9 g0:0-9 b0:0-9 r1:0-3 r0:15-10 g1:0-3 g0:15-10 b1:0-3 b0:15-10"},
}};

// Where one stored bit belongs; the whole layout of a mode has at most 77 of them.
struct BitPlace {
  uint8_t endpoint, channel, bit;
};

struct Places {
  std::array<BitPlace, 80> place{};
  size_t count = 0;
};

constexpr Places parse_layout(std::string_view text) {
  Places places;
  size_t at = 0;
  const auto number = [&] {
    int value = 0;
    for (; at < text.size() && text[at] >= '0' && text[at] <= '9'; ++at) value = 10 * value + (text[at] - '0');
    return value;
  };
  for (; at < text.size(); ++at) { // past the space
    const auto channel = static_cast<uint8_t>(text[at] == 'r' ? 0 : text[at] == 'g' ? 1 : 2);
    const auto endpoint = static_cast<uint8_t>(text[at + 1] - '0');
    at += 3;
    const int first = number();
    ++at;
    const int last = number(), step = first <= last ? 1 : -1;
    for (int bit = first; bit != last + step; bit += step) {
      places.place[places.count++] = {endpoint, channel, static_cast<uint8_t>(bit)};
    }
  }
  return places;
}

constexpr std::array<Places, 14> kPlaces = [] {
  std::array<Places, 14> places;
  for (size_t i = 0; i < kBc6hModes.size(); ++i) places[i] = parse_layout(kBc6hModes[i].layout);
  return places;
}();

constexpr int32_t sign_extend(uint32_t value, uint32_t bits) {
  const uint32_t sign = 1U << (bits - 1);
  return static_cast<int32_t>(value ^ sign) - static_cast<int32_t>(sign);
}

// Widens an endpoint to 16 bits, or to 15 and a sign.
int32_t unquantize(int32_t value, uint32_t bits, bool is_signed) {
  if (!is_signed) {
    if (bits >= 15 || value == 0) return value;
    return value == (1 << bits) - 1 ? 0xffff : ((value << 16) + 0x8000) >> bits;
  }
  if (bits >= 16 || value == 0) return value;
  const int32_t size = value < 0 ? -value : value;
  const int32_t wide = size >= (1 << (bits - 1)) - 1 ? 0x7fff : ((size << 15) + 0x4000) >> (bits - 1);
  return value < 0 ? -wide : wide;
}

// Returns the bits of the half that an interpolated value stands for.
uint32_t to_half(int32_t value, bool is_signed) {
  if (!is_signed) return static_cast<uint32_t>(value * 31 >> 6);
  return value < 0 ? 0x8000U | static_cast<uint32_t>(-value * 31 >> 5) : static_cast<uint32_t>(value * 31 >> 5);
}

using Endpoints = std::array<std::array<int32_t, 3>, 4>;

// Reads the endpoints as they are stored, adds differences, and widens them.
Endpoints read_bc6h_endpoints(BitField& bits, const Bc6hMode& mode, const Places& places, bool is_signed) {
  std::array<std::array<uint32_t, 3>, 4> stored{};
  for (size_t i = 0; i < places.count; ++i) {
    const BitPlace& place = places.place[i];
    stored[place.endpoint][place.channel] |= bits.take(1) << place.bit;
  }
  Endpoints ends{};
  const uint32_t mask = (1U << mode.base_bits) - 1U;
  for (size_t e = 0; e < size_t{2} * mode.regions; ++e) {
    for (size_t c = 0; c < 3; ++c) {
      uint32_t value = stored[e][c];
      if (e > 0 && mode.deltas) {
        value = (stored[0][c] + static_cast<uint32_t>(sign_extend(value, mode.other_bits[c]))) & mask;
      }
      const int32_t number = is_signed ? sign_extend(value, mode.base_bits) : static_cast<int32_t>(value);
      ends[e][c] = unquantize(number, mode.base_bits, is_signed);
    }
  }
  return ends;
}

} // namespace

void decode_bc6h(BlockBytes block, bool is_signed, TexelBlock& texels) {
  constexpr uint32_t kOne = 0x3c00; // half
  BitField bits(block);
  uint32_t code = bits.take(2);
  if (code > 1) code |= bits.take(3) << 2;
  size_t index = 0;
  while (index < kBc6hModes.size() && kBc6hModes[index].code != code) ++index;
  if (index == kBc6hModes.size()) {
    for (size_t i = 0; i < 16; ++i) texels[i] = {0, 0, 0, kOne};
    return;
  }
  const Bc6hMode& mode = kBc6hModes[index];
  const Endpoints ends = read_bc6h_endpoints(bits, mode, kPlaces[index], is_signed);
  const BptcPartition partition = bptc_partition(mode.regions, mode.regions == 2 ? bits.take(5) : 0);
  const uint32_t index_bits = mode.regions == 2 ? 3 : 4;
  for (uint32_t i = 0; i < 16; ++i) {
    const uint32_t region = partition.subset(i);
    const uint32_t stored_bits = index_bits - (partition.anchors[region] == i ? 1U : 0U);
    const auto weight = static_cast<int32_t>(bptc_weight(index_bits, bits.take(stored_bits)));
    const auto &low = ends[size_t{2} * region], &high = ends[size_t{2} * region + 1];
    for (size_t c = 0; c < 3; ++c) {
      texels[i][c] = to_half((low[c] * (64 - weight) + high[c] * weight + 32) >> 6, is_signed);
    }
    texels[i][3] = kOne;
  }
}

} // namespace kindling::image_detail
