// A plugin of `kindling shootout --plugin FILE[,OPTIONS]`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace kindling::app {

struct PluginSpec {
  std::filesystem::path file;
  std::string options; // passed to the plugin as they are

  // The name in reports: that of the file, with the options. Never that of an accelerator of ours.
  [[nodiscard]] std::string name() const { return file.filename().string() + (options.empty() ? "" : "," + options); }
  bool operator==(const PluginSpec&) const = default;
};

} // namespace kindling::app
