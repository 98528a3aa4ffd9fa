// Bit reader and Huffman codes of BasisLZ streams.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/decoders.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kindling::image_detail {

// Reads bits in order, from the lowest bit of the first byte. Reads past the end return zeros and,
// like invalid codes, make ok() false; callers check it after a bounded number of reads.
class BitReader {
 public:
  explicit BitReader(Bytes bytes) : bytes_(bytes) {}

  // Returns the next 0 to 24 bits without consuming them.
  [[nodiscard]] uint32_t peek(int count) const;
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
  size_t at_ = 0; // position in bits
  bool failed_ = false;
};

// Canonical Huffman codes of up to 16 bits, as in Deflate (RFC 1951, 3.2.2).
class HuffmanTable {
 public:
  // Constructs a table without codes.
  HuffmanTable() = default;
  // Builds a table from code lengths of 0 to 16 bits by symbol; 0 marks an unused symbol. Returns
  // nothing if no set of codes has these lengths.
  [[nodiscard]] static std::optional<HuffmanTable> from_lengths(std::span<const uint8_t> lengths);
  // Reads a table (KTX 2.0, "Compressed Huffman Tables"). An invalid table fails the reader.
  [[nodiscard]] static HuffmanTable read(BitReader& bits);

  // Reads a symbol. An invalid code fails the reader and returns 0.
  [[nodiscard]] uint32_t decode(BitReader& bits) const;

 private:
  struct Entry {
    uint16_t symbol = 0;
    uint8_t bits = 0; // 0 for an invalid code
  };
  int max_bits_ = 0;
  std::vector<Entry> entries_; // indexed by the next `max_bits_` bits
};

} // namespace kindling::image_detail
