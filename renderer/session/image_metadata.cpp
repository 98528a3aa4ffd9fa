// Fills in metadata and converts it to JSON and back.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/image_metadata.h"

#include "renderer/session/program_identity.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kindling {

namespace {

using MetadataJson = nlohmann::json;

MetadataJson matrix_to_json(const M44f& matrix) {
  MetadataJson values = MetadataJson::array();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) values.push_back(matrix[row][column]);
  return values;
}

M44f matrix_from_json(const MetadataJson& json, const char* name) {
  M44f matrix;
  const auto found = json.find(name);
  if (found == json.end() || !found->is_array() || found->size() != 16) return matrix;
  for (size_t i = 0; i < 16; ++i)
    if ((*found)[i].is_number()) matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = (*found)[i].get<float>();
  return matrix;
}

// Copies the members of an object that have the wanted type.
template <typename Value>
void take_members(const MetadataJson& json, const char* name, bool (MetadataJson::*is_wanted)() const noexcept,
                  std::map<std::string, Value>& members) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_object()) return;
  for (const auto& [key, value] : found->items())
    if ((value.*is_wanted)()) members[key] = value.template get<Value>();
}

} // namespace

ImageMetadata make_metadata(const MetadataFacts& facts, const Camera& camera) {
  ImageMetadata metadata;
  metadata.text = {{"Software", fmt::format("Kindling {}", version())},
                   {"kindling:version", std::string(version())},
                   {"kindling:scene", facts.scene_file},
                   {"kindling:sceneHash", fmt::format("{:016x}", facts.scene_hash)},
                   {"kindling:integrator", facts.integrator},
                   {"kindling:accelerator", facts.accelerator}};
  if (!facts.command_line.empty()) metadata.text["kindling:commandLine"] = facts.command_line;
  if (facts.interrupted)
    metadata.text[std::string(kInterruptedKey)] =
        fmt::format("at {} of {} samples per pixel", facts.spp, facts.spp_wanted);
  metadata.integers = {{"kindling:seed", static_cast<int>(facts.seed)},
                       {"kindling:samplesPerPixel", static_cast<int>(facts.spp)},
                       {"kindling:threads", facts.threads}};
  metadata.numbers = {{"kindling:loadSeconds", static_cast<float>(facts.load_s)},
                      {"kindling:buildSeconds", static_cast<float>(facts.build_s)},
                      {"kindling:renderSeconds", static_cast<float>(facts.render_s)}};
  metadata.world_to_camera = camera.world_to_camera();
  metadata.world_to_ndc = camera.world_to_ndc();
  return metadata;
}

std::string metadata_to_json(const ImageMetadata& metadata) {
  MetadataJson json;
  json["text"] = metadata.text;
  json["numbers"] = metadata.numbers;
  json["integers"] = metadata.integers;
  json["world_to_camera"] = matrix_to_json(metadata.world_to_camera);
  json["world_to_ndc"] = matrix_to_json(metadata.world_to_ndc);
  return json.dump(-1, ' ', false, MetadataJson::error_handler_t::replace);
}

ImageMetadata metadata_from_json(std::string_view text) {
  ImageMetadata metadata;
  const MetadataJson json = MetadataJson::parse(text, nullptr, false);
  if (!json.is_object()) return metadata;
  take_members(json, "text", &MetadataJson::is_string, metadata.text);
  take_members(json, "numbers", &MetadataJson::is_number, metadata.numbers);
  take_members(json, "integers", &MetadataJson::is_number_integer, metadata.integers);
  metadata.world_to_camera = matrix_from_json(json, "world_to_camera");
  metadata.world_to_ndc = matrix_from_json(json, "world_to_ndc");
  return metadata;
}

} // namespace kindling
