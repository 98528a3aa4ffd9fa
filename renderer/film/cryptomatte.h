// Names, ids and channels of Cryptomatte (Psyop, "Cryptomatte Specification", version 1.2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/aov.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

inline constexpr int kDefaultMatteLevels = 6; // ids of a pixel, as in Cycles
inline constexpr int kMaxMatteLevels = 32;

// Returns MurmurHash3_x86_32 of the bytes, with seed 0.
[[nodiscard]] uint32_t murmur_hash3(std::string_view bytes);

// Returns the id of a name in UTF-8: its hash, changed in one bit if it would be no normal number
// as the bits of a float. Never 0.
[[nodiscard]] uint32_t matte_id(std::string_view name);

// Returns the number as 8 lower-case hexadecimal digits, as manifests have it.
[[nodiscard]] std::string matte_hex(uint32_t number);

// Returns the prefix of the matte's metadata: "cryptomatte/" and 7 digits of the hash of the
// layer's name, and "/".
[[nodiscard]] std::string matte_metadata_prefix(Matte matte);

// Returns the names of 2 * `levels` channels, `levels` rounded up to an even number:
// CryptoObject00.r (id), .g (coverage), .b (id), .a (coverage), CryptoObject01.r ...
[[nodiscard]] std::vector<std::string> matte_channel_names(Matte matte, int levels);

} // namespace kindling
