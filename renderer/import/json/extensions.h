// The table of glTF extensions, its check against a file, and access to extension objects.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/json/extension_support.h"

#include <nlohmann/json_fwd.hpp>

#include <span>
#include <string_view>

namespace kindling::gltf {

// A file that requires an extension of Level::ignored loads with a warning, unless the load is
// strict. The specification demands a refusal; but shapes are right without it, and an image with
// other looks is more useful than none.
struct ExtensionEntry {
  ExtensionSupport support;
};

[[nodiscard]] std::span<const ExtensionEntry> extension_table();
[[nodiscard]] const ExtensionEntry* find_extension_entry(std::string_view name);

// Throws ImportFailure for a required extension that is unknown, or ignored if `warnings` is
// strict; warns once for each ignored one. `root` has passed check_json().
void check_extensions(const nlohmann::json& root, Warnings& warnings);

// Returns the extension object `name` of a checked object, or null.
[[nodiscard]] const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);
// Return a checked property, or `fallback` where it is absent.
[[nodiscard]] double number_or(const nlohmann::json& object, const char* name, double fallback);
[[nodiscard]] int64_t integer_or(const nlohmann::json& object, const char* name, int64_t fallback);

} // namespace kindling::gltf
