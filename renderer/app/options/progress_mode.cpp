// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/options/progress_mode.h"

namespace kindling::app {

std::optional<ProgressMode> progress_mode_from_name(std::string_view name) {
  if (name == "auto") return ProgressMode::automatic;
  if (name == "plain") return ProgressMode::plain;
  if (name == "json") return ProgressMode::json;
  if (name == "none") return ProgressMode::none;
  return std::nullopt;
}

} // namespace kindling::app
