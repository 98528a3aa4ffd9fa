// Decoder of UASTC blocks: endpoints, weights, interpolation.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/uastc_block.h"

#include "renderer/image/uastc_tables.h"

#include <cassert>

namespace kindling::image_detail {

namespace {

// Reads the 128 bits of a block, starting at the lowest.
class BlockBits {
 public:
  explicit BlockBits(std::span<const std::byte, 16> block) {
    for (size_t i = 8; i-- > 0;) {
      low_ = low_ << 8 | static_cast<uint64_t>(block[i]);
      high_ = high_ << 8 | static_cast<uint64_t>(block[i + 8]);
    }
  }

  [[nodiscard]] uint32_t first(int count) const { return static_cast<uint32_t>(low_ & ((1ULL << count) - 1)); }

  // Reads 0 to 31 bits.
  uint32_t take(int count) {
    assert(count >= 0 && count < 32);
    const uint32_t value = first(count);
    skip(count);
    return value;
  }

  void skip(int count) {
    if (count == 0) return;
    low_ = low_ >> count | high_ << (64 - count);
    high_ >>= count;
  }

 private:
  uint64_t low_ = 0, high_ = 0;
};

constexpr size_t kMaxEndpointValues = 18; // 3 subsets of RGB pairs

// Reads the simplified integer sequence of UASTC: codes of up to 5 trits or 3 quints, then the bits
// of each value. Returns false if a code is out of range.
bool read_endpoint_values(BlockBits& bits, const UastcMode& mode, size_t count,
                          std::array<uint32_t, kMaxEndpointValues>& values) {
  values.fill(0);
  if (mode.endpoint_base > 1) {
    const uint32_t base = mode.endpoint_base;
    const size_t group = base == 3 ? 5 : 3;
    constexpr std::array<int, 6> kTritBits = {0, 2, 4, 5, 7, 8};
    constexpr std::array<int, 4> kQuintBits = {0, 3, 5, 7};
    for (size_t first = 0; first < count; first += group) {
      const size_t in_group = count - first < group ? count - first : group;
      uint32_t code = bits.take(base == 3 ? kTritBits[in_group] : kQuintBits[in_group]);
      for (size_t i = 0; i < in_group; ++i, code /= base) values[first + i] = code % base << mode.endpoint_bits;
      if (code != 0) return false;
    }
  }
  for (size_t i = 0; i < count; ++i) values[i] |= bits.take(mode.endpoint_bits);
  return true;
}

// Maps a weight of 1 to 5 bits to 0 to 64: widened to 6 bits by replication, with the upper half
// incremented.
uint32_t unquantize_weight(uint32_t weight, int bits) {
  constexpr std::array<std::array<uint8_t, 32>, 6> kWeights = [] {
    std::array<std::array<uint8_t, 32>, 6> table{};
    for (int b = 1; b <= 5; ++b) {
      for (int w = 0; w < 1 << b; ++w) {
        int wide = 0;
        for (int shift = 6 - b; shift > -b; shift -= b) wide |= shift >= 0 ? w << shift : w >> -shift;
        table[static_cast<size_t>(b)][static_cast<size_t>(w)] = static_cast<uint8_t>(wide > 32 ? wide + 1 : wide);
      }
    }
    return table;
  }();
  return kWeights[static_cast<size_t>(bits)][weight];
}

// RGBA of both endpoints of a subset.
struct Endpoints {
  std::array<uint32_t, 4> low, high;
};

Endpoints to_endpoints(int mode_index, const UastcMode& mode, const uint32_t* values) {
  Endpoints ends{{0, 0, 0, 255}, {0, 0, 0, 255}};
  const auto set = [&](size_t channel, size_t pair) {
    ends.low[channel] = uastc_endpoint(mode_index, values[2 * pair]);
    ends.high[channel] = uastc_endpoint(mode_index, values[2 * pair + 1]);
  };
  if (mode.components == 2) { // luminance and alpha
    for (size_t c = 0; c < 3; ++c) set(c, 0);
    set(3, 1);
  } else {
    for (size_t c = 0; c < mode.components; ++c) set(c, c);
  }
  return ends;
}

uint8_t interpolate(uint32_t low, uint32_t high, uint32_t weight) {
  return static_cast<uint8_t>((low * 257U * (64U - weight) + high * 257U * weight + 32U) >> 6 >> 8);
}

} // namespace

bool decode_uastc_block(std::span<const std::byte, 16> block, BlockTexels& texels) {
  BlockBits bits(block);
  const int mode_index = uastc_mode_of(bits.first(7));
  if (mode_index == kUastcReservedMode) return false;
  const UastcMode& mode = kUastcMode[static_cast<size_t>(mode_index)];
  bits.skip(mode.code_bits);
  if (mode_index == kUastcSolidMode) {
    for (uint8_t& channel : texels[0]) channel = static_cast<uint8_t>(bits.take(8));
    texels.fill(texels[0]);
    return true;
  }
  bits.skip(mode.hint_bits);

  static constexpr UastcPattern kOneSubset{};
  const UastcPattern* pattern = &kOneSubset;
  if (mode.subsets > 1) {
    pattern = uastc_pattern(mode_index, bits.take(uastc_pattern_bits(mode)));
    if (pattern == nullptr) return false;
  }
  // The channel with the weights of the second plane; always alpha for luminance-alpha modes.
  const uint32_t second = mode.planes == 1 ? 4U : mode.components == 2 ? 3U : bits.take(2);

  std::array<uint32_t, kMaxEndpointValues> values;
  const size_t values_each = size_t{2} * mode.components;
  if (!read_endpoint_values(bits, mode, values_each * mode.subsets, values)) return false;
  std::array<Endpoints, 3> ends;
  for (size_t s = 0; s < mode.subsets; ++s) ends[s] = to_endpoints(mode_index, mode, values.data() + s * values_each);

  for (size_t i = 0; i < texels.size(); ++i) {
    const uint8_t subset = pattern->subset[i];
    const int stored_bits = mode.weight_bits - (pattern->anchors[subset] == i ? 1 : 0);
    std::array<uint32_t, 2> weights;
    for (size_t plane = 0; plane < mode.planes; ++plane) {
      weights[plane] = unquantize_weight(bits.take(stored_bits), mode.weight_bits);
    }
    const Endpoints& e = ends[subset];
    for (size_t c = 0; c < 4; ++c) texels[i][c] = interpolate(e.low[c], e.high[c], weights[c == second ? 1 : 0]);
  }
  return true;
}

} // namespace kindling::image_detail
