// Writers of EXR, PNG and JPEG files, which replace an existing file only when complete.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/result.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// A layer of an EXR file. `values` has channel_names.size() interleaved floats for each pixel of
// the data window.
struct ExrLayer {
  std::vector<std::string> channel_names; // complete names as stored: "R", "albedo.R", "Z"
  bool half = true;                       // stored as half, else as float
  std::vector<float> values;
};

struct ExrImage {
  V2i display_size_px{0, 0}; // displayWindow is (0, 0) to size - 1
  V2i data_min_px{0, 0};     // the dataWindow is the half-open range [data_min, data_max)
  V2i data_max_px{0, 0};
  std::vector<ExrLayer> layers;
  std::map<std::string, std::string> text; // string attributes: command line, version, scene hash
  std::map<std::string, float> numbers;    // float attributes: times
  std::map<std::string, int> integers;     // samples per pixel, seed
  std::map<std::string, M44f> matrices;    // worldToCamera, worldToNDC
};

[[nodiscard]] Result<void> write_exr(const std::filesystem::path& path, const ExrImage& image);

// Writes width * height * 4 display-referred values with straight alpha, clamped to [0, 1], in 8 or
// 16 bits and without dithering. `text` is written as tEXt chunks, or iTXt if a value is not ASCII;
// keys are reduced to their first 79 printable ASCII characters.
[[nodiscard]] Result<void> write_png(const std::filesystem::path& path, std::span<const float> rgba, const V2i& size_px,
                                     int bits, const std::map<std::string, std::string>& text = {});

// rgb: display-referred in [0, 1] (clamped), width * height * 3 values, at most 65500 pixels a
// side. quality: 1 to 100 as in libjpeg. text: a comment "key: value" each.
[[nodiscard]] Result<void> write_jpeg(const std::filesystem::path& path, std::span<const float> rgb, const V2i& size_px,
                                      int quality, const std::map<std::string, std::string>& text = {});

// Returns the bytes of the file that write_jpeg() writes.
[[nodiscard]] Result<std::string> encode_jpeg(std::span<const float> rgb, const V2i& size_px, int quality,
                                              const std::map<std::string, std::string>& text = {});

// Returns values of [0, 1] as integers to 255, rounded and clamped as in an 8-bit PNG; NaN
// becomes 0.
[[nodiscard]] std::vector<uint8_t> quantize_8bit(std::span<const float> values);

} // namespace kindling
