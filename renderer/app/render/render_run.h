// Console, progress and cancellation of one run of `kindling render`, shared by all of its images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/facade/render_scene.h"

#include <cstddef>
#include <memory>
#include <string>

namespace kindling::app {

class RenderRun {
 public:
  // `console` must outlive it.
  RenderRun(const RenderOptions& options, Console& console);

  // Loads the scene of the options with progress. Fails as load_render_scene() does.
  [[nodiscard]] Result<std::unique_ptr<RenderScene>> load_scene(const RenderOptions& options);

  // Returns whether a signal came before the render. Prints a note then: there is nothing to write
  // yet.
  [[nodiscard]] bool interrupted_early();

  // Names the current image in progress and messages: frame `number`, the index-th of count.
  void start_frame(int number, size_t index, size_t count);
  void end_frame();

  Console& console;
  CancelToken cancel;
  SignalGuard signals;
  ProgressDisplay display;

 private:
  std::string of_frame_; // " of frame 7"; empty for a single image
};

} // namespace kindling::app
