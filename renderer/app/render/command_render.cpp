// Runs `kindling render`: checks outputs and view, loads the scene, renders one image or frames.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/command_render.h"

#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/frame_names.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/render/render_frames.h"
#include "renderer/app/render/render_image.h"
#include "renderer/app/render/render_run.h"
#include "renderer/app/setup/camera_path.h"

#include <tbb/global_control.h>

#include <optional>
#include <utility>

namespace kindling::app {

namespace {

Result<int> render_images(const RenderOptions& options, const std::string& command_line, Console& console) {
  RenderRun run(options, console);
  if (Result<void> opened = run.open_viewer(options); !opened.ok()) return opened.error();

  if (!options.frames.numbers.empty() && !options.replay_pixel) return render_frames(options, command_line, run);

  ImageRequest request{options, command_line};
  if (options.replay_pixel && !options.frames.numbers.empty())
    request.options = options_of_frame(options, options.frames.numbers.front());
  std::optional<DisplayTransform> view;
  std::vector<NamedFile> written;
  if (!options.replay_pixel) { // a replay writes no files
    Result<std::vector<std::filesystem::path>> outputs = choose_outputs(options);
    if (!outputs.ok()) return outputs.error();
    request.outputs = std::move(outputs).value();
    Result<DisplayTransform> chosen = choose_view(options);
    if (!chosen.ok()) return chosen.error();
    view = std::move(chosen).value();
    request.view = &*view;
    written = files_written(options, request.outputs);
    if (Result<void> remain = check_inputs_remain(written, with_role(kViewFile, view->files())); !remain.ok())
      return remain.error();
  }

  const Result<std::optional<CameraPath>> path = load_camera_path(options);
  if (!path.ok()) return path.error();
  Result<std::unique_ptr<RenderScene>> scene = run.load_scene(options);
  if (!scene.ok()) return scene.error();
  if (Result<void> remain = check_inputs_remain(written, with_role(kSceneFile, scene.value()->files)); !remain.ok())
    return remain.error();
  if (Result<void> placed = place_on_path(path.value(), *scene.value(), request.options); !placed.ok())
    return placed.error();
  const Result<ImageResult> result = render_image(request, *scene.value(), run);
  if (!result.ok()) return result.error();
  return result.value().exit_code;
}

} // namespace

Result<int> run_render(const RenderOptions& options, const std::string& command_line, Console& console) {
  std::optional<tbb::global_control> limit;
  if (options.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(options.threads));
  return render_images(options, command_line, console);
}

} // namespace kindling::app
