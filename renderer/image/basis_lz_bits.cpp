// Bit reader and Huffman tables of BasisLZ; codes are decoded by one table look-up.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/basis_lz_bits.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling::image_detail {

namespace {

constexpr int kMaxCodeBits = 16;

// Returns the code lengths of a table, which are run-length and Huffman coded; empty if they are
// invalid.
std::vector<uint8_t> read_lengths(BitReader& bits, const HuffmanTable& length_codes, size_t count) {
  std::vector<uint8_t> lengths;
  lengths.reserve(count);
  while (lengths.size() < count && bits.ok()) {
    const uint32_t symbol = length_codes.decode(bits);
    if (symbol <= kMaxCodeBits) {
      lengths.push_back(static_cast<uint8_t>(symbol));
      continue;
    }
    const bool zeros = symbol == 17 || symbol == 18;
    const size_t run = symbol == 17   ? bits.take(3) + 3
                       : symbol == 18 ? bits.take(7) + 11
                       : symbol == 19 ? bits.take(2) + 3
                                      : bits.take(7) + 7;
    if ((!zeros && (lengths.empty() || lengths.back() == 0)) || run > count - lengths.size()) return {};
    lengths.insert(lengths.end(), run, zeros ? uint8_t{0} : uint8_t{lengths.back()});
  }
  return bits.ok() ? lengths : std::vector<uint8_t>{};
}

} // namespace

uint32_t BitReader::peek(int count) const {
  assert(count >= 0 && count <= 24);
  uint32_t window = 0;
  const size_t first = at_ / 8;
  for (size_t i = 0; i < 4 && first + i < bytes_.size(); ++i) {
    window |= static_cast<uint32_t>(bytes_[first + i]) << (8 * i);
  }
  return window >> (at_ % 8) & ((1U << count) - 1U);
}

std::optional<HuffmanTable> HuffmanTable::from_lengths(std::span<const uint8_t> lengths) {
  std::array<uint32_t, kMaxCodeBits + 1> of_length{};
  for (const uint8_t length : lengths) {
    if (length > kMaxCodeBits) return std::nullopt;
    ++of_length[length];
  }
  HuffmanTable table;
  std::array<uint32_t, kMaxCodeBits + 1> next{}; // next code of each length
  uint32_t code = 0;
  for (size_t length = 1; length <= kMaxCodeBits; ++length) {
    code = (code + (length == 1 ? 0 : of_length[length - 1])) << 1;
    if (code + of_length[length] > 1U << length) return std::nullopt; // too many codes of this length
    next[length] = code;
    if (of_length[length] != 0) table.max_bits_ = static_cast<int>(length);
  }
  if (table.max_bits_ == 0) return table;

  table.entries_.resize(size_t{1} << table.max_bits_);
  for (size_t symbol = 0; symbol < lengths.size(); ++symbol) {
    const uint32_t length = lengths[symbol];
    if (length == 0) continue;
    uint32_t reversed = 0; // streams store the highest bit of a code first
    for (uint32_t i = 0; i < length; ++i) reversed |= (next[length] >> i & 1U) << (length - 1 - i);
    ++next[length];
    for (size_t at = reversed; at < table.entries_.size(); at += size_t{1} << length) {
      table.entries_[at] = {static_cast<uint16_t>(symbol), static_cast<uint8_t>(length)};
    }
  }
  return table;
}

HuffmanTable HuffmanTable::read(BitReader& bits) {
  const size_t symbols = bits.take(14);
  if (symbols == 0) return {};
  constexpr std::array<uint8_t, 21> kOrder = {17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16};
  const size_t stored = bits.take(5);
  std::array<uint8_t, 21> code_lengths{};
  if (stored < 1 || stored > kOrder.size()) {
    bits.fail();
    return {};
  }
  for (size_t i = 0; i < stored; ++i) code_lengths[kOrder[i]] = static_cast<uint8_t>(bits.take(3));
  const auto length_codes = from_lengths(code_lengths);
  const std::vector<uint8_t> lengths =
      length_codes && bits.ok() ? read_lengths(bits, *length_codes, symbols) : std::vector<uint8_t>{};
  auto table = from_lengths(lengths);
  if (lengths.empty() || !table) {
    bits.fail();
    return {};
  }
  return *std::move(table);
}

uint32_t HuffmanTable::decode(BitReader& bits) const {
  if (entries_.empty()) {
    bits.fail();
    return 0;
  }
  const Entry entry = entries_[bits.peek(max_bits_)];
  if (entry.bits == 0) bits.fail();
  bits.skip(entry.bits);
  return entry.symbol;
}

} // namespace kindling::image_detail
