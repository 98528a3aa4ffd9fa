// Renders one image of a loaded scene, from its pose to its files and its report.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/output/report.h"
#include "renderer/app/render/render_run.h"
#include "renderer/base/result.h"
#include "renderer/facade/render_scene.h"
#include "renderer/film/write_film.h"
#include "renderer/session/render_session.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// The options of one image, with outputs and view that have been checked.
struct ImageRequest {
  RenderOptions options;
  std::string command_line;                     // that renders this image again; for metadata and replays
  std::vector<std::filesystem::path> outputs{}; // from choose_outputs()
  const DisplayTransform* view = nullptr;       // from choose_view(); null for replays, which write no files
  std::optional<int> frame{};                   // its number, with --frames; the caller prints the summary
  bool more = false;                            // further images of this scene follow
  // Gets the pixels for a video, as ImageWriting::frame; null: none is made.
  std::function<Result<void>(const std::vector<uint8_t>& rgb, const V2i& size_px)> frame_pixels{};
  double start_s = 0.0; // start of this image, in seconds since the start of the process
};

// Returns the settings of render() for an image of that size.
[[nodiscard]] RenderSettings make_render_settings(const RenderOptions& options, const V2i& size_px);

struct ImageResult {
  int exit_code = 0;
  std::optional<RenderReport> report; // set if images were written
};

// Poses, builds, renders, writes images and statistics, and prints the summary. If interrupted,
// images hold the samples finished so far. Consumes the scene unless more images follow. Returns
// the first error of these steps; an error of one file does not keep the others from being written.
[[nodiscard]] Result<ImageResult> render_image(const ImageRequest& request, RenderScene& scene, RenderRun& run);

} // namespace kindling::app
