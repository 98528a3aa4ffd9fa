// Compares what accumulations say of their pictures.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/one_picture.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <map>
#include <set>

namespace kindling {

namespace {

using Json = nlohmann::json;

// Members by their path, as in "/lens/fstop"; not flattened where it is no JSON: then the text as a whole.
std::map<std::string, std::string> members_of(const std::string& picture) {
  std::map<std::string, std::string> members;
  const Json json = Json::parse(picture, nullptr, false);
  if (!json.is_object()) {
    members["settings"] = picture;
    return members;
  }
  if (json.empty()) return members;
  const Json flat = json.flatten();
  for (const auto& [path, value] : flat.items())
    members[path.substr(1)] = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return members;
}

std::string rect_text(const PixelRect& rect) {
  return std::to_string(rect.min.x) + "," + std::to_string(rect.min.y) + "," + std::to_string(rect.max.x) + "," +
         std::to_string(rect.max.y);
}

std::string hash_text(uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

} // namespace

std::vector<std::string> picture_differences(const AccumulationIdentity& a, const AccumulationIdentity& b) {
  std::vector<std::string> differences;
  const auto compare = [&differences](const std::string& what, const std::string& in_a, const std::string& in_b) {
    if (in_a != in_b) differences.push_back(what + ": " + in_a + " and " + in_b);
  };
  compare("program", a.program, b.program);
  compare("scene hash", hash_text(a.scene_hash), hash_text(b.scene_hash));
  compare("size", std::to_string(a.size_px.x) + "x" + std::to_string(a.size_px.y),
          std::to_string(b.size_px.x) + "x" + std::to_string(b.size_px.y));
  compare("crop", rect_text(a.crop), rect_text(b.crop));
  // Further samples are laid out as the first ones were; only the count that is wanted in the end may differ.
  compare("samples per pixel that the sampling is laid out for", std::to_string(a.planned_samples),
          std::to_string(b.planned_samples));
  if (a.picture == b.picture) return differences;
  const size_t before = differences.size();
  const std::map<std::string, std::string> members_a = members_of(a.picture);
  const std::map<std::string, std::string> members_b = members_of(b.picture);
  std::set<std::string> names;
  for (const auto& [name, value] : members_a) names.insert(name);
  for (const auto& [name, value] : members_b) names.insert(name);
  const auto value_of = [](const std::map<std::string, std::string>& members, const std::string& name) {
    const auto found = members.find(name);
    return found == members.end() ? std::string("nothing") : found->second;
  };
  for (const std::string& name : names) compare(name, value_of(members_a, name), value_of(members_b, name));
  if (differences.size() == before) compare("settings", a.picture, b.picture); // spelled differently
  return differences;
}

} // namespace kindling
