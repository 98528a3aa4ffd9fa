// Parser of BasisLZ global data: image descriptions, codebooks and Huffman tables.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/etc1s_codebooks.h"

#include "renderer/image/ktx2_container.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::image_detail {

namespace {

// Reads endpoints, which are stored as differences to the previous endpoint.
std::vector<Etc1sEndpoint> read_endpoints(BitReader& bits, size_t count) {
  std::array<HuffmanTable, 3> color_delta; // by the previous value: dark, middle or bright
  for (HuffmanTable& table : color_delta) table = HuffmanTable::read(bits);
  const HuffmanTable intensity_delta = HuffmanTable::read(bits);
  const bool gray = bits.take(1) != 0;
  std::vector<Etc1sEndpoint> endpoints;
  Etc1sEndpoint endpoint{{16, 16, 16}, 0};
  while (endpoints.size() < count && bits.ok()) {
    endpoint.intensity = static_cast<uint8_t>((endpoint.intensity + intensity_delta.decode(bits)) & 7U);
    for (size_t c = 0; c < (gray ? 1U : 3U); ++c) {
      const size_t range = endpoint.color[c] < 10 ? 0 : endpoint.color[c] < 22 ? 1 : 2;
      endpoint.color[c] = static_cast<uint8_t>((endpoint.color[c] + color_delta[range].decode(bits)) & 31U);
    }
    if (gray) endpoint.color.fill(endpoint.color[0]);
    endpoints.push_back(endpoint);
  }
  return endpoints;
}

// Reads selectors, which are stored plainly or as the exclusive or with the rows of the previous
// selector.
std::vector<Etc1sSelector> read_selectors(BitReader& bits, size_t count) {
  if (bits.take(2) != 0) bits.fail();
  const bool plain = bits.take(1) != 0;
  const HuffmanTable delta = plain ? HuffmanTable() : HuffmanTable::read(bits);
  std::vector<Etc1sSelector> selectors;
  Etc1sSelector selector;
  while (selectors.size() < count && bits.ok()) {
    for (uint8_t& row : selector.rows) {
      if (plain || selectors.empty()) {
        row = static_cast<uint8_t>(bits.take(8));
      } else {
        row = static_cast<uint8_t>(row ^ delta.decode(bits));
      }
    }
    selectors.push_back(selector);
  }
  return selectors;
}

} // namespace

Result<Etc1sData> read_etc1s_data(Bytes globals, uint32_t images) {
  constexpr uint64_t kHeaderBytes = 20, kImageBytes = 20;
  if (globals.size() < kHeaderBytes + kImageBytes * images) return detail_error("its BasisLZ data end in their header");
  const size_t endpoint_count = load_u16(globals, 0), selector_count = load_u16(globals, 2);
  const std::array<uint64_t, 3> lengths = {load_u32(globals, 4), load_u32(globals, 8), load_u32(globals, 12)};
  const uint64_t total = kHeaderBytes + kImageBytes * images + lengths[0] + lengths[1] + lengths[2];
  if (total > globals.size()) {
    return detail_error(fmt::format("its BasisLZ data have {} bytes and need {}", globals.size(), total));
  }
  if (endpoint_count == 0 || selector_count == 0) return detail_error("its BasisLZ codebooks are empty");

  Etc1sData data;
  constexpr size_t at = kHeaderBytes; // the image of level 0
  if ((load_u32(globals, at) & 2U) != 0)
    return detail_error("it is a video frame that depends on another; use a still image");
  data.color_slice = {load_u32(globals, at + 4), load_u32(globals, at + 8)};
  data.alpha_slice = {load_u32(globals, at + 12), load_u32(globals, at + 16)};

  const Bytes streams = globals.subspan(kHeaderBytes + kImageBytes * images);
  BitReader endpoint_bits(streams.first(lengths[0]));
  data.endpoints = read_endpoints(endpoint_bits, endpoint_count);
  if (!endpoint_bits.ok()) return detail_error("its BasisLZ endpoints are corrupt");
  BitReader selector_bits(streams.subspan(lengths[0], lengths[1]));
  data.selectors = read_selectors(selector_bits, selector_count);
  if (!selector_bits.ok()) return detail_error("its BasisLZ selectors are corrupt");
  BitReader table_bits(streams.subspan(lengths[0] + lengths[1], lengths[2]));
  for (HuffmanTable* table :
       {&data.endpoint_prediction, &data.endpoint_delta, &data.selector_or_history, &data.selector_run}) {
    *table = HuffmanTable::read(table_bits);
  }
  data.history_size = table_bits.take(13);
  if (!table_bits.ok()) return detail_error("its BasisLZ Huffman tables are corrupt");
  return data;
}

std::array<std::array<uint8_t, 3>, 4> etc1s_colors(const Etc1sEndpoint& endpoint) {
  constexpr std::array<std::array<int, 2>, 8> kModifiers = {
      {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}}};
  const auto [small, large] = kModifiers[endpoint.intensity];
  const std::array<int, 4> modifiers = {-large, -small, small, large};
  std::array<std::array<uint8_t, 3>, 4> colors{};
  for (size_t c = 0; c < 3; ++c) {
    const int base = endpoint.color[c] << 3 | endpoint.color[c] >> 2;
    for (size_t i = 0; i < 4; ++i) colors[i][c] = static_cast<uint8_t>(std::clamp(base + modifiers[i], 0, 255));
  }
  return colors;
}

} // namespace kindling::image_detail
