// Flags that name a device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"
#include "renderer/base/text.h"
#include "renderer/device/make_device.h"

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// `device`: a DeviceKind, or an optional one. `otherwise`: the meaning of its absence, for the
// help.
template <typename Device>
void add_device_flag(FlagSet& flags, Device& device, std::string_view otherwise) {
  std::vector<std::string> names;
  for (const DeviceKind kind : kDeviceKinds) names.emplace_back(device_kind_name(kind));
  const std::string help =
      fmt::format("Device that renders: {}; does not change the image [{}]", join_choices(names), otherwise);
  flags.value("--device", "NAME", help, [&device, names](auto text) -> Result<void> {
    const std::optional<DeviceKind> kind = device_kind_from_name(text);
    if (!kind) return unknown_name("device", text, names);
    device = *kind;
    return {};
  });
}

inline void add_device_memory_flag(FlagSet& flags, std::optional<uint64_t>& bytes, std::string_view otherwise) {
  flags.value("--device-memory", "SIZE",
              fmt::format("Limit on the memory of the device, such as 6G: textures beyond it are paged from the "
                          "processor's memory; does not change the image [{}]",
                          otherwise),
              [&bytes](auto text) { return store(parse_bytes(text), bytes); });
}

// Refuses a limit on the memory of no device.
[[nodiscard]] inline Result<void> check_device_memory(DeviceKind device, const std::optional<uint64_t>& bytes) {
  if (!bytes || device != DeviceKind::cpu) return {};
  return usage_error("--device-memory: has no meaning with --device cpu; use --device gpu, auto or host");
}

// A device that is measured beside the processor: host or gpu. `help` names what it does.
inline void add_measured_device_flag(FlagSet& flags, std::optional<DeviceKind>& device, std::string_view help) {
  const std::vector<std::string> names{std::string(device_kind_name(DeviceKind::host)),
                                       std::string(device_kind_name(DeviceKind::gpu))};
  flags.value("--device", "host|gpu", fmt::format("{} [none]", help), [&device, names](auto text) -> Result<void> {
    const std::optional<DeviceKind> kind = device_kind_from_name(text);
    if (!kind || !needs_device(*kind)) return unknown_name("device", text, names);
    device = *kind;
    return {};
  });
}

} // namespace kindling::app
