// Film to files: EXR with its layers, PNG through a view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/film/film.h"
#include "renderer/image/display_transform.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace kindling {

struct ImageMetadata {
  std::map<std::string, std::string> text; // e.g. "kindling:commandLine"
  std::map<std::string, float> numbers;    // e.g. "kindling:renderSeconds"
  std::map<std::string, int> integers;     // e.g. "kindling:samplesPerPixel"
  M44f world_to_camera;
  M44f world_to_ndc;
};

struct WriteOptions {
  bool half = true; // EXR color as half; false: as float
  int png_bits = 8; // 8 or 16
};

// By extension, .exr or .png (any case). EXR: R, G, B, A premultiplied and one layer for each further AOV, dataWindow =
// crop. PNG: straight alpha, through `view`. An existing file is replaced only by a complete one.
[[nodiscard]] Result<void> write_film(const std::filesystem::path& path, const Film& film, const DisplayTransform& view,
                                      const ImageMetadata& metadata, const WriteOptions& options);

// Returns what an 8-bit PNG of the film would hold: RGBA, straight alpha, through `view`, rows of the crop window from
// the top.
[[nodiscard]] std::vector<uint8_t> display_rgba8(const Film& film, const DisplayTransform& view);

// The sentence for a name that write_film() would refuse, empty if it would not; to be asked before a long render.
[[nodiscard]] std::string unsupported_output(const std::filesystem::path& path);

} // namespace kindling
