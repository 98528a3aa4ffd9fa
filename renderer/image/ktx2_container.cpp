// Parser of KTX 2.0 containers: header, level index, data format descriptor and key/value data.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/ktx2_container.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::image_detail {

namespace {

constexpr size_t kHeaderBytes = 80; // identifier, header and index (section 3)
constexpr size_t kLevelEntryBytes = 24;

uint64_t load_u64(Bytes bytes, size_t offset) {
  return load_u32(bytes, offset) | static_cast<uint64_t>(load_u32(bytes, offset + 4)) << 32;
}

std::optional<Bytes> part(Bytes bytes, uint64_t offset, uint64_t length) {
  if (offset > bytes.size() || length > bytes.size() - offset) return std::nullopt;
  return bytes.subspan(offset, length);
}

Error outside(std::string_view name, uint64_t offset, uint64_t length, Bytes bytes) {
  return detail_error(
      fmt::format("{} ({} bytes at {}) lies outside the file of {} bytes", name, length, offset, bytes.size()));
}

// Returns the channels of a texture by the channel ids of its samples (khr_df.h:
// KHR_DF_CHANNEL_ETC1S_*, _UASTC_*); nothing for unsupported ids.
std::optional<Ktx2Channels> channels_of(Ktx2Payload payload, const std::vector<uint32_t>& ids) {
  if (payload == Ktx2Payload::uastc) {
    if (ids.size() != 1) return std::nullopt;
    if (ids[0] == 0 || ids[0] == 4 || ids[0] == 6) return Ktx2Channels::rgb; // RGB, RRR, RG
    if (ids[0] == 3) return Ktx2Channels::rgba;
    if (ids[0] == 5) return Ktx2Channels::green_from_alpha; // RRRG
    return std::nullopt;
  }
  if (ids.size() == 1 && (ids[0] == 0 || ids[0] == 3)) return Ktx2Channels::rgb; // RGB, RRR
  if (ids.size() != 2) return std::nullopt;
  if (ids[0] == 0 && ids[1] == 15) return Ktx2Channels::rgba;            // RGB, AAA
  if (ids[0] == 3 && ids[1] == 4) return Ktx2Channels::green_from_alpha; // RRR, GGG
  return std::nullopt;
}

// Reads the basic data format descriptor (Khronos Data Format Specification 1.3, section 5), which
// is the first one.
std::optional<Error> read_descriptor(Bytes dfd, Ktx2Texture& texture) {
  constexpr size_t kBasicBytes = 24, kSampleBytes = 16;
  const Bytes basic = dfd.subspan(std::min<size_t>(dfd.size(), 4)); // after the total size
  if (basic.size() < kBasicBytes || load_u32(basic, 0) != 0)
    return detail_error("it has no basic data format descriptor");
  const size_t block_bytes = load_u16(basic, 6);
  if (block_bytes < kBasicBytes || block_bytes > basic.size()) {
    return detail_error(
        fmt::format("its data format descriptor declares {} bytes but has {}", block_bytes, basic.size()));
  }
  if ((static_cast<unsigned>(basic[11]) & 1U) != 0) {
    return detail_error("its alpha is premultiplied; use straight alpha");
  }
  if (texture.payload == Ktx2Payload::vulkan) return std::nullopt; // the rest repeats vkFormat
  const auto model = static_cast<unsigned>(basic[8]);
  if (model != 163 && model != 166) {
    return detail_error(fmt::format("its color model is {}; accepted are 163 (ETC1S) and 166 (UASTC LDR)", model));
  }
  texture.payload = model == 163 ? Ktx2Payload::etc1s : Ktx2Payload::uastc;
  if (load_u32(basic, 12) != 0x00000303) return detail_error("its blocks are not 4 x 4 pixels");
  std::vector<uint32_t> ids;
  for (size_t at = kBasicBytes; at + kSampleBytes <= block_bytes; at += kSampleBytes) {
    ids.push_back(static_cast<uint32_t>(basic[at + 3]) & 15U); // the upper bits are qualifiers
  }
  const auto channels = channels_of(texture.payload, ids);
  if (!channels) {
    return detail_error(
        fmt::format("its {} samples are not those of an RGB, RGBA, red or red-green texture", ids.size()));
  }
  texture.channels = *channels;
  return std::nullopt;
}

// Reads the two entries that change pixels. KHR_texture_basisu prescribes the values of both; other
// payloads may have any swizzle.
std::optional<Error> read_key_values(Bytes data, Ktx2Texture& texture) {
  while (data.size() >= 4) {
    const size_t length = load_u32(data, 0);
    const auto entry = part(data, 4, length);
    if (!entry) return detail_error("its key/value data end early");
    const std::string_view text(reinterpret_cast<const char*>(entry->data()), entry->size());
    const size_t end = std::min(text.find('\0'), text.size());
    const std::string_view key = text.substr(0, end);
    std::string_view value = text.substr(std::min(end + 1, text.size()));
    while (value.ends_with('\0')) value.remove_suffix(1);
    if (key == "KTXswizzle" && texture.payload == Ktx2Payload::vulkan && value.size() == 4 &&
        value.find_first_not_of("rgba01") == std::string_view::npos) {
      std::copy(value.begin(), value.end(), texture.swizzle.begin());
      value = "rgba"; // accepted
    }
    const std::string_view accepted = key == "KTXswizzle" ? "rgba" : key == "KTXorientation" ? "rd" : value;
    if (value != accepted) {
      std::string shown(value.substr(0, 8));
      std::replace_if(
          shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
      return detail_error(fmt::format("its {} is '{}'; accepted is '{}'", key, shown, accepted));
    }
    data = data.subspan(std::min(data.size(), (4 + length + 3) / 4 * 4));
  }
  return std::nullopt;
}

std::optional<Error> read_shape(Bytes bytes, Ktx2Texture& texture) {
  if (const uint32_t vk_format = load_u32(bytes, 12); vk_format != 0) {
    texture.payload = Ktx2Payload::vulkan;
    texture.format = find_ktx2_format(vk_format);
    if (!texture.format) {
      return detail_error(fmt::format("its vkFormat is {}; accepted are {}", vk_format, ktx2_format_list()));
    }
  }
  const uint32_t depth = load_u32(bytes, 28), layers = load_u32(bytes, 32), faces = load_u32(bytes, 36);
  if (depth != 0 || layers != 0 || faces != 1) {
    const std::string_view shape = depth != 0 ? "a volume" : layers != 0 ? "an array" : "a cube map";
    return detail_error(fmt::format(
        "it is {} (depth {}, {} layers, {} faces); accepted is a single 2-D image (depth 0, 0 layers, 1 face)", shape,
        depth, layers, faces));
  }
  return std::nullopt;
}

std::optional<Error> check_level(const Ktx2Texture& texture) {
  if (texture.payload == Ktx2Payload::etc1s) {
    if (texture.supercompression == Ktx2Supercompression::basis_lz) return std::nullopt;
    return detail_error(fmt::format("its ETC1S data have supercompression scheme {}; accepted is 1 (BasisLZ)",
                                    static_cast<uint32_t>(texture.supercompression)));
  }
  if (texture.supercompression == Ktx2Supercompression::basis_lz) {
    return detail_error(
        fmt::format("its {} data have supercompression scheme 1; accepted are 0 (none), 2 (Zstandard) and 3 (zlib)",
                    texture.format ? texture.format->name : "UASTC"));
  }
  const uint64_t needed = uint64_t{texture.block_bytes()} * texture.blocks_x() * texture.blocks_y();
  const bool stored = texture.supercompression == Ktx2Supercompression::none;
  const uint64_t declared = stored ? texture.level.size() : texture.inflated_bytes;
  if (declared == needed) return std::nullopt;
  return detail_error(fmt::format("its level 0 has {} bytes where {} x {} pixels need {}", declared, texture.width,
                                  texture.height, needed));
}

} // namespace

uint32_t load_u16(Bytes bytes, size_t offset) {
  assert(offset + 2 <= bytes.size());
  return static_cast<uint32_t>(bytes[offset]) | static_cast<uint32_t>(bytes[offset + 1]) << 8;
}

uint32_t load_u32(Bytes bytes, size_t offset) { return load_u16(bytes, offset) | load_u16(bytes, offset + 2) << 16; }

Result<Ktx2Texture> parse_ktx2(Bytes bytes) {
  if (bytes.size() < kHeaderBytes) return detail_error("the file ends in its header");
  Ktx2Texture texture;
  if (const auto error = read_shape(bytes, texture)) return *error;
  texture.width = load_u32(bytes, 20);
  texture.height = load_u32(bytes, 24);
  texture.levels = std::max(load_u32(bytes, 40), 1U);
  if (texture.levels > static_cast<uint32_t>(std::bit_width(std::max(texture.width, texture.height)))) {
    return detail_error(
        fmt::format("{} levels are more than {} x {} pixels have", texture.levels, texture.width, texture.height));
  }
  const uint32_t scheme = load_u32(bytes, 44);
  if (scheme > 3) {
    return detail_error(
        fmt::format("its supercompression scheme is {}; accepted are 0 (none), 1 (BasisLZ), 2 (Zstandard) "
                    "and 3 (zlib)",
                    scheme));
  }
  texture.supercompression = static_cast<Ktx2Supercompression>(scheme);

  const uint32_t dfd_offset = load_u32(bytes, 48), dfd_length = load_u32(bytes, 52);
  const auto dfd = part(bytes, dfd_offset, dfd_length);
  if (!dfd) return outside("its data format descriptor", dfd_offset, dfd_length, bytes);
  if (const auto error = read_descriptor(*dfd, texture)) return *error;

  const uint32_t kvd_offset = load_u32(bytes, 56), kvd_length = load_u32(bytes, 60);
  const auto kvd = part(bytes, kvd_offset, kvd_length);
  if (!kvd) return outside("its key/value data", kvd_offset, kvd_length, bytes);
  if (const auto error = read_key_values(*kvd, texture)) return *error;

  const uint64_t globals_offset = load_u64(bytes, 64), globals_length = load_u64(bytes, 72);
  const auto globals = part(bytes, globals_offset, globals_length);
  if (!globals) return outside("its supercompression data", globals_offset, globals_length, bytes);
  texture.supercompression_globals = *globals;

  if (!part(bytes, kHeaderBytes, uint64_t{kLevelEntryBytes} * texture.levels)) {
    return detail_error("the file ends in its level index");
  }
  const uint64_t level_offset = load_u64(bytes, kHeaderBytes), level_length = load_u64(bytes, kHeaderBytes + 8);
  const auto level = part(bytes, level_offset, level_length);
  if (!level) return outside("its level 0", level_offset, level_length, bytes);
  texture.level = *level;
  texture.inflated_bytes = load_u64(bytes, kHeaderBytes + 16);
  if (const auto error = check_level(texture)) return *error;
  return texture;
}

} // namespace kindling::image_detail
