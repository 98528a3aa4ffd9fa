// --aov, --cryptomatte and --shadow-catcher.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/layer_flags.h"

#include "renderer/app/flags/scene_flags.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>
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

void add_shadow_catcher_flag(FlagSet& flags, std::vector<std::string>& catchers) {
  flags.repeated("--shadow-catcher", "NAME",
                 "Node that, with all below it, shows nothing but the shadows on it: alpha is their darkness, for "
                 "compositing over a photograph; the background is transparent; may be given several times [none]",
                 [&catchers](auto text) {
                   std::string name;
                   Result<void> set = set_text(text, name);
                   if (set.ok()) catchers.push_back(std::move(name));
                   return set;
                 });
}

Result<void> check_layer_flags(const FlagSet& flags, RenderOptions& o) {
  if (o.shadow_catchers.empty()) {
    if (o.aovs.contains(Aov::shadow_catcher))
      return usage_error("--aov shadow_catcher: there is no shadow catcher; add --shadow-catcher NAME");
    return {};
  }
  if (flags.given("--background") && !o.integrator.transparent_background)
    return usage_error("--shadow-catcher: shadows are composited over another image; leave out --background or use "
                       "--background transparent");
  o.integrator.transparent_background = true;
  return {};
}

void add_layer_estimate_flags(FlagSet& flags, AovSet& aovs) {
  flags.repeated("--aov", "NAME,...", "Additional layers [none]", [&aovs](auto text) { return add_aovs(text, aovs); });
  flags.repeated("--cryptomatte", "NAME,...", "Cryptomatte layers [none]",
                 [&aovs](auto text) { return add_mattes(text, aovs); });
}

} // namespace kindling::app
