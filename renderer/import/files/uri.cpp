// Percent and base64 decoding, and rejection of paths outside the scene's folder.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/uri.h"

#include "renderer/import/files/failure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <system_error>

namespace kindling::gltf {
namespace {

Error invalid(std::string message) { return {ErrorKind::scene_invalid, std::move(message)}; }

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) {
           return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
         });
}

constexpr std::array<uint8_t, 256> make_base64_table() {
  std::array<uint8_t, 256> table{};
  table.fill(255);
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < kAlphabet.size(); ++i) table[static_cast<uint8_t>(kAlphabet[i])] = static_cast<uint8_t>(i);
  return table;
}
constexpr std::array<uint8_t, 256> kBase64 = make_base64_table();

Result<OwnedBytes> decode_base64(std::string_view text) {
  for (int i = 0; i < 2 && !text.empty() && text.back() == '='; ++i) text.remove_suffix(1);
  if (text.size() % 4 == 1) return invalid("base64 data of invalid length (INVALID_URI)");
  OwnedBytes bytes(text.size() / 4 * 3 + (text.size() % 4 == 0 ? 0 : text.size() % 4 - 1));
  std::byte* out = bytes.data();
  uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const uint8_t six = kBase64[static_cast<uint8_t>(c)];
    if (six == 255) return invalid(fmt::format("{} is not a base64 character (INVALID_URI)", in_quotes({&c, 1})));
    bits = (bits << 6) | six;
    count += 6;
    if (count >= 8) {
      count -= 8;
      *out++ = static_cast<std::byte>((bits >> count) & 0xffU);
    }
  }
  return bytes;
}

bool has_scheme(std::string_view uri) {
  const size_t colon = uri.find(':');
  const size_t slash = uri.find_first_of("/\\?#");
  return colon != std::string_view::npos && (slash == std::string_view::npos || colon < slash);
}

bool has_parent_segment(std::string_view path) {
  while (true) {
    const size_t end = path.find_first_of("/\\");
    if (path.substr(0, end) == "..") return true;
    if (end == std::string_view::npos) return false;
    path.remove_prefix(end + 1);
  }
}

} // namespace

std::string percent_decode(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0) {
      out += static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2]));
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

bool is_data_uri(std::string_view uri) { return uri.size() >= 5 && equals_ignoring_case(uri.substr(0, 5), "data:"); }

Result<OwnedBytes> decode_data_uri(std::string_view uri) {
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos) {
    return invalid(fmt::format("{} has no comma before its data (INVALID_URI)", in_quotes(uri)));
  }
  const std::string_view media = uri.substr(5, comma - 5);
  const std::string_view payload = uri.substr(comma + 1);
  constexpr std::string_view kMark = ";base64";
  const bool base64 =
      media.size() >= kMark.size() && equals_ignoring_case(media.substr(media.size() - kMark.size()), kMark);
  if (base64 && payload.find('%') == std::string_view::npos) return decode_base64(payload);
  const std::string decoded = percent_decode(payload);
  if (base64) return decode_base64(decoded);
  OwnedBytes bytes(decoded.size());
  if (!decoded.empty()) std::memcpy(bytes.data(), decoded.data(), decoded.size());
  return bytes;
}

Result<std::filesystem::path> resolve_uri(const std::filesystem::path& folder, std::string_view uri) {
  const std::string decoded = percent_decode(uri);
  if (decoded.empty()) return invalid("empty URI, expected the name of a file beside the scene (INVALID_URI)");
  if (decoded.find('\0') != std::string::npos) return invalid("a URI with a zero byte (INVALID_URI)");
  if (has_scheme(uri) || decoded.front() == '/' || decoded.front() == '\\') {
    return invalid(fmt::format("absolute URI {}, expected a file beside the scene or a data: URI "
                               "(NON_RELATIVE_URI)",
                               in_quotes(uri)));
  }
  if (has_parent_segment(decoded)) {
    return invalid(fmt::format("{} leaves the folder of the scene by '..'", in_quotes(uri)));
  }
  std::filesystem::path path = folder / decoded;
  std::error_code code;
  if (decoded != uri && !std::filesystem::exists(path, code) && std::filesystem::exists(folder / uri, code)) {
    return folder / uri;
  }
  return path;
}

} // namespace kindling::gltf
