// One image of a loaded scene, from its pose to its files and its report.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/output/report.h"
#include "renderer/app/render/render_run.h"
#include "renderer/app/setup/render_scene.h"
#include "renderer/base/result.h"
#include "renderer/film/write_film.h"
#include "renderer/session/render_session.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// Which image: the options as if it were the only one, and what has been checked before.
struct ImageRequest {
  RenderOptions options;
  std::string command_line;                     // renders it again; for metadata and replays
  std::vector<std::filesystem::path> outputs{}; // of choose_outputs()
  const DisplayTransform* view = nullptr;       // of choose_view(); null for replays, which write nothing
  std::optional<int> frame{};                   // its number, with --frames: the summary is left to who renders them
  bool more = false;                            // images of this scene will follow
  double start_s = 0.0;                         // seconds since the start of the process that are none of its time
};

// The session's settings for an image of that size: how much of which sampling, by whom.
[[nodiscard]] RenderSettings make_render_settings(const RenderOptions& options, const V2i& size_px);

struct ImageResult {
  int exit_code = 0;
  std::optional<RenderReport> report; // if images were written
};

// Poses, builds, renders, writes the images and the statistics, and prints the summary. Where the user ends it the images have what there is.
// Consumes the scene unless more images follow. Fails as each of these steps does, with the first error; files that can be written are.
[[nodiscard]] Result<ImageResult> render_image(const ImageRequest& request, RenderScene& scene, RenderRun& run);

} // namespace kindling::app
