// The table of names of progress modes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/options/progress_mode.h"

namespace kindling::app {

std::string_view progress_mode_name(ProgressMode mode) {
  switch (mode) {
  case ProgressMode::automatic: return "auto";
  case ProgressMode::plain: return "plain";
  case ProgressMode::json: return "json";
  case ProgressMode::none: return "none";
  }
  return "none";
}

std::optional<ProgressMode> progress_mode_from_name(std::string_view name) {
  for (const ProgressMode mode : {ProgressMode::automatic, ProgressMode::plain, ProgressMode::json, ProgressMode::none})
    if (progress_mode_name(mode) == name) return mode;
  return std::nullopt;
}

} // namespace kindling::app
