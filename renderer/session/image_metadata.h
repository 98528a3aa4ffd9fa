// Makes the metadata of images, and converts it to JSON for accumulation files.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/film/write_film.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace kindling {

// In the metadata of images that lack samples because the render was interrupted.
inline constexpr std::string_view kInterruptedKey = "kindling:interrupted";

// Facts about a render that its images carry. Those known after the render are 0 in accumulation
// files.
struct MetadataFacts {
  std::string command_line; // empty: none
  std::string scene_file;
  uint64_t scene_hash = 0;
  std::string integrator;
  std::string accelerator; // accel::kind_description()
  uint32_t seed = 0;
  uint32_t spp = 0; // finished samples of every pixel
  uint32_t spp_wanted = 0;
  bool interrupted = false;
  int threads = 0;
  double load_s = 0.0;
  double build_s = 0.0;
  double render_s = 0.0;
};

// Returns metadata whose keys begin with "kindling:" where OpenEXR knows no name of its own.
[[nodiscard]] ImageMetadata make_metadata(const MetadataFacts& facts, const Camera& camera);

// Returns a JSON object on one line.
[[nodiscard]] std::string metadata_to_json(const ImageMetadata& metadata);
// Returns the metadata that metadata_to_json() was given, to the bit. Skips members of other types;
// text that is no JSON object gives empty metadata.
[[nodiscard]] ImageMetadata metadata_from_json(std::string_view json);

} // namespace kindling
