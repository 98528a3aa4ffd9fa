// Decoder of ETC1S slices: endpoint prediction, selector history and run lengths.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/etc1s_slices.h"

#include <optional>
#include <utility>

namespace kindling::image_detail {

namespace {

// Reads a number in chunks of `bits`, each followed by a bit that is set if another chunk follows.
uint32_t read_chunks(BitReader& reader, int bits) {
  uint32_t value = 0;
  for (int shift = 0; shift < 32; shift += bits) {
    const uint32_t chunk = reader.take(bits + 1);
    value |= (chunk & ((1U << bits) - 1U)) << shift;
    if (chunk >> bits == 0) return value;
  }
  reader.fail();
  return 0;
}

// Predictions of endpoints from neighboring blocks: 2 bits per block, in symbols for 2 x 2 blocks,
// with runs.
class EndpointPredictions {
 public:
  EndpointPredictions(const Etc1sData& data, uint32_t blocks_x) : data_(data), lower_((blocks_x + 1) / 2) {}

  uint32_t next(BitReader& bits, uint32_t x, uint32_t y) {
    if (x % 2 == 0) pending_ = y % 2 == 0 ? upper(bits, x) : lower_[x / 2];
    const uint32_t prediction = pending_ & 3U;
    pending_ >>= 2;
    return prediction;
  }

 private:
  uint32_t upper(BitReader& bits, uint32_t x) {
    constexpr uint32_t kRepeat = 256, kMinRun = 3;
    if (run_ > 0) {
      --run_;
    } else {
      const uint32_t symbol = data_.endpoint_prediction.decode(bits);
      if (symbol > kRepeat) bits.fail();
      if (symbol == kRepeat) {
        run_ = uint64_t{read_chunks(bits, 4)} + kMinRun - 1;
      } else {
        symbol_ = symbol;
      }
    }
    lower_[x / 2] = static_cast<uint8_t>(symbol_ >> 4 & 15U);
    return symbol_;
  }

  const Etc1sData& data_;
  std::vector<uint8_t> lower_; // the upper half of each symbol, for the next row of blocks
  uint32_t symbol_ = 0, pending_ = 0;
  uint64_t run_ = 0;
};

// Selectors of blocks: new ones, or entries of an approximate move-to-front list of recent ones,
// with runs of its first entry.
class SelectorIndices {
 public:
  explicit SelectorIndices(const Etc1sData& data)
      : data_(data), history_(data.history_size), oldest_(data.history_size / 2) {}

  // Returns the next index into the codebook; nothing if it is out of range.
  std::optional<uint32_t> next(BitReader& bits) {
    const auto count = static_cast<uint32_t>(data_.selectors.size());
    uint32_t symbol = count;
    if (run_ > 0) {
      --run_;
    } else {
      symbol = data_.selector_or_history.decode(bits);
      if (symbol == count + history_.size()) {
        constexpr uint32_t kMinRun = 3, kLongRun = 63;
        const uint32_t run = data_.selector_run.decode(bits);
        run_ = uint64_t{run == kLongRun ? read_chunks(bits, 7) : run} + kMinRun - 1;
        symbol = count;
      }
    }
    if (symbol < count) {
      add(symbol);
      return symbol;
    }
    const size_t place = symbol - count;
    if (place >= history_.size()) return std::nullopt;
    const uint32_t index = history_[place];
    std::swap(history_[place], history_[place / 2]);
    return index < count ? std::optional(index) : std::nullopt;
  }

 private:
  void add(uint32_t index) {
    if (history_.empty()) return;
    history_[oldest_++] = index;
    if (oldest_ == history_.size()) oldest_ = history_.size() / 2;
  }

  const Etc1sData& data_;
  std::vector<uint32_t> history_;
  size_t oldest_; // position that is overwritten next
  uint64_t run_ = 0;
};

} // namespace

bool decode_etc1s_slice(Bytes slice, const Etc1sData& data, uint32_t blocks_x, uint32_t blocks_y,
                        const Etc1sBlockSink& sink) {
  BitReader bits(slice);
  EndpointPredictions predictions(data, blocks_x);
  SelectorIndices selectors(data);
  std::vector<uint32_t> above(blocks_x), row(blocks_x); // endpoint indices
  uint32_t endpoint = 0;
  for (uint32_t y = 0; y < blocks_y; ++y) {
    for (uint32_t x = 0; x < blocks_x; ++x) {
      enum : uint32_t { from_left, from_above, from_above_left, from_delta };
      switch (predictions.next(bits, x, y)) {
      case from_left:
        if (x == 0) return false;
        break;
      case from_above:
        if (y == 0) return false;
        endpoint = above[x];
        break;
      case from_above_left:
        if (x == 0 || y == 0) return false;
        endpoint = above[x - 1];
        break;
      default:
        endpoint += data.endpoint_delta.decode(bits);
        if (endpoint >= data.endpoints.size()) endpoint -= static_cast<uint32_t>(data.endpoints.size());
        if (endpoint >= data.endpoints.size()) return false;
      }
      row[x] = endpoint;
      const auto selector = selectors.next(bits);
      if (!selector || !bits.ok()) return false;
      sink(x, y, data.endpoints[endpoint], data.selectors[*selector]);
    }
    std::swap(above, row);
  }
  return true;
}

} // namespace kindling::image_detail
