// Resolves the URIs of buffers, images and light profiles, and checks their links.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/document/scene_files.h"

#include "renderer/import/files/uri.h"
#include "renderer/import/json/extensions.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <system_error>

namespace kindling::gltf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Returns whether a file, with its links resolved, lies outside of the folder. Files that do not
// exist do not.
bool leads_out(const fs::path& file, const fs::path& canonical_folder) {
  std::error_code code;
  const fs::path canonical = fs::canonical(file, code);
  if (code) return false;
  return std::mismatch(canonical_folder.begin(), canonical_folder.end(), canonical.begin(), canonical.end()).first !=
         canonical_folder.end();
}

} // namespace

std::vector<fs::path> find_scene_files(const Document& document) {
  const fs::path folder = document.path.parent_path();
  std::error_code code;
  const fs::path canonical_folder = fs::canonical(folder.empty() ? fs::path(".") : folder, code);
  std::vector<fs::path> files;
  const auto add_all = [&](const json& owner, const char* name, const std::string& pointer) {
    const auto list = owner.find(name);
    if (list == owner.end()) return;
    for (size_t i = 0; i < list->size(); ++i) {
      const auto uri = (*list)[i].find("uri");
      if (uri == (*list)[i].end() || is_data_uri(uri->get_ref<const std::string&>())) continue;
      const Result<fs::path> path = resolve_uri(folder, uri->get_ref<const std::string&>());
      if (!path) continue;
      if (!document.limits.follow_links && leads_out(path.value(), canonical_folder))
        fail(fmt::format("{}/{}/{}/uri", pointer, name, i),
             fmt::format("{} is a symbolic link that leads out of the folder of the scene; copy the file there, or "
                         "accept such links with --follow-links",
                         in_quotes(uri->get_ref<const std::string&>())));
      files.push_back(path.value());
    }
  };
  add_all(*document.json, "buffers", "");
  add_all(*document.json, "images", "");
  if (const json* extension = find_extension(*document.json, "EXT_lights_ies"))
    add_all(*extension, "lights", "/extensions/EXT_lights_ies");
  return files;
}

} // namespace kindling::gltf
