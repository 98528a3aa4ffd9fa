// Decoders of KHR_meshopt_compression, appendices A (mode 0, version 1) and B (filter 4).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/compression/meshopt_attributes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace kindling::gltf {
namespace {

constexpr uint8_t kHeader = 0xa1;
constexpr size_t kGroup = 16;             // elements whose deltas are packed with one number of bits
constexpr size_t kMaxBlockElements = 256; // elements of a block
constexpr size_t kBlockBytes = 8192;
constexpr size_t kMinTail = 24;

// The encoding of the deltas of one byte position within a block.
enum class Control : uint8_t { low_bits, high_bits, zero, literal };

enum class Channel : uint8_t { byte_delta, short_delta, word_xor };

// Reads bytes in order; take() returns false if too few are left.
class BlockReader {
 public:
  explicit BlockReader(Bytes bytes) : rest_(bytes) {}
  [[nodiscard]] bool take(size_t count, const uint8_t*& out) {
    if (count > rest_.size()) return false;
    out = reinterpret_cast<const uint8_t*>(rest_.data());
    rest_ = rest_.subspan(count);
    return true;
  }
  [[nodiscard]] size_t left() const { return rest_.size(); }

 private:
  Bytes rest_;
};

// Returns entry `index` of packed two-bit values, the lowest bits first.
unsigned two_bits(const uint8_t* bytes, size_t index) { return (bytes[index / 4] >> (index % 4 * 2)) & 3u; }

// Decodes deltas of 1, 2 or 4 bits. A value with all bits set stands for a byte that follows the
// packed ones.
bool decode_sentinels(BlockReader& reader, unsigned bits, uint8_t* out) {
  const uint8_t* packed = nullptr;
  if (!reader.take(kGroup * bits / 8, packed)) return false;
  const size_t per_byte = 8 / bits;
  const unsigned sentinel = (1u << bits) - 1;
  for (size_t i = 0; i < kGroup; ++i) {
    const size_t place = i % per_byte;
    const size_t shift =
        bits == 1 ? place : (per_byte - 1 - place) * bits; // single bits start at the lowest, others at the highest
    unsigned value = (packed[i / per_byte] >> shift) & sentinel;
    if (value == sentinel) {
      const uint8_t* whole = nullptr;
      if (!reader.take(1, whole)) return false;
      value = *whole;
    }
    out[i] = static_cast<uint8_t>(value);
  }
  return true;
}

// Decodes the deltas of one byte position in a block; `out` has room for whole groups.
bool decode_deltas(BlockReader& reader, Control control, size_t elements, uint8_t* out) {
  const size_t groups = (elements + kGroup - 1) / kGroup;
  const uint8_t* bytes = nullptr;
  if (control == Control::zero) {
    std::memset(out, 0, groups * kGroup);
    return true;
  }
  if (control == Control::literal) {
    if (!reader.take(elements, bytes)) return false;
    std::memcpy(out, bytes, elements);
    return true;
  }
  constexpr std::array<unsigned, 5> kBits = {0, 1, 2, 4, 8};
  const size_t first = control == Control::low_bits ? 0 : 1;
  const uint8_t* header = nullptr;
  if (!reader.take((groups + 3) / 4, header)) return false;
  for (size_t g = 0; g < groups; ++g, out += kGroup) {
    const unsigned bits = kBits[first + two_bits(header, g)];
    if (bits == 0) {
      std::memset(out, 0, kGroup);
    } else if (bits == 8) {
      if (!reader.take(kGroup, bytes)) return false;
      std::memcpy(out, bytes, kGroup);
    } else if (!decode_sentinels(reader, bits, out)) {
      return false;
    }
  }
  return true;
}

template <typename T>
T unzigzag(T value) {
  return static_cast<T>((value & 1u) != 0 ? ~(value >> 1) : value >> 1);
}

// Returns the next value of a channel: four bytes, little-endian.
uint32_t next_value(uint32_t previous, uint32_t delta, Channel channel, int rotation) {
  uint32_t value = 0;
  switch (channel) {
  case Channel::byte_delta:
    for (unsigned shift = 0; shift < 32; shift += 8) {
      const auto byte = static_cast<uint8_t>((previous >> shift) + unzigzag(static_cast<uint8_t>(delta >> shift)));
      value |= static_cast<uint32_t>(byte) << shift;
    }
    return value;
  case Channel::short_delta:
    for (unsigned shift = 0; shift < 32; shift += 16) {
      const auto half = static_cast<uint16_t>((previous >> shift) + unzigzag(static_cast<uint16_t>(delta >> shift)));
      value |= static_cast<uint32_t>(half) << shift;
    }
    return value;
  case Channel::word_xor: return previous ^ std::rotr(delta, rotation);
  }
  return value;
}

uint32_t load_little_endian(const std::byte* from) {
  uint32_t value = 0;
  for (unsigned b = 0; b < 4; ++b) value |= std::to_integer<uint32_t>(from[b]) << (8 * b);
  return value;
}
void store(uint32_t value, std::byte* to) {
  for (unsigned b = 0; b < 4; ++b) to[b] = static_cast<std::byte>(value >> (8 * b));
}

template <typename T>
void decode_colors(std::span<std::byte> elements) {
  using Signed = std::make_signed_t<T>;
  constexpr auto kMax = static_cast<float>(static_cast<T>(~T{0}));
  for (size_t i = 0; i + 4 * sizeof(T) <= elements.size(); i += 4 * sizeof(T)) {
    T in[4];
    std::memcpy(in, &elements[i], sizeof(in));
    const int y = in[0];
    const int co = static_cast<Signed>(in[1]);
    const int cg = static_cast<Signed>(in[2]);
    const unsigned one = (1u << std::bit_width(static_cast<unsigned>(in[3]))) - 1; // 1.0 at the bit depth of this color
    const unsigned alpha = in[3] & (one >> 1);
    const int values[4] = {y + co - cg, y + cg, y - co - cg, static_cast<int>(alpha << 1 | (alpha & 1u))};
    const float scale = one == 0 ? 0.0f : kMax / static_cast<float>(one);
    T rgba[4];
    for (size_t c = 0; c < 4; ++c)
      rgba[c] = static_cast<T>(std::clamp(std::floor(static_cast<float>(values[c]) * scale + 0.5f), 0.0f, kMax));
    std::memcpy(&elements[i], rgba, sizeof(rgba));
  }
}

} // namespace

bool is_meshopt_attributes_v1(Bytes stream) {
  return !stream.empty() && std::to_integer<uint8_t>(stream.front()) == kHeader;
}

bool decode_meshopt_attributes_v1(Bytes stream, size_t count, size_t stride, std::span<std::byte> out) {
  const size_t channels = stride / 4;
  const size_t tail = std::max(stride + channels, kMinTail);
  if (!is_meshopt_attributes_v1(stream) || stream.size() < 1 + tail) return false;
  const Bytes modes = stream.last(channels);
  const Bytes baseline = stream.last(stride + channels).first(stride);
  for (const std::byte mode : modes) {
    const auto byte = std::to_integer<unsigned>(mode);
    if ((byte & 15u) > 2 || ((byte & 15u) < 2 && byte >> 4 != 0)) return false;
  }

  std::vector<uint32_t> previous(channels);
  for (size_t c = 0; c < channels; ++c) previous[c] = load_little_endian(&baseline[4 * c]);
  BlockReader reader(stream.subspan(1, stream.size() - 1 - tail));
  const size_t block = std::min((kBlockBytes / stride) & ~(kGroup - 1), kMaxBlockElements);
  std::array<std::array<uint8_t, kMaxBlockElements>, 4> deltas{};
  for (size_t first = 0; first < count; first += block) {
    const size_t elements = std::min(block, count - first);
    const uint8_t* controls = nullptr;
    if (!reader.take(channels, controls)) return false;
    for (size_t c = 0; c < channels; ++c) {
      for (size_t b = 0; b < 4; ++b) {
        const auto control = static_cast<Control>(two_bits(controls, 4 * c + b));
        if (!decode_deltas(reader, control, elements, deltas[b].data())) return false;
      }
      const auto mode = std::to_integer<unsigned>(modes[c]);
      const auto channel = static_cast<Channel>(mode & 15u);
      const auto rotation = static_cast<int>(mode >> 4);
      std::byte* to = &out[first * stride + 4 * c];
      for (size_t e = 0; e < elements; ++e, to += stride) {
        const uint32_t delta = static_cast<uint32_t>(deltas[0][e]) | static_cast<uint32_t>(deltas[1][e]) << 8 |
                               static_cast<uint32_t>(deltas[2][e]) << 16 | static_cast<uint32_t>(deltas[3][e]) << 24;
        previous[c] = next_value(previous[c], delta, channel, rotation);
        store(previous[c], to);
      }
    }
  }
  return reader.left() == 0;
}

void decode_meshopt_color(std::span<std::byte> elements, size_t stride) {
  if (stride == 4) decode_colors<uint8_t>(elements);
  if (stride == 8) decode_colors<uint16_t>(elements);
}

} // namespace kindling::gltf
