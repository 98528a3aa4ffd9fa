// URIs of a glTF file: data: URIs are decoded, relative references become paths beside the file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/import/files/file_bytes.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace kindling::gltf {

// Errors of this file lack the place; the caller knows it.

// %XX becomes the byte XX; a % that starts no such triple stays as it is.
[[nodiscard]] std::string percent_decode(std::string_view text);

[[nodiscard]] bool is_data_uri(std::string_view uri); // the scheme in any case

// RFC 2397, base64 (padding optional) or percent-encoded.
[[nodiscard]] Result<OwnedBytes> decode_data_uri(std::string_view uri);

// A path in or below `folder`: refused are schemes, absolute paths and '..' segments, encoded or not, with either
// slash. If the decoded name does not exist but the raw one does, it is the raw one (some writers do not encode).
[[nodiscard]] Result<std::filesystem::path> resolve_uri(const std::filesystem::path& folder, std::string_view uri);

} // namespace kindling::gltf
