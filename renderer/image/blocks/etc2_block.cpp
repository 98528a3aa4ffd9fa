// Decoders of ETC2 and EAC blocks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/etc2_block.h"

namespace kindling::image_detail {

namespace {

// The 64 bits of a block, whose first byte is the highest.
class EtcBits {
 public:
  explicit EtcBits(BlockBytes block) {
    for (size_t i = 0; i < 8; ++i) bits_ = bits_ << 8 | static_cast<uint64_t>(block[i]);
  }

  // Returns the bits `high` to `low`.
  [[nodiscard]] int get(uint32_t high, uint32_t low) const {
    return static_cast<int>(bits_ >> low & ((uint64_t{1} << (high - low + 1)) - 1));
  }

  // Returns the bits as a number of two's complement.
  [[nodiscard]] int get_signed(uint32_t high, uint32_t low) const {
    const int value = get(high, low), half = 1 << (high - low);
    return value >= half ? value - 2 * half : value;
  }

  // Returns the two bits of a texel; texels are numbered down the columns.
  [[nodiscard]] uint32_t selector(uint32_t texel) const {
    return static_cast<uint32_t>(2 * get(texel + 16, texel + 16) + get(texel, texel));
  }

 private:
  uint64_t bits_ = 0;
};

using Rgb = std::array<int, 3>;

constexpr std::array<std::array<int, 2>, 8> kModifiers = {
    {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}}};
constexpr std::array<int, 8> kDistances = {3, 6, 11, 16, 23, 32, 41, 64};
constexpr Texel kTransparent = {0, 0, 0, 0};

Texel offset(const Rgb& color, int by) {
  return {clamp_to(color[0] + by, 255), clamp_to(color[1] + by, 255), clamp_to(color[2] + by, 255), 255};
}

Rgb widen4(int r, int g, int b) { return {17 * r, 17 * g, 17 * b}; }
Rgb widen5(int r, int g, int b) { return {r << 3 | r >> 2, g << 3 | g >> 2, b << 3 | b >> 2}; }

// Returns the place of a texel, which blocks number down the columns, in rows.
constexpr size_t in_rows(uint32_t texel) { return size_t{4} * (texel % 4) + texel / 4; }

void paint(const EtcBits& bits, const std::array<Texel, 4>& colors, TexelBlock& texels) {
  for (uint32_t i = 0; i < 16; ++i) texels[in_rows(i)] = colors[bits.selector(i)];
}

// Two halves with a base color each, and one of eight pairs of modifiers.
void decode_halves(const EtcBits& bits, const std::array<Rgb, 2>& bases, bool opaque, TexelBlock& texels) {
  const bool flipped = bits.get(32, 32) != 0; // upper and lower instead of left and right
  const std::array<int, 2> tables = {bits.get(39, 37), bits.get(36, 34)};
  for (uint32_t i = 0; i < 16; ++i) {
    const uint32_t x = i / 4, y = i % 4;
    const size_t half = (flipped ? y : x) / 2;
    const auto& modifiers = kModifiers[static_cast<size_t>(tables[half])];
    const uint32_t selector = bits.selector(i);
    const int size = selector % 2 != 0 ? modifiers[1] : opaque ? modifiers[0] : 0;
    texels[in_rows(i)] = !opaque && selector == 2 ? kTransparent : offset(bases[half], selector < 2 ? size : -size);
  }
}

void decode_t(const EtcBits& bits, bool opaque, TexelBlock& texels) {
  const Rgb first = widen4(bits.get(60, 59) << 2 | bits.get(57, 56), bits.get(55, 52), bits.get(51, 48));
  const Rgb second = widen4(bits.get(47, 44), bits.get(43, 40), bits.get(39, 36));
  const int distance = kDistances[static_cast<size_t>(bits.get(35, 34) << 1 | bits.get(32, 32))];
  paint(bits,
        {offset(first, 0), offset(second, distance), opaque ? offset(second, 0) : kTransparent,
         offset(second, -distance)},
        texels);
}

void decode_h(const EtcBits& bits, bool opaque, TexelBlock& texels) {
  const Rgb first =
      widen4(bits.get(62, 59), bits.get(58, 56) << 1 | bits.get(52, 52), bits.get(51, 51) << 3 | bits.get(49, 47));
  const Rgb second = widen4(bits.get(46, 43), bits.get(42, 39), bits.get(38, 35));
  const int order = first >= second ? 1 : 0; // the lowest bit of the distance
  const int distance = kDistances[static_cast<size_t>(bits.get(34, 34) << 2 | bits.get(32, 32) << 1 | order)];
  paint(bits,
        {offset(first, distance), offset(first, -distance), opaque ? offset(second, distance) : kTransparent,
         offset(second, -distance)},
        texels);
}

// A plane through three colors: at the origin, and four texels to the right and down.
void decode_planar(const EtcBits& bits, TexelBlock& texels) {
  const auto widen6 = [](int v) { return v << 2 | v >> 4; };
  const auto widen7 = [](int v) { return v << 1 | v >> 6; };
  const Rgb origin = {widen6(bits.get(62, 57)), widen7(bits.get(56, 56) << 6 | bits.get(54, 49)),
                      widen6(bits.get(48, 48) << 5 | bits.get(44, 43) << 3 | bits.get(41, 39))};
  const Rgb right = {widen6(bits.get(38, 34) << 1 | bits.get(32, 32)), widen7(bits.get(31, 25)),
                     widen6(bits.get(24, 19))};
  const Rgb down = {widen6(bits.get(18, 13)), widen7(bits.get(12, 6)), widen6(bits.get(5, 0))};
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      Texel& texel = texels[static_cast<size_t>(4 * y + x)];
      for (size_t c = 0; c < 3; ++c) {
        texel[c] = clamp_to((x * (right[c] - origin[c]) + y * (down[c] - origin[c]) + 4 * origin[c] + 2) >> 2, 255);
      }
      texel[3] = 255;
    }
  }
}

// `with_cutout`: bit 33 is set if the block is opaque; else it selects individual base colors.
void decode_color(BlockBytes block, bool with_cutout, TexelBlock& texels) {
  const EtcBits bits(block);
  const bool flag = bits.get(33, 33) != 0;
  const bool opaque = !with_cutout || flag;
  if (!with_cutout && !flag) {
    decode_halves(bits,
                  {widen4(bits.get(63, 60), bits.get(55, 52), bits.get(47, 44)),
                   widen4(bits.get(59, 56), bits.get(51, 48), bits.get(43, 40))},
                  true, texels);
    return;
  }
  const Rgb base = {bits.get(63, 59), bits.get(55, 51), bits.get(47, 43)};
  const Rgb sum = {base[0] + bits.get_signed(58, 56), base[1] + bits.get_signed(50, 48),
                   base[2] + bits.get_signed(42, 40)};
  const auto overflows = [](int value) { return value < 0 || value > 31; };
  if (overflows(sum[0])) {
    decode_t(bits, opaque, texels);
  } else if (overflows(sum[1])) {
    decode_h(bits, opaque, texels);
  } else if (overflows(sum[2])) {
    decode_planar(bits, texels);
  } else {
    decode_halves(bits, {widen5(base[0], base[1], base[2]), widen5(sum[0], sum[1], sum[2])}, opaque, texels);
  }
}

constexpr std::array<std::array<int8_t, 8>, 16> kEacModifiers = {{{-3, -6, -9, -15, 2, 5, 8, 14},
                                                                  {-3, -7, -10, -13, 2, 6, 9, 12},
                                                                  {-2, -5, -8, -13, 1, 4, 7, 12},
                                                                  {-2, -4, -6, -13, 1, 3, 5, 12},
                                                                  {-3, -6, -8, -12, 2, 5, 7, 11},
                                                                  {-3, -7, -9, -11, 2, 6, 8, 10},
                                                                  {-4, -7, -8, -11, 3, 6, 7, 10},
                                                                  {-3, -5, -8, -11, 2, 4, 7, 10},
                                                                  {-2, -6, -8, -10, 1, 5, 7, 9},
                                                                  {-2, -5, -8, -10, 1, 4, 7, 9},
                                                                  {-2, -4, -8, -10, 1, 3, 7, 9},
                                                                  {-2, -5, -7, -10, 1, 4, 6, 9},
                                                                  {-3, -4, -7, -10, 2, 3, 6, 9},
                                                                  {-1, -2, -3, -10, 0, 1, 2, 9},
                                                                  {-4, -6, -8, -9, 3, 5, 7, 8},
                                                                  {-3, -5, -7, -9, 2, 4, 6, 8}}};

// Decodes one channel: to 8 bits as alpha of ETC2, or by 11 bits to 16.
void decode_eac(BlockBytes block, size_t channel, bool as_alpha, TexelBlock& texels) {
  const EtcBits bits(block);
  const int base = bits.get(63, 56), multiplier = bits.get(55, 52);
  const auto& modifiers = kEacModifiers[static_cast<size_t>(bits.get(51, 48))];
  for (uint32_t i = 0; i < 16; ++i) {
    const int modifier = modifiers[static_cast<size_t>(bits.get(47 - 3 * i, 45 - 3 * i))];
    uint32_t& value = texels[in_rows(i)][channel];
    if (as_alpha) {
      value = clamp_to(base + modifier * multiplier, 255);
    } else {
      const int step = multiplier == 0 ? 1 : 8 * multiplier;
      value = (clamp_to(8 * base + 4 + modifier * step, 2047) * 65535 + 1023) / 2047;
    }
  }
}

} // namespace

void decode_etc2_rgb(BlockBytes block, TexelBlock& texels) { decode_color(block, false, texels); }
void decode_etc2_cutout(BlockBytes block, TexelBlock& texels) { decode_color(block, true, texels); }

void decode_etc2_rgba(BlockBytes block, TexelBlock& texels) {
  decode_color(block.subspan(8), false, texels);
  decode_eac(block.first(8), 3, true, texels);
}

void decode_eac_r11(BlockBytes block, TexelBlock& texels) {
  for (size_t i = 0; i < 16; ++i) texels[i] = {0, 0, 0, 65535};
  decode_eac(block, 0, false, texels);
}

void decode_eac_rg11(BlockBytes block, TexelBlock& texels) {
  decode_eac_r11(block.first(8), texels);
  decode_eac(block.subspan(8), 1, false, texels);
}

} // namespace kindling::image_detail
