// Converts image metadata to JSON and back.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/render_metadata.h"

#include "renderer/app/text/text_format.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <limits>

namespace kindling::app {

namespace {

using SortedJson = nlohmann::json;

SortedJson matrix_to_json(const M44f& matrix) {
  SortedJson values = SortedJson::array();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) values.push_back(matrix[row][column]);
  return values;
}

M44f matrix_from_json(const SortedJson& json, const char* name) {
  M44f matrix;
  const auto found = json.find(name);
  if (found == json.end() || !found->is_array() || found->size() != 16) return matrix;
  for (size_t i = 0; i < 16; ++i)
    if ((*found)[i].is_number()) matrix[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = (*found)[i].get<float>();
  return matrix;
}

// Copies the members of an object that have the wanted type.
template <typename Value>
void take_members(const SortedJson& json, const char* name, bool (SortedJson::*is_wanted)() const noexcept,
                  std::map<std::string, Value>& members) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_object()) return;
  for (const auto& [key, value] : found->items())
    if ((value.*is_wanted)()) members[key] = value.template get<Value>();
}

// The samples of every pixel that adaptive sampling has not stopped, as a render counts them.
uint32_t finished_samples(const Coverage& coverage) {
  uint32_t least = std::numeric_limits<uint32_t>::max();
  uint32_t most = 0;
  for (size_t i = 0; i < coverage.block_count(); ++i) {
    uint32_t count = 0;
    for (const SampleRange& span : coverage[i].spans) count += span.count();
    most = std::max(most, count);
    if (!coverage[i].stopped) least = std::min(least, count);
  }
  return std::min(least, most);
}

} // namespace

std::string metadata_to_json(const ImageMetadata& metadata) {
  SortedJson json;
  json["text"] = metadata.text;
  json["numbers"] = metadata.numbers;
  json["integers"] = metadata.integers;
  json["world_to_camera"] = matrix_to_json(metadata.world_to_camera);
  json["world_to_ndc"] = matrix_to_json(metadata.world_to_ndc);
  return json.dump(-1, ' ', false, SortedJson::error_handler_t::replace);
}

ImageMetadata metadata_from_json(std::string_view text) {
  ImageMetadata metadata;
  const SortedJson json = SortedJson::parse(text, nullptr, false);
  if (!json.is_object()) return metadata;
  take_members(json, "text", &SortedJson::is_string, metadata.text);
  take_members(json, "numbers", &SortedJson::is_number, metadata.numbers);
  take_members(json, "integers", &SortedJson::is_number_integer, metadata.integers);
  metadata.world_to_camera = matrix_from_json(json, "world_to_camera");
  metadata.world_to_ndc = matrix_from_json(json, "world_to_ndc");
  return metadata;
}

ImageMetadata metadata_of(const Accumulation& accumulation) {
  const RenderState& state = accumulation.state;
  ImageMetadata metadata = metadata_from_json(accumulation.identity.metadata);
  std::string command_line = "kindling";
  for (const std::string& argument : accumulation.identity.arguments) command_line += ' ' + shell_quote(argument);
  metadata.text["kindling:commandLine"] = command_line;
  metadata.integers["kindling:samplesPerPixel"] = static_cast<int>(finished_samples(state.coverage));
  metadata.integers["kindling:processes"] = static_cast<int>(state.work.runs);
  metadata.integers.erase("kindling:threads"); // differs among processes
  metadata.numbers["kindling:renderSeconds"] = static_cast<float>(state.work.render_s);
  metadata.numbers.erase("kindling:loadSeconds");
  metadata.numbers.erase("kindling:buildSeconds");
  return metadata;
}

} // namespace kindling::app
