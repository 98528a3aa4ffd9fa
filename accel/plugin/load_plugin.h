// Accelerators from shared libraries that export the C interface of kindling_accelerator.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/plugin/kindling_accelerator.h"

#include <filesystem>
#include <memory>
#include <string>

namespace kindling::accel {

// An accelerator built by a plugin. Its queries pass the answers of the plugin on, unchecked.
class PluginAccelerator : public Accelerator {
 public:
  // Returns why a query failed, the first one if several did; empty while none has. Answers mean
  // nothing from then on.
  [[nodiscard]] virtual std::string failure() const = 0;
};

// Either of the two: a failed build has a reason.
struct PluginBuild {
  std::unique_ptr<PluginAccelerator> accelerator;
  std::string error;
};

// An open library. It stays open to the end of the process, because its code may have started
// threads or registered functions.
class AcceleratorPlugin {
 public:
  // Opens a library and agrees on a version. `error` is set, and the result null, if the file is no
  // shared library of this processor, exports no kindling_accelerator_plugin(), has no version that
  // this program knows, or leaves out a function that every plugin needs. Code of the library runs.
  [[nodiscard]] static std::unique_ptr<AcceleratorPlugin> open(const std::filesystem::path& file, std::string& error);

  // One line, at most 200 characters; empty if the plugin has none.
  [[nodiscard]] const std::string& description() const { return description_; }
  [[nodiscard]] uint32_t version() const { return table_.version; }

  // Builds over the borrowed input, by at most `threads` threads. `options` is passed on as it is.
  // Fails if the plugin does, or if anything moves or deforms. The hit filter is ignored: all
  // meshes are opaque. A C++ exception that leaves the plugin is an error too.
  [[nodiscard]] PluginBuild build(const BuildInput& input, int threads, const std::string& options) const;

 private:
  explicit AcceleratorPlugin(const KindlingAcceleratorTable& table);

  KindlingAcceleratorTable table_{};
  std::string description_;
};

} // namespace kindling::accel
