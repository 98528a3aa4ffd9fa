// Reads light profiles, and attaches them to nodes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/lights/photometric_lights.h"

#include "renderer/import/files/uri.h"
#include "renderer/import/json/extensions.h"
#include "renderer/import/lights/parse_ies.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kindling::gltf {
namespace {

using nlohmann::json;

constexpr const char* kPhotometricLights = "EXT_lights_ies";

// Returns a profile that emits nothing.
Photometry dark() { return {.vertical_deg = {0.0f}, .horizontal_deg = {0.0f}, .candela = {0.0f}}; }

Photometry read_profile(Document& document, const json& object, const std::string& pointer, Warnings& warnings) {
  const bool has_uri = object.contains("uri");
  if (has_uri == object.contains("bufferView"))
    fail(pointer,
         has_uri ? "both uri and bufferView, expected one of them" : "neither uri nor bufferView, expected one of them",
         "ONE_OF_MISMATCH");
  OwnedBytes owned;
  Bytes bytes;
  if (has_uri) {
    const auto& uri = object["uri"].get_ref<const std::string&>();
    Result<OwnedBytes> read = Error{};
    if (is_data_uri(uri)) {
      read = decode_data_uri(uri);
    } else {
      const auto path = resolve_uri(document.path.parent_path(), uri);
      read = path ? read_file(path.value(), document.limits.max_file_bytes) : Result<OwnedBytes>(path.error());
    }
    if (!read) {
      warnings.add("light profile", pointer + "/uri",
                   fmt::format("{}: {}; its lights are dark", in_quotes(uri), read.error().message), "IO_ERROR");
      return dark();
    }
    owned = std::move(read).value();
    bytes = owned.span();
    document.bytes_read += bytes.size();
    document.content_hash = hash_bytes(bytes, document.content_hash);
  } else {
    bytes = document.views[object["bufferView"].get<size_t>()].bytes;
  }
  Result<Photometry> web = parse_ies(as_text(bytes));
  if (!web) fail(pointer, web.error().message);
  web.value().name = object.value("name", "");
  return std::move(web).value();
}

} // namespace

void import_photometric_lights(Document& document, Scene& scene, Warnings& warnings) {
  if (const json* extension = find_extension(*document.json, kPhotometricLights)) {
    const json& lights = (*extension)["lights"];
    for (size_t i = 0; i < lights.size(); ++i) {
      try {
        scene.photometries.push_back(read_profile(
            document, lights[i], fmt::format("/extensions/{}/lights/{}", kPhotometricLights, i), warnings));
      } catch (const ImportFailure& fault) {
        warnings.repair("profile", fault, "its lights are dark");
        scene.photometries.push_back(dark());
      }
    }
  }
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const json* extension = find_extension((*document.json)["nodes"][i], kPhotometricLights);
    if (extension == nullptr) continue;
    const auto index = (*extension)["light"].get<uint64_t>();
    if (index >= scene.photometries.size()) {
      warnings.repair("node profile", fmt::format("/nodes/{}/extensions/{}/light", i, kPhotometricLights),
                      fmt::format("{}, the file has {} light profiles", index, scene.photometries.size()),
                      "UNRESOLVED_REFERENCE", "the node has no light");
      continue;
    }
    PunctualLight light;
    light.name = scene.photometries[index].name;
    light.photometry = static_cast<int>(index);
    light.intensity = static_cast<float>(number_or(*extension, "multiplier", 1.0));
    if (const auto color = extension->find("color"); color != extension->end())
      light.color = {(*color)[0].get<float>(), (*color)[1].get<float>(), (*color)[2].get<float>()};
    scene.nodes[i].photometric_light = static_cast<int>(scene.lights.size());
    scene.lights.push_back(std::move(light));
  }
}

} // namespace kindling::gltf
