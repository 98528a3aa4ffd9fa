// The flags that several commands share: which scene, seen from where, in which light; and how values are stored.
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
// What no flag of add_scene_flags() can judge alone; fails (usage).
[[nodiscard]] Result<void> check_scene_flags(const FlagSet& flags, const RenderOptions& options);

[[nodiscard]] Error unknown_name(std::string_view what, std::string_view text, const std::vector<std::string>& names);
[[nodiscard]] Result<void> set_text(std::string_view text, std::string& target);
[[nodiscard]] Result<void> set_path(std::string_view text, std::filesystem::path& target);
[[nodiscard]] Result<void> set_batch_size(std::string_view text, uint32_t& target);

// Stores what a table of names has found; fails with the names if it has found nothing.
template <typename T>
Result<void> choose(std::optional<T> found, T& target, std::string_view what, std::string_view text,
                    const std::vector<std::string>& names) {
  if (!found) return unknown_name(what, text, names);
  target = *found;
  return {};
}

} // namespace kindling::app
