// MurmurHash3 and the texts of Cryptomatte.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/cryptomatte.h"

#include <fmt/format.h>

#include <bit>

namespace kindling {

// Appleby 2011, MurmurHash3_x86_32.
uint32_t murmur_hash3(std::string_view bytes) {
  constexpr uint32_t kFirst = 0xcc9e2d51U, kSecond = 0x1b873593U;
  const auto byte = [&](size_t i) { return uint32_t{static_cast<unsigned char>(bytes[i])}; };
  const auto mixed = [](uint32_t k) { return std::rotl(k * kFirst, 15) * kSecond; };
  uint32_t hash = 0;
  const size_t whole = bytes.size() / 4 * 4;
  for (size_t i = 0; i < whole; i += 4) {
    hash ^= mixed(byte(i) | byte(i + 1) << 8U | byte(i + 2) << 16U | byte(i + 3) << 24U);
    hash = std::rotl(hash, 13) * 5 + 0xe6546b64U;
  }
  uint32_t rest = 0;
  for (size_t i = bytes.size(); i > whole; --i) rest = rest << 8U | byte(i - 1);
  if (whole < bytes.size()) hash ^= mixed(rest);
  hash ^= static_cast<uint32_t>(bytes.size());
  hash = (hash ^ hash >> 16U) * 0x85ebca6bU;
  hash = (hash ^ hash >> 13U) * 0xc2b2ae35U;
  return hash ^ hash >> 16U;
}

uint32_t matte_id(std::string_view name) {
  const uint32_t hash = murmur_hash3(name);
  // An exponent of 0 means zero or a denormal number, 255 infinity or NaN: none survives all that
  // is done with pixels.
  const uint32_t exponent = hash >> 23U & 255U;
  return exponent == 0 || exponent == 255 ? hash ^ 1U << 23U : hash;
}

std::string matte_hex(uint32_t number) { return fmt::format("{:08x}", number); }

std::string matte_metadata_prefix(Matte matte) {
  const std::string_view layer = kMattes[static_cast<size_t>(matte)].layer;
  return "cryptomatte/" + matte_hex(murmur_hash3(layer)).substr(0, 7) + "/";
}

std::vector<std::string> matte_channel_names(Matte matte, int levels) {
  std::vector<std::string> names;
  for (int layer = 0; 2 * layer < levels; ++layer)
    for (const char channel : {'r', 'g', 'b', 'a'})
      names.push_back(fmt::format("{}{:02}.{}", kMattes[static_cast<size_t>(matte)].layer, layer, channel));
  return names;
}

} // namespace kindling
