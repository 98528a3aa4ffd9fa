// ASTC's integer sequences and unquantization.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/astc_integers.h"

namespace kindling::image_detail {

namespace {

constexpr uint32_t bits_of(uint32_t value, uint32_t high, uint32_t low) {
  return value >> low & ((1U << (high - low + 1)) - 1U);
}

// Splits the 8 bits of five trits (Khronos Data Format Specification 1.3, 23.12).
std::array<uint32_t, 5> split_trits(uint32_t packed) {
  std::array<uint32_t, 5> trits{};
  uint32_t rest = bits_of(packed, 4, 0);
  if (bits_of(packed, 4, 2) == 7) {
    rest = bits_of(packed, 7, 5) << 2 | bits_of(packed, 1, 0);
    trits[4] = trits[3] = 2;
  } else if (bits_of(packed, 6, 5) == 3) {
    trits[4] = 2;
    trits[3] = bits_of(packed, 7, 7);
  } else {
    trits[4] = bits_of(packed, 7, 7);
    trits[3] = bits_of(packed, 6, 5);
  }
  const auto lower = [&](uint32_t high_bit, uint32_t low_bit) { return high_bit << 1 | (low_bit & ~high_bit); };
  if (bits_of(rest, 1, 0) == 3) {
    trits[2] = 2;
    trits[1] = bits_of(rest, 4, 4);
    trits[0] = lower(bits_of(rest, 3, 3), bits_of(rest, 2, 2));
  } else if (bits_of(rest, 3, 2) == 3) {
    trits[2] = trits[1] = 2;
    trits[0] = bits_of(rest, 1, 0);
  } else {
    trits[2] = bits_of(rest, 4, 4);
    trits[1] = bits_of(rest, 3, 2);
    trits[0] = lower(bits_of(rest, 1, 1), bits_of(rest, 0, 0));
  }
  return trits;
}

// Splits the 7 bits of three quints (23.12).
std::array<uint32_t, 3> split_quints(uint32_t packed) {
  const uint32_t lowest = packed & 1U;
  if (bits_of(packed, 2, 1) == 3 && bits_of(packed, 6, 5) == 0) {
    return {4, 4, lowest << 2 | (bits_of(packed, 4, 4) & ~lowest) << 1 | (bits_of(packed, 3, 3) & ~lowest)};
  }
  uint32_t third = bits_of(packed, 6, 5), rest = bits_of(packed, 4, 0);
  if (bits_of(packed, 2, 1) == 3) {
    third = 4;
    rest = bits_of(packed, 4, 3) << 3 | (~bits_of(packed, 6, 5) & 3U) << 1 | lowest;
  }
  if (bits_of(rest, 2, 0) == 5) return {bits_of(rest, 4, 3), 4, third};
  return {bits_of(rest, 2, 0), bits_of(rest, 4, 3), third};
}

// Reads groups of values between whose bits those of their trits or quints are stored: `shares` of
// them after each value. The end of the last group is not stored and reads as 0.
template <size_t N, typename Split>
void read_groups(const BitField& block, uint32_t first, uint32_t end, AstcRange range, uint32_t count,
                 const std::array<uint8_t, N>& shares, const Split& split, AstcIntegers& integers) {
  uint32_t at = first;
  const auto take = [&](uint32_t bits) {
    const uint32_t stored = at >= end ? 0U : at + bits > end ? end - at : bits;
    const uint32_t value = block.get(at, stored);
    at += bits;
    return value;
  };
  for (uint32_t group = 0; group < count; group += N) {
    std::array<uint32_t, N> low{};
    uint32_t packed = 0, packed_bits = 0;
    for (size_t i = 0; i < N; ++i) {
      low[i] = take(range.bits);
      packed |= take(shares[i]) << packed_bits;
      packed_bits += shares[i];
    }
    const std::array<uint32_t, N> high = split(packed);
    for (size_t i = 0; i < N && group + i < count; ++i) integers[group + i] = high[i] << range.bits | low[i];
  }
}

// Repeats the lowest `bits` bits of a value until it is `width` wide.
uint32_t replicate(uint32_t value, int bits, int width) {
  uint32_t result = 0;
  for (int shift = width - bits; shift > -bits; shift -= bits) result |= shift >= 0 ? value << shift : value >> -shift;
  return result;
}

// Returns the bits that `pattern` describes from the highest to the lowest: 'a' to 'f' are bits 0
// to 5 of the value, '0' is zero.
uint32_t spread(const char* pattern, uint32_t value) {
  uint32_t result = 0;
  for (const char* c = pattern; *c != '\0'; ++c) result = result << 1 | (*c == '0' ? 0U : value >> (*c - 'a') & 1U);
  return result;
}

// The constants of unquantization by the number of bits below a trit or quint.
struct Unquantization {
  const char* b;
  uint32_t c;
};

constexpr std::array<Unquantization, 7> kColorTrits = {{{"", 0},
                                                        {"000000000", 204},
                                                        {"b000b0bb0", 93},
                                                        {"cb000cbcb", 44},
                                                        {"dcb000dcb", 22},
                                                        {"edcb000ed", 11},
                                                        {"fedcb000f", 5}}};
constexpr std::array<Unquantization, 6> kColorQuints = {
    {{"", 0}, {"000000000", 113}, {"b0000bb00", 54}, {"cb0000cbc", 26}, {"dcb0000dc", 13}, {"edcb0000e", 6}}};
constexpr std::array<Unquantization, 4> kWeightTrits = {{{"", 0}, {"0000000", 50}, {"b000b0b", 23}, {"cb000cb", 11}}};
constexpr std::array<Unquantization, 3> kWeightQuints = {{{"", 0}, {"0000000", 28}, {"b0000b0", 13}}};

} // namespace

void read_astc_integers(const BitField& block, uint32_t first, AstcRange range, uint32_t count,
                        AstcIntegers& integers) {
  assert(count <= kMaxAstcIntegers);
  const uint32_t end = first + astc_sequence_bits(range, count);
  if (range.base == 3) {
    constexpr std::array<uint8_t, 5> kShares = {2, 2, 1, 2, 1};
    read_groups(block, first, end, range, count, kShares, split_trits, integers);
  } else if (range.base == 5) {
    constexpr std::array<uint8_t, 3> kShares = {3, 2, 2};
    read_groups(block, first, end, range, count, kShares, split_quints, integers);
  } else {
    for (uint32_t i = 0; i < count; ++i) integers[i] = block.get(first + i * range.bits, range.bits);
  }
}

uint32_t astc_color_value(AstcRange range, uint32_t integer) {
  if (range.base == 1) return replicate(integer, range.bits, 8);
  const Unquantization& by = range.base == 3 ? kColorTrits[range.bits] : kColorQuints[range.bits];
  const uint32_t low = integer & ((1U << range.bits) - 1U), high = integer >> range.bits;
  const uint32_t a = (low & 1U) != 0 ? 511U : 0U;
  const uint32_t t = (high * by.c + spread(by.b, low)) ^ a;
  return (a & 0x80U) | t >> 2;
}

uint32_t astc_weight_value(AstcRange range, uint32_t integer) {
  uint32_t wide = 0; // 0 to 63
  if (range.base == 1) {
    wide = replicate(integer, range.bits, 6);
  } else if (range.bits == 0) {
    constexpr std::array<uint8_t, 3> kTrit = {0, 32, 63};
    constexpr std::array<uint8_t, 5> kQuint = {0, 16, 32, 47, 63};
    wide = range.base == 3 ? kTrit[integer] : kQuint[integer];
  } else {
    const Unquantization& by = range.base == 3 ? kWeightTrits[range.bits] : kWeightQuints[range.bits];
    const uint32_t low = integer & ((1U << range.bits) - 1U), high = integer >> range.bits;
    const uint32_t a = (low & 1U) != 0 ? 127U : 0U;
    const uint32_t t = (high * by.c + spread(by.b, low)) ^ a;
    wide = (a & 0x20U) | t >> 2;
  }
  return wide > 32 ? wide + 1 : wide;
}

} // namespace kindling::image_detail
