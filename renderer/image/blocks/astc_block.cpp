// Decoder of ASTC blocks: layout, weights and interpolation.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/astc_block.h"

#include "renderer/image/blocks/astc_endpoints.h"
#include "renderer/image/blocks/astc_integers.h"
#include "renderer/image/blocks/astc_partition.h"

#include <algorithm>
#include <bit>
#include <optional>

namespace kindling::image_detail {

namespace {

constexpr uint32_t kBlockBits = 128;

// The grid of weights: its size, the range of a weight, and their number for each texel.
struct WeightGrid {
  uint32_t width = 0, height = 0, planes = 1;
  AstcRange range{};

  [[nodiscard]] uint32_t count() const { return width * height * planes; }
  [[nodiscard]] uint32_t bits() const { return astc_sequence_bits(range, count()); }
};

// Reads the block mode in the lowest 11 bits (23.10); nothing for reserved ones.
std::optional<WeightGrid> read_grid(const BitField& block) {
  const uint32_t a = block.get(5, 2), b = block.get(7, 2);
  uint32_t range = block.get(4, 1), precise = block.get(9, 1), planes = block.get(10, 1) + 1;
  WeightGrid grid;
  if (block.get(0, 2) != 0) {
    range |= block.get(0, 2) << 1;
    switch (block.get(2, 2)) {
    case 0: grid = {b + 4, a + 2}; break;
    case 1: grid = {b + 8, a + 2}; break;
    case 2: grid = {a + 2, b + 8}; break;
    default: grid = b < 2 ? WeightGrid{a + 2, b + 6} : WeightGrid{b, a + 2}; // b - 2 + 2
    }
  } else {
    range |= block.get(2, 2) << 1;
    if (range < 2) return std::nullopt;
    switch (b) {
    case 0: grid = {12, a + 2}; break;
    case 1: grid = {a + 2, 12}; break;
    case 2:
      grid = {a + 6, block.get(9, 2) + 6};
      precise = 0;
      planes = 1;
      break;
    default:
      if (a > 1) return std::nullopt;
      grid = a == 0 ? WeightGrid{6, 10} : WeightGrid{10, 6};
    }
  }
  grid.planes = planes;
  grid.range = kAstcRanges[range - 2 + 6 * precise];
  return grid;
}

// Returns the weights of the grid as 0 to 64, planes interleaved. They are stored from the highest
// bit of the block downwards.
AstcIntegers read_weights(BlockBytes block, const WeightGrid& grid) {
  std::array<std::byte, 16> reversed;
  for (size_t i = 0; i < 16; ++i) {
    auto byte = static_cast<uint32_t>(block[15 - i]);
    byte = (byte & 0xf0U) >> 4 | (byte & 0x0fU) << 4;
    byte = (byte & 0xccU) >> 2 | (byte & 0x33U) << 2;
    reversed[i] = static_cast<std::byte>((byte & 0xaaU) >> 1 | (byte & 0x55U) << 1);
  }
  AstcIntegers weights{};
  read_astc_integers(BitField(reversed), 0, grid.range, grid.count(), weights);
  for (uint32_t i = 0; i < grid.count(); ++i) weights[i] = astc_weight_value(grid.range, weights[i]);
  return weights;
}

// The weights around each column or row of texels (23.18): the first one and the share of the
// next, in sixteenths.
struct GridPosition {
  uint32_t first, share;
};

GridPosition grid_position(uint32_t texel, uint32_t block_size, uint32_t grid_size) {
  const uint32_t scale = (1024 + block_size / 2) / (block_size - 1);
  const uint32_t position = (scale * texel * (grid_size - 1) + 32) >> 6;
  return {position >> 4, position & 15U};
}

uint32_t interpolate_weight(const AstcIntegers& weights, const WeightGrid& grid, GridPosition x, GridPosition y,
                            uint32_t plane) {
  const uint32_t both = (x.share * y.share + 8) >> 4;
  const uint32_t at = y.first * grid.width + x.first;
  const auto weight = [&](uint32_t index, uint32_t share) {
    return share == 0 ? 0U : weights[index * grid.planes + plane] * share;
  };
  return (weight(at, 16 - x.share - y.share + both) + weight(at + 1, x.share - both) +
          weight(at + grid.width, y.share - both) + weight(at + grid.width + 1, both) + 8) >>
         4;
}

// Everything of a block but its weights.
struct Colors {
  uint32_t subsets = 1;
  uint32_t partition_index = 0;
  uint32_t second_plane = 4; // the channel with the weights of the second plane
  std::array<AstcEndpoints, 4> ends{};
};

// Reads the endpoint modes of all subsets (23.11). `below` is the first bit of the weights, and is
// lowered by the bits of modes that are stored before them.
std::array<uint32_t, 4> read_endpoint_modes(const BitField& block, uint32_t subsets, uint32_t& below) {
  std::array<uint32_t, 4> modes{};
  if (subsets == 1) {
    modes[0] = block.get(13, 4);
    return modes;
  }
  uint32_t bits = block.get(23, 6);
  const uint32_t selector = bits & 3U;
  if (selector == 0) {
    modes.fill(bits >> 2);
    return modes;
  }
  const uint32_t extra = 3 * subsets - 4;
  below -= extra;
  bits |= block.get(below, extra) << 6;
  for (uint32_t s = 0; s < subsets; ++s) {
    const uint32_t of_class = bits >> (2 + s) & 1U, in_class = bits >> (2 + subsets + 2 * s) & 3U;
    modes[s] = 4 * (selector - 1 + of_class) + in_class;
  }
  return modes;
}

std::optional<Colors> read_colors(const BitField& block, const WeightGrid& grid) {
  Colors colors;
  colors.subsets = block.get(11, 2) + 1;
  if (colors.subsets == 4 && grid.planes == 2) return std::nullopt;
  if (colors.subsets > 1) colors.partition_index = block.get(13, 10);
  uint32_t below = kBlockBits - grid.bits();
  const std::array<uint32_t, 4> modes = read_endpoint_modes(block, colors.subsets, below);
  if (grid.planes == 2) {
    below -= 2;
    colors.second_plane = block.get(below, 2);
  }
  const uint32_t first = colors.subsets == 1 ? 17 : 29;
  uint32_t count = 0;
  for (uint32_t s = 0; s < colors.subsets; ++s) count += astc_endpoint_values(modes[s]);
  constexpr uint32_t kMaxValues = 18;
  if (count > kMaxValues || below < first) return std::nullopt;

  size_t range = kAstcRanges.size();
  while (range > 0 && astc_sequence_bits(kAstcRanges[range - 1], count) > below - first) --range;
  constexpr size_t kLowestColorRange = 4; // 6 levels
  if (range <= kLowestColorRange) return std::nullopt;
  const AstcRange color_range = kAstcRanges[range - 1];
  AstcIntegers values{};
  read_astc_integers(block, first, color_range, count, values);
  for (uint32_t i = 0; i < count; ++i) values[i] = astc_color_value(color_range, values[i]);
  std::span<const uint32_t> rest(values);
  for (uint32_t s = 0; s < colors.subsets; ++s) {
    colors.ends[s] = astc_endpoints(modes[s], rest);
    rest = rest.subspan(astc_endpoint_values(modes[s]));
  }
  return colors;
}

// Returns the half nearest to a fraction of 65536 towards 0; 65535 is 1 (23.19).
uint32_t unorm16_to_half(uint32_t value) {
  if (value == 65535) return 0x3c00;
  if (value < 4) return value << 8;                                       // denormal
  const auto exponent = static_cast<uint32_t>(std::bit_width(value)) - 1; // of value / 65536, plus 16
  return (exponent - 1) << 10 | ((value << (16 - exponent) & 0xffffU) >> 6);
}

// Returns the half of a logarithmic value of 16 bits (23.19).
uint32_t logarithm_to_half(uint32_t value) {
  const uint32_t mantissa = value & 2047U;
  const uint32_t bent = mantissa < 512 ? 3 * mantissa : mantissa < 1536 ? 4 * mantissa - 512 : 5 * mantissa - 2048;
  constexpr uint32_t kMaxHalf = 0x7bff;
  return std::min((value >> 11) << 10 | bent >> 3, kMaxHalf);
}

// Interpolates one channel (23.19). `srgb`: of an sRGB texture, and not alpha.
uint32_t interpolate(int low, int high, uint32_t weight, bool hdr_value, bool srgb, bool to_half) {
  const auto widen = [&](int end) {
    const auto value = static_cast<uint32_t>(end);
    if (hdr_value) return value << 4;
    return srgb ? value << 8 | 0x80U : value * 257U;
  };
  const uint32_t value = (widen(low) * (64 - weight) + widen(high) * weight + 32) >> 6;
  if (!to_half) return value >> 8;
  return hdr_value ? logarithm_to_half(value) : unorm16_to_half(value);
}

// A block of one color (23.23): 16 bits for each channel, or halves.
bool decode_void_extent(const BitField& block, size_t texel_count, AstcProfile profile, TexelBlock& texels) {
  const bool hdr_color = block.get(9, 1) != 0;
  if (hdr_color && profile != AstcProfile::hdr) return false;
  if (block.get(10, 2) != 3) return false;
  const std::array<uint32_t, 4> extent = {block.get(12, 13), block.get(25, 13), block.get(38, 13), block.get(51, 13)};
  const bool unknown = std::all_of(extent.begin(), extent.end(), [](uint32_t e) { return e == 0x1fff; });
  if (!unknown && (extent[0] >= extent[1] || extent[2] >= extent[3])) return false;
  Texel color{};
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t value = block.get(64 + 16 * c, 16);
    color[c] = hdr_color ? value : profile == AstcProfile::hdr ? unorm16_to_half(value) : value >> 8;
  }
  std::fill_n(texels.begin(), texel_count, color);
  return true;
}

} // namespace

bool decode_astc(BlockBytes bytes, uint32_t width, uint32_t height, AstcProfile profile, TexelBlock& texels) {
  assert(bytes.size() == 16 && size_t{width} * height <= kMaxBlockTexels);
  const BitField block(bytes);
  if (block.get(0, 9) == 0x1fc) return decode_void_extent(block, size_t{width} * height, profile, texels);
  const std::optional<WeightGrid> grid = read_grid(block);
  if (!grid || grid->width > width || grid->height > height || grid->count() > kMaxAstcIntegers) return false;
  constexpr uint32_t kMinWeightBits = 24, kMaxWeightBits = 96;
  if (grid->bits() < kMinWeightBits || grid->bits() > kMaxWeightBits) return false;
  const std::optional<Colors> colors = read_colors(block, *grid);
  if (!colors) return false;

  const AstcIntegers weights = read_weights(bytes, *grid);
  const AstcPartition partition(colors->partition_index, colors->subsets, width * height < 31);
  for (uint32_t y = 0; y < height; ++y) {
    const GridPosition grid_y = grid_position(y, height, grid->height);
    for (uint32_t x = 0; x < width; ++x) {
      const GridPosition grid_x = grid_position(x, width, grid->width);
      std::array<uint32_t, 2> weight{};
      for (uint32_t plane = 0; plane < grid->planes; ++plane) {
        weight[plane] = interpolate_weight(weights, *grid, grid_x, grid_y, plane);
      }
      const AstcEndpoints& ends = colors->ends[colors->subsets == 1 ? 0 : partition.subset(x, y)];
      if (ends.hdr_color && profile != AstcProfile::hdr) return false;
      Texel& texel = texels[size_t{y} * width + x];
      for (uint32_t c = 0; c < 4; ++c) {
        const bool hdr_value = c < 3 ? ends.hdr_color : ends.hdr_alpha;
        texel[c] = interpolate(ends.low[c], ends.high[c], weight[c == colors->second_plane ? 1 : 0], hdr_value,
                               profile == AstcProfile::srgb && c < 3, profile == AstcProfile::hdr);
      }
    }
  }
  return true;
}

} // namespace kindling::image_detail
