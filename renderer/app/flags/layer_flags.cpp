// --aov, --cryptomatte, --shadow-catcher and --shadow-catchers.
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

std::string_view shadow_catchers_name(bool of_file) { return of_file ? "extras" : "off"; }

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

void add_shadow_catcher_flags(FlagSet& flags, RenderOptions& o) {
  flags.repeated("--shadow-catcher", "NAME",
                 "Node that, with all below it, shows nothing but the shadows on it: alpha is their darkness, for "
                 "compositing over a photograph; the background is transparent; may be given several times [none]",
                 [&o](auto text) {
                   std::string name;
                   Result<void> set = set_text(text, name);
                   if (set.ok()) o.shadow_catchers.push_back(std::move(name));
                   return set;
                 });
  flags.value(
      "--shadow-catchers", "off|extras",
      fmt::format("extras: also the nodes and materials that the file marks as shadow catchers [{}]",
                  shadow_catchers_name(o.shadow_catchers_of_file)),
      [&o](auto text) {
        for (const bool of_file : {false, true}) {
          if (text != shadow_catchers_name(of_file)) continue;
          o.shadow_catchers_of_file = of_file;
          return Result<void>();
        }
        return Result<void>(usage_error(fmt::format(
            "'{}' is no source of shadow catchers; use off or extras; --shadow-catcher NAME names a node", text)));
      });
}

Result<void> check_layer_flags(const FlagSet& flags, RenderOptions& o) {
  if (!o.has_shadow_catchers()) {
    if (o.aovs.contains(Aov::shadow_catcher))
      return usage_error("--aov shadow_catcher: there is no shadow catcher; add --shadow-catcher NAME");
    return {};
  }
  if (flags.given("--background") && !o.integrator.transparent_background)
    return usage_error(fmt::format("{}: shadows are composited over another image; leave out --background or use "
                                   "--background transparent",
                                   o.shadow_catchers.empty() ? "--shadow-catchers" : "--shadow-catcher"));
  o.integrator.transparent_background = true;
  return {};
}

void add_layer_estimate_flags(FlagSet& flags, AovSet& aovs) {
  flags.repeated("--aov", "NAME,...", "Additional layers [none]", [&aovs](auto text) { return add_aovs(text, aovs); });
  flags.repeated("--cryptomatte", "NAME,...", "Cryptomatte layers [none]",
                 [&aovs](auto text) { return add_mattes(text, aovs); });
}

} // namespace kindling::app
