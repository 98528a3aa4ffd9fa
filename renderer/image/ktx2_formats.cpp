// Table of Vulkan's formats, and the decoding of plain and packed texels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/ktx2_formats.h"

#include "renderer/image/blocks/astc_block.h"
#include "renderer/image/blocks/bc1_block.h"
#include "renderer/image/blocks/bc6h_block.h"
#include "renderer/image/blocks/bc7_block.h"
#include "renderer/image/blocks/etc2_block.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace kindling::image_detail {

namespace {

using Encoding = Ktx2Encoding;
using Type = PixelType;

struct FormatRow {
  uint32_t vk_format;
  uint32_t vk_format_srgb; // the same texels, marked as sRGB; 0 if there is none
  Ktx2Format format;
};

constexpr std::array kFormats = {
    FormatRow{9, 15, {"R8", Encoding::plain, Type::u8, 1, 1}},
    FormatRow{16, 22, {"RG8", Encoding::plain, Type::u8, 2, 2}},
    FormatRow{23, 29, {"RGB8", Encoding::plain, Type::u8, 3, 3}},
    FormatRow{30, 36, {"BGR8", Encoding::plain_bgr, Type::u8, 3, 3}},
    FormatRow{37, 43, {"RGBA8", Encoding::plain, Type::u8, 4, 4}},
    FormatRow{44, 50, {"BGRA8", Encoding::plain_bgr, Type::u8, 4, 4}},
    FormatRow{58, 0, {"A2R10G10B10", Encoding::a2r10g10b10, Type::u16, 4, 4}},
    FormatRow{64, 0, {"A2B10G10R10", Encoding::a2b10g10r10, Type::u16, 4, 4}},
    FormatRow{70, 0, {"R16", Encoding::plain, Type::u16, 1, 2}},
    FormatRow{76, 0, {"R16 float", Encoding::plain, Type::f16, 1, 2}},
    FormatRow{77, 0, {"RG16", Encoding::plain, Type::u16, 2, 4}},
    FormatRow{83, 0, {"RG16 float", Encoding::plain, Type::f16, 2, 4}},
    FormatRow{84, 0, {"RGB16", Encoding::plain, Type::u16, 3, 6}},
    FormatRow{90, 0, {"RGB16 float", Encoding::plain, Type::f16, 3, 6}},
    FormatRow{91, 0, {"RGBA16", Encoding::plain, Type::u16, 4, 8}},
    FormatRow{97, 0, {"RGBA16 float", Encoding::plain, Type::f16, 4, 8}},
    FormatRow{100, 0, {"R32 float", Encoding::plain, Type::f32, 1, 4}},
    FormatRow{103, 0, {"RG32 float", Encoding::plain, Type::f32, 2, 8}},
    FormatRow{106, 0, {"RGB32 float", Encoding::plain, Type::f32, 3, 12}},
    FormatRow{109, 0, {"RGBA32 float", Encoding::plain, Type::f32, 4, 16}},
    FormatRow{122, 0, {"B10G11R11 float", Encoding::b10g11r11, Type::f16, 3, 4}},
    FormatRow{123, 0, {"E5B9G9R9 float", Encoding::e5b9g9r9, Type::f16, 3, 4}},
    FormatRow{131, 132, {"BC1", Encoding::bc1_rgb, Type::u8, 3, 8, 4, 4}},
    FormatRow{133, 134, {"BC1", Encoding::bc1_rgba, Type::u8, 4, 8, 4, 4}},
    FormatRow{135, 136, {"BC2", Encoding::bc2, Type::u8, 4, 16, 4, 4}},
    FormatRow{137, 138, {"BC3", Encoding::bc3, Type::u8, 4, 16, 4, 4}},
    FormatRow{139, 0, {"BC4", Encoding::bc4, Type::u16, 1, 8, 4, 4}},
    FormatRow{141, 0, {"BC5", Encoding::bc5, Type::u16, 2, 16, 4, 4}},
    FormatRow{143, 0, {"BC6H", Encoding::bc6h_unsigned, Type::f16, 3, 16, 4, 4}},
    FormatRow{144, 0, {"BC6H", Encoding::bc6h_signed, Type::f16, 3, 16, 4, 4}},
    FormatRow{145, 146, {"BC7", Encoding::bc7, Type::u8, 4, 16, 4, 4}},
    FormatRow{147, 148, {"ETC2", Encoding::etc2_rgb, Type::u8, 3, 8, 4, 4}},
    FormatRow{149, 150, {"ETC2", Encoding::etc2_cutout, Type::u8, 4, 8, 4, 4}},
    FormatRow{151, 152, {"ETC2", Encoding::etc2_rgba, Type::u8, 4, 16, 4, 4}},
    FormatRow{153, 0, {"EAC", Encoding::eac_r11, Type::u16, 1, 8, 4, 4}},
    FormatRow{155, 0, {"EAC", Encoding::eac_rg11, Type::u16, 2, 16, 4, 4}},
};

// ASTC's formats are numbered by these sizes; each is followed by its sRGB form, except for HDR.
constexpr std::array<std::array<uint8_t, 2>, 14> kAstcSizes = {{{4, 4},
                                                                {5, 4},
                                                                {5, 5},
                                                                {6, 5},
                                                                {6, 6},
                                                                {8, 5},
                                                                {8, 6},
                                                                {8, 8},
                                                                {10, 5},
                                                                {10, 6},
                                                                {10, 8},
                                                                {10, 10},
                                                                {12, 10},
                                                                {12, 12}}};
constexpr uint32_t kFirstAstc = 157, kFirstAstcHdr = 1000066000;

Ktx2Format astc_format(size_t size, Encoding encoding) {
  const Type type = encoding == Encoding::astc_hdr ? Type::f16 : Type::u8;
  return {"ASTC", encoding, type, 4, 16, kAstcSizes[size][0], kAstcSizes[size][1]};
}

uint32_t load_bits(BlockBytes bytes) {
  uint32_t value = 0;
  for (size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<uint32_t>(bytes[i]);
  return value;
}

void decode_plain(const Ktx2Format& format, BlockBytes block, TexelBlock& texels) {
  const size_t width = bytes_per_channel(format.type);
  for (size_t c = 0; c < format.channels; ++c) texels[0][c] = load_bits(block.subspan(c * width, width));
  if (format.encoding == Encoding::plain_bgr) std::swap(texels[0][0], texels[0][2]);
}

// Widens 10 bits of color and 2 of alpha to 16.
void decode_ten_bits(uint32_t packed, bool red_is_highest, TexelBlock& texels) {
  for (uint32_t c = 0; c < 3; ++c) {
    const uint32_t value = packed >> (10 * (red_is_highest ? 2 - c : c)) & 1023U;
    texels[0][c] = (value * 65535U + 511U) / 1023U;
  }
  texels[0][3] = (packed >> 30) * 21845U;
}

// Floats of 11 and 10 bits without sign are halves without their lowest bits.
void decode_small_floats(uint32_t packed, TexelBlock& texels) {
  texels[0] = {(packed & 2047U) << 4, (packed >> 11 & 2047U) << 4, (packed >> 22) << 5, 0};
}

// Returns the half of mantissa * 2^(exponent - 24), exactly; the mantissa has 9 bits, the
// exponent 5.
uint32_t half_of(uint32_t mantissa, uint32_t exponent) {
  if (mantissa == 0) return 0;
  constexpr uint32_t kHidden = 1U << 10;
  for (; exponent > 0 && (mantissa & kHidden) == 0; --exponent) mantissa <<= 1;
  return (mantissa & kHidden) != 0 ? (exponent + 1) << 10 | (mantissa & (kHidden - 1)) : mantissa;
}

void decode_common_exponent(uint32_t packed, TexelBlock& texels) {
  const uint32_t exponent = packed >> 27;
  for (uint32_t c = 0; c < 3; ++c) texels[0][c] = half_of(packed >> (9 * c) & 511U, exponent);
}

} // namespace

std::optional<Ktx2Format> find_ktx2_format(uint32_t vk_format) {
  if (vk_format >= kFirstAstc && vk_format < kFirstAstc + 2 * kAstcSizes.size()) {
    const uint32_t index = vk_format - kFirstAstc;
    return astc_format(index / 2, index % 2 == 0 ? Encoding::astc : Encoding::astc_srgb);
  }
  if (vk_format >= kFirstAstcHdr && vk_format < kFirstAstcHdr + kAstcSizes.size()) {
    return astc_format(vk_format - kFirstAstcHdr, Encoding::astc_hdr);
  }
  const auto row = std::find_if(kFormats.begin(), kFormats.end(), [&](const FormatRow& f) {
    return vk_format != 0 && (f.vk_format == vk_format || f.vk_format_srgb == vk_format);
  });
  if (row == kFormats.end()) return std::nullopt;
  return row->format;
}

std::string_view ktx2_format_list() {
  return "0 (ETC1S, UASTC), unsigned fractions of 8 and 16 bits, floats of 16 and 32 bits, 10-bit, 11-bit and shared "
         "exponent colors, unsigned BC1 to BC7, ETC2, EAC and ASTC";
}

bool decode_ktx2_block(const Ktx2Format& format, BlockBytes block, TexelBlock& texels) {
  assert(block.size() == format.bytes);
  switch (format.encoding) {
  case Encoding::plain:
  case Encoding::plain_bgr: decode_plain(format, block, texels); break;
  case Encoding::a2b10g10r10: decode_ten_bits(load_bits(block), false, texels); break;
  case Encoding::a2r10g10b10: decode_ten_bits(load_bits(block), true, texels); break;
  case Encoding::b10g11r11: decode_small_floats(load_bits(block), texels); break;
  case Encoding::e5b9g9r9: decode_common_exponent(load_bits(block), texels); break;
  case Encoding::bc1_rgb: decode_bc1(block, false, texels); break;
  case Encoding::bc1_rgba: decode_bc1(block, true, texels); break;
  case Encoding::bc2: decode_bc2(block, texels); break;
  case Encoding::bc3: decode_bc3(block, texels); break;
  case Encoding::bc4: decode_bc4(block, texels); break;
  case Encoding::bc5: decode_bc5(block, texels); break;
  case Encoding::bc6h_unsigned: decode_bc6h(block, false, texels); break;
  case Encoding::bc6h_signed: decode_bc6h(block, true, texels); break;
  case Encoding::bc7: decode_bc7(block, texels); break;
  case Encoding::etc2_rgb: decode_etc2_rgb(block, texels); break;
  case Encoding::etc2_cutout: decode_etc2_cutout(block, texels); break;
  case Encoding::etc2_rgba: decode_etc2_rgba(block, texels); break;
  case Encoding::eac_r11: decode_eac_r11(block, texels); break;
  case Encoding::eac_rg11: decode_eac_rg11(block, texels); break;
  case Encoding::astc: return decode_astc(block, format.block_width, format.block_height, AstcProfile::linear, texels);
  case Encoding::astc_srgb:
    return decode_astc(block, format.block_width, format.block_height, AstcProfile::srgb, texels);
  case Encoding::astc_hdr: return decode_astc(block, format.block_width, format.block_height, AstcProfile::hdr, texels);
  }
  return true;
}

} // namespace kindling::image_detail
