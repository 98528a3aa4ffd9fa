// Manifests as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/matte_metadata.h"

#include "renderer/film/cryptomatte.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace kindling {
namespace {

std::string manifest(const std::vector<std::string>& names) {
  nlohmann::json json = nlohmann::json::object();
  for (const std::string& name : names) json[name] = matte_hex(matte_id(name));
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::vector<std::string> names_of(const SurfaceNames& names, Matte matte) {
  if (matte == Matte::material) return names.materials;
  std::vector<std::string> chosen;
  for (size_t node = 0; node < names.nodes.size(); ++node)
    if (names.has_mesh[node] != 0)
      chosen.push_back(names.nodes[matte == Matte::object ? node : static_cast<size_t>(names.roots[node])]);
  return chosen;
}

} // namespace

void add_matte_metadata(const SurfaceNames& names, AovSet aovs, ImageMetadata& metadata) {
  for (const MatteInfo& info : kMattes) {
    if (!aovs.contains(info.matte)) continue;
    const std::string prefix = matte_metadata_prefix(info.matte);
    metadata.text[prefix + "name"] = info.layer;
    metadata.text[prefix + "hash"] = "MurmurHash3_32";
    metadata.text[prefix + "conversion"] = "uint32_to_float32";
    metadata.text[prefix + "manifest"] = manifest(names_of(names, info.matte));
  }
}

} // namespace kindling
