// The one table of glTF extensions: what each file's extensionsUsed and extensionsRequired are held against.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/json/extension_support.h"

#include <nlohmann/json_fwd.hpp>

#include <span>
#include <string_view>

namespace kindling::gltf {

struct ExtensionEntry {
  ExtensionSupport support;
  // Only for Level::ignored: a file that requires it still loads, with a warning, because shapes stay right and only
  // looks differ. The specification would have us refuse; a person who asked for an image is better served by one.
  bool loads_if_required = true;
};

[[nodiscard]] std::span<const ExtensionEntry> extension_table();
[[nodiscard]] const ExtensionEntry* find_extension_entry(std::string_view name);

// Throws ImportFailure for a required extension that is unknown or cannot be ignored; warns once for each that is
// ignored. `root` has been checked by check_json().
void check_extensions(const nlohmann::json& root, Warnings& warnings);

// The extension object `name` of a checked object, or null.
[[nodiscard]] const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);
// A checked property, or `fallback` where it is absent.
[[nodiscard]] double number_or(const nlohmann::json& object, const char* name, double fallback);
[[nodiscard]] int64_t integer_or(const nlohmann::json& object, const char* name, int64_t fallback);

} // namespace kindling::gltf
