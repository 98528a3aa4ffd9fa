// Well-formed sequences of UTF-8.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/utf8.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace kindling::gltf {
namespace {

struct Sequence {
  size_t length = 0;              // 0: no sequence begins with this byte
  uint8_t min = 0x80, max = 0xbf; // of the second byte
};

Sequence sequence_of(uint8_t first) {
  if (first < 0x80) return {1};
  if (first < 0xc2) return {};
  if (first < 0xe0) return {2};
  if (first == 0xe0) return {3, 0xa0, 0xbf}; // no longer form of what two bytes express
  if (first == 0xed) return {3, 0x80, 0x9f}; // no surrogates
  if (first < 0xf0) return {3};
  if (first == 0xf0) return {4, 0x90, 0xbf};
  if (first < 0xf4) return {4};
  if (first == 0xf4) return {4, 0x80, 0x8f}; // up to U+10FFFF
  return {};
}

} // namespace

std::string replace_invalid_utf8(std::string_view text) {
  constexpr std::string_view kReplacement = "\xef\xbf\xbd";
  std::string out;
  out.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[at + i]); };
    const Sequence sequence = sequence_of(byte(0));
    size_t fits = 1; // bytes that can be the start of the sequence
    while (fits < sequence.length && at + fits < text.size()) {
      const bool second = fits == 1;
      if (byte(fits) < (second ? sequence.min : 0x80) || byte(fits) > (second ? sequence.max : 0xbf)) break;
      ++fits;
    }
    out += fits == sequence.length ? text.substr(at, fits) : kReplacement;
    at += fits;
  }
  return out;
}

} // namespace kindling::gltf
