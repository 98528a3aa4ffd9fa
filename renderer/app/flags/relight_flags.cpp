// The flags of `kindling relight`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/command_flags.h"
#include "renderer/app/flags/flag_set.h"
#include "renderer/app/flags/image_flags.h"
#include "renderer/app/options/options.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/text/parse_values.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

namespace {

constexpr double kMaxLightFactor = 1e6;

Result<Rgb> parse_factor(const std::string& group, const std::string& text) {
  Result<Rgb> color = parse_color(text);
  if (!color.ok() || !(max_component(color.value()) <= static_cast<float>(kMaxLightFactor)))
    return usage_error(
        fmt::format("'{}={}': the factor must be a number, or R,G,B, from 0 to {:g}", group, text, kMaxLightFactor));
  return color;
}

// "key=1.5,window=1,.8,.6": words without a name continue the color before them.
Result<void> add_factors(std::string_view text, std::vector<LightFactor>& factors) {
  const Result<std::vector<std::string>> words = parse_list(text);
  if (!words.ok()) return words.error();
  std::vector<std::pair<std::string, std::string>> groups; // names and factors
  for (const std::string& word : words.value()) {
    const size_t equals = word.find('=');
    if (equals == std::string::npos && groups.empty())
      return usage_error(fmt::format("'{}' has no factor; use GROUP=FACTOR or GROUP=R,G,B", word));
    if (equals == 0) return usage_error(fmt::format("'{}' names no group; use GROUP=FACTOR or GROUP=R,G,B", word));
    if (equals == std::string::npos)
      groups.back().second += "," + word;
    else
      groups.emplace_back(word.substr(0, equals), word.substr(equals + 1));
  }
  for (const auto& [group, factor] : groups) {
    const Result<Rgb> parsed = parse_factor(group, factor);
    if (!parsed.ok()) return parsed.error();
    // Clang 14 captures no structured binding, unless by another name.
    std::erase_if(factors, [&name = group](const LightFactor& earlier) { return earlier.group == name; });
    factors.push_back({group, parsed.value()});
  }
  return {};
}

} // namespace

void add_relight_flags(FlagSet& flags, RelightOptions& o) {
  flags.group("Light");
  flags.repeated("--group", "GROUP=FACTOR[,...]",
                 "Multiply the light of these groups by a factor, or by R,G,B: key=1.5,window=1,.8,.6 [1]",
                 [&o](auto text) { return add_factors(text, o.factors); });
  flags.value("--others", "FACTOR",
              fmt::format("Factor, or R,G,B, of all groups that --group does not name [{:g}]", o.others.x),
              [&o](auto text) -> Result<void> {
                const Result<Rgb> factor = parse_factor("others", std::string(text));
                if (!factor.ok()) return factor.error();
                o.others = factor.value();
                return {};
              });
  flags.group("Image");
  add_finished_image_flags(flags, o.image, "FILE's name with -relit.png, in the current folder");
}

Result<void> check_relight_flags(const FlagSet& /*flags*/, RelightOptions& o) {
  if (o.file.empty()) return usage_error("no image; use 'kindling relight FILE.exr|FILE.kacc --group GROUP=FACTOR'");
  if (!is_exr(o.file) && !is_accumulation(o.file))
    return usage_error(fmt::format("{}: has no light groups; use an .exr or a .kacc file", o.file.string()));
  if (o.image.outputs.empty()) o.image.outputs = {o.file.stem().string() + "-relit.png"};
  for (const std::filesystem::path& output : o.image.outputs)
    if (is_accumulation(output))
      return usage_error(fmt::format("--output: {}: sums are never relit; use .exr, .png or .jpg", output.string()));
  if (o.image.quiet && o.image.verbose) return usage_error("--quiet and --verbose: give one of them");
  return {};
}

} // namespace kindling::app
