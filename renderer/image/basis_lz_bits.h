// Bits and Huffman codes of BasisLZ streams.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/decoders.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kindling::image_detail {

// Bits from the lowest of the first byte on. Reads past the end give zeros and, as codes that do not exist, leave the
// reader not ok: to be asked once in a while, never more than a bounded number of reads later.
class BitReader {
 public:
  explicit BitReader(Bytes bytes) : bytes_(bytes) {}

  [[nodiscard]] uint32_t peek(int count) const; // 0 to 24 bits
  void skip(int count) { at_ += static_cast<size_t>(count); }
  uint32_t take(int count) {
    const uint32_t value = peek(count);
    skip(count);
    return value;
  }
  void fail() { failed_ = true; }
  [[nodiscard]] bool ok() const { return !failed_ && at_ <= bytes_.size() * 8; }

 private:
  Bytes bytes_;
  size_t at_ = 0; // in bits
  bool failed_ = false;
};

// Canonical Huffman codes of up to 16 bits, as Deflate has them (RFC 1951, 3.2.2).
class HuffmanTable {
 public:
  // No code at all.
  HuffmanTable() = default;
  // lengths[symbol]: 0 to 16 bits, 0 for a symbol that is not used. Empty optional if no set of codes has these lengths.
  [[nodiscard]] static std::optional<HuffmanTable> from_lengths(std::span<const uint8_t> lengths);
  // KTX 2.0, "Compressed Huffman Tables". A table that is not valid fails the reader.
  [[nodiscard]] static HuffmanTable read(BitReader& bits);

  // The next symbol; a code that does not exist fails the reader and gives 0.
  [[nodiscard]] uint32_t decode(BitReader& bits) const;

 private:
  struct Entry {
    uint16_t symbol = 0;
    uint8_t bits = 0; // 0: no such code
  };
  int longest_ = 0;
  std::vector<Entry> entries_; // by the next `longest_` bits
};

} // namespace kindling::image_detail
