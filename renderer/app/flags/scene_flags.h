// The flags of scene, camera and light that several commands share, and setters for common values.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/options/options.h"
#include "renderer/base/result.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// Scene, camera and light.
void add_scene_flags(FlagSet& flags, RenderOptions& options);
void add_size_flag(FlagSet& flags, RenderOptions& options);
// Checks combinations of the flags of add_scene_flags() and combines --turn with --target; fails
// (usage).
[[nodiscard]] Result<void> check_scene_flags(const FlagSet& flags, RenderOptions& options);

// A usage error that lists the accepted names.
[[nodiscard]] Error unknown_name(std::string_view what, std::string_view text, const std::vector<std::string>& names);
// Store a value, and fail (usage) if it is empty or, for a batch size, no multiple of 64.
[[nodiscard]] Result<void> set_text(std::string_view text, std::string& target);
[[nodiscard]] Result<void> set_path(std::string_view text, std::filesystem::path& target);
[[nodiscard]] Result<void> set_batch_size(std::string_view text, uint32_t& target);

// Stores the value that a table of names has found; fails (usage) with the accepted names if it has
// found none.
template <typename T>
Result<void> choose(std::optional<T> found, T& target, std::string_view what, std::string_view text,
                    const std::vector<std::string>& names) {
  if (!found) return unknown_name(what, text, names);
  target = *found;
  return {};
}

} // namespace kindling::app
