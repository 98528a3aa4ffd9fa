// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/one_image.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <set>

namespace kindling {

namespace {

using SettingsJson = nlohmann::json;

std::string value_text(const SettingsJson& object, const std::string& key) {
  const auto found = object.find(key);
  if (found == object.end()) return "nothing";
  if (found->is_null()) return "none";
  return found->is_string() ? found->get<std::string>()
                            : found->dump(-1, ' ', false, SettingsJson::error_handler_t::replace);
}

void compare_settings(const std::string& in_a, const std::string& in_b, std::vector<ImageDifference>& differences) {
  if (in_a == in_b) return;
  const SettingsJson a = SettingsJson::parse(in_a, nullptr, false), b = SettingsJson::parse(in_b, nullptr, false);
  const size_t before = differences.size();
  if (a.is_object() && b.is_object()) {
    std::set<std::string> keys;
    for (const SettingsJson& object : {a, b})
      for (const auto& [key, value] : object.items()) keys.insert(key);
    for (const std::string& key : keys)
      if (!a.contains(key) || !b.contains(key) || a[key] != b[key])
        differences.push_back({key, value_text(a, key), value_text(b, key)});
  }
  if (differences.size() == before) differences.push_back({"settings", in_a, in_b}); // no JSON, or spelled differently
}

std::string rect_text(const PixelRect& rect) {
  return fmt::format("{},{},{},{}", rect.min.x, rect.min.y, rect.max.x, rect.max.y);
}

} // namespace

std::vector<ImageDifference> image_differences(const AccumulationIdentity& a, const AccumulationIdentity& b) {
  std::vector<ImageDifference> differences;
  const auto compare = [&differences](std::string_view what, const std::string& in_a, const std::string& in_b) {
    if (in_a != in_b) differences.push_back({std::string(what), in_a, in_b});
  };
  compare(kProgramDiffers, a.program, b.program);
  compare(kSceneDiffers, fmt::format("{:016x}", a.scene_hash), fmt::format("{:016x}", b.scene_hash));
  const size_t before = differences.size();
  compare_settings(a.image, b.image, differences);
  if (differences.size() > before) return differences; // these have their names among the settings too
  compare("size", fmt::format("{}x{}", a.size_px.x, a.size_px.y), fmt::format("{}x{}", b.size_px.x, b.size_px.y));
  compare("crop", rect_text(a.crop), rect_text(b.crop));
  // Further samples are laid out as the first ones were; only the count that is wanted in the end may differ.
  compare("samples per pixel that the sampling is laid out for", fmt::format("{}", a.planned_samples),
          fmt::format("{}", b.planned_samples));
  return differences;
}

} // namespace kindling
