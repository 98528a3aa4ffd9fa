// Console, progress and cancellation of one run of `kindling render`, shared by all of its images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/tev/tev_preview.h"
#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/facade/render_scene.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>

namespace kindling::app {

class RenderRun {
  // Read by the thread of `signals`, so that they outlive it.
  std::atomic<int> storing_{0};
  std::atomic<bool> renders_{false};

 public:
  // `console` must outlive it.
  RenderRun(const RenderOptions& options, Console& console);

  // Loads the scene of the options with progress. Fails as load_render_scene() does.
  [[nodiscard]] Result<std::unique_ptr<RenderScene>> load_scene(const RenderOptions& options);

  // Returns whether a signal came before the render. Prints a note then: there is nothing to write
  // yet.
  [[nodiscard]] bool interrupted_early();

  // While one of these exists, no deadline after a signal ends the process: results that exist
  // nowhere else are being stored.
  class Storing {
   public:
    explicit Storing(RenderRun& run) : run_(run) { ++run_.storing_; }
    ~Storing() { --run_.storing_; }
    Storing(const Storing&) = delete;
    Storing& operator=(const Storing&) = delete;

   private:
    RenderRun& run_;
  };

  // To be called when everything of an interrupted run is stored: from then on no deadline ends the
  // process, which is about to end by itself.
  void end_deadlines() { ++storing_; }

  // To be called before the first sample of an image is taken.
  void start_render() { renders_ = true; }

  // Connects to the viewer of the options, if there is one. Fails (input_output).
  [[nodiscard]] Result<void> open_viewer(const RenderOptions& options);
  [[nodiscard]] TevPreview* viewer() { return viewer_.get(); } // null: none

  // Names the current image in progress and messages: frame `number`, the index-th of count.
  void start_frame(int number, size_t index, size_t count);
  void end_frame();

  Console& console;
  CancelToken cancel;
  SignalGuard signals;
  ProgressDisplay display;

 private:
  [[noreturn]] void end(int signal, bool checkpoint);

  std::unique_ptr<TevPreview> viewer_;
  std::string of_frame_; // " of frame 7"; empty for a single image
};

} // namespace kindling::app
