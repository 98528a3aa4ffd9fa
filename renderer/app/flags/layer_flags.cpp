// --aov and --cryptomatte.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/layer_flags.h"

#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

namespace {

std::vector<std::string> aov_names() {
  std::vector<std::string> names;
  for (const AovInfo& info : kAovs) names.emplace_back(info.name);
  return names;
}

std::vector<std::string> matte_names() {
  std::vector<std::string> names;
  for (const MatteInfo& info : kMattes) names.emplace_back(info.name);
  return names;
}

Result<void> add_aovs(std::string_view text, AovSet& aovs) {
  Result<std::vector<std::string>> names = parse_list(text);
  if (!names.ok()) return names.error();
  for (const std::string& name : names.value()) {
    const std::optional<Aov> aov = aov_from_name(name);
    if (!aov) return unknown_name("AOV", name, aov_names());
    aovs.insert(*aov);
  }
  return {};
}

Result<void> add_mattes(std::string_view text, AovSet& aovs) {
  Result<std::vector<std::string>> names = parse_list(text);
  if (!names.ok()) return names.error();
  for (const std::string& name : names.value()) {
    const std::optional<Matte> matte = matte_from_name(name);
    if (!matte) return unknown_name("matte", name, matte_names());
    aovs.insert(*matte);
  }
  return {};
}

} // namespace

void add_layer_flags(FlagSet& flags, AovSet& aovs) {
  flags.repeated("--aov", "NAME[,NAME]...",
                 fmt::format("Additional layers of EXR files: {} [beauty and alpha]", join_choices(aov_names())),
                 [&aovs](auto text) { return add_aovs(text, aovs); });
  flags.repeated("--cryptomatte", "NAME[,NAME]...",
                 fmt::format("Cryptomatte layers of EXR files: {}; an asset is the node above an object that has no "
                             "parent [none]",
                             join_choices(matte_names())),
                 [&aovs](auto text) { return add_mattes(text, aovs); });
}

void add_layer_estimate_flags(FlagSet& flags, AovSet& aovs) {
  flags.repeated("--aov", "NAME,...", "Additional layers [none]", [&aovs](auto text) { return add_aovs(text, aovs); });
  flags.repeated("--cryptomatte", "NAME,...", "Cryptomatte layers [none]",
                 [&aovs](auto text) { return add_mattes(text, aovs); });
}

} // namespace kindling::app
