// Writing of films to files: EXR with layers, or PNG and JPEG through a view transform.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/film/cryptomatte.h"
#include "renderer/film/film.h"
#include "renderer/image/display_transform.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
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
  bool half = true;      // true: EXR colors are half; false: float
  int png_bits = 8;      // 8 or 16
  int jpeg_quality = 95; // 1 to 100
  // Four floats per pixel, as Film::resolve_rgba(), in place of the film's, which become the layer
  // "noisy" of EXR files; empty: none.
  std::span<const float> denoised;
  int matte_levels = kDefaultMatteLevels; // ids of a pixel in each matte, 1 to kMaxMatteLevels; odd: one more
};

// Writes a film as .exr, .png, .jpg or .jpeg (in any case). The names "-" and "png:-" are standard
// output as PNG, "jpg:-" and "exr:-" are standard output in these formats. EXR files contain
// premultiplied R, G, B, A, a layer for each further AOV and each light group, and the film's
// mattes (matte_channel_names()), whose names are in the metadata; the data window is the crop. PNG
// files have straight alpha, JPEG files are composited over black; their colors are transformed by
// `view`. An existing file is replaced only by a complete one.
[[nodiscard]] Result<void> write_film(const std::filesystem::path& path, const Film& film, const DisplayTransform& view,
                                      const ImageMetadata& metadata, const WriteOptions& options);

// Writes premultiplied pixels as write_film() does: .png, .jpg or .jpeg, or standard output in
// these formats. Fails (usage) for others.
[[nodiscard]] Result<void> write_display_file(const std::filesystem::path& path, std::vector<float> rgba,
                                              const V2i& size_px, const DisplayTransform& view,
                                              const std::map<std::string, std::string>& text,
                                              const WriteOptions& options);

// Returns true for "-", "png:-", "jpg:-" and "exr:-".
[[nodiscard]] bool is_standard_output(const std::filesystem::path& path);

// Returns the pixels of an 8-bit PNG of the film: RGBA, straight alpha, through `view`, rows of the
// crop window from the top.
[[nodiscard]] std::vector<uint8_t> display_rgba8(const Film& film, const DisplayTransform& view);

// Returns the pixels of a JPEG of the film before its compression: RGB, composited over black.
[[nodiscard]] std::vector<uint8_t> display_rgb8(const Film& film, const DisplayTransform& view,
                                                const WriteOptions& options);

// Returns display values with straight alpha, as PNG files have them before they are quantized, of
// interleaved premultiplied RGBA as Film::resolve_rgba() returns.
[[nodiscard]] std::vector<float> display_rgba(std::vector<float> rgba, const DisplayTransform& view);

// Returns the names of an AOV's channels in EXR files: Z for depth, LAYER.R, .G, .B for colors,
// LAYER.X, .Y, .Z for vectors, kindling.samples and kindling.variance. AOVs of the sample nearest
// to the center have Blender's names for passes without averages: IndexOB.X, IndexMA.X, UV.U, .V,
// .A, Depth.Z, Position.X, .Y, .Z, Vector.X, .Y, .Z, .W; `motion` has Nuke's: forward.u, .v,
// backward.u, .v.
[[nodiscard]] std::vector<std::string> channel_names(Aov aov);

// Light groups are layers of this prefix and the name of the group, as Blender names them.
inline constexpr std::string_view kLightGroupLayer = "Combined_";
[[nodiscard]] std::vector<std::string> light_group_channels(std::string_view group);

// Returns the error message if write_film() would reject the file name, else an empty string.
// Intended for checks before a long render.
[[nodiscard]] std::string unsupported_output(const std::filesystem::path& path);

} // namespace kindling
