// URIs of a glTF file: data: URIs are decoded, relative ones are resolved beside the file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/import/files/file_bytes.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace kindling::gltf {

// Errors of these functions lack the place; the caller adds it.

// Replaces %XX by the byte XX. A % without two hexadecimal digits is unchanged.
[[nodiscard]] std::string percent_decode(std::string_view text);

[[nodiscard]] bool is_data_uri(std::string_view uri); // compares the scheme without case

// Decodes a data: URI (RFC 2397), base64 with optional padding or percent-encoded.
[[nodiscard]] Result<OwnedBytes> decode_data_uri(std::string_view uri);

// Returns a path in or below `folder`. Refuses schemes, absolute paths and '..' segments, encoded
// or not, with either slash. If the decoded name does not exist but the raw one does, returns the
// raw one: some exporters do not encode.
[[nodiscard]] Result<std::filesystem::path> resolve_uri(const std::filesystem::path& folder, std::string_view uri);

} // namespace kindling::gltf
