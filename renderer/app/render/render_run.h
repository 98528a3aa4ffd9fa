// What all images of one run of `kindling render` share: who is told, and who may end it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/base/progress.h"

#include <cstddef>
#include <string>

namespace kindling::app {

class RenderRun {
 public:
  // `console` must outlive it.
  RenderRun(const RenderOptions& options, Console& console);

  // A signal before a render: there is nothing to write yet. Says so.
  [[nodiscard]] bool interrupted_early();

  // The image in hand is this frame, the index-th of count; progress and messages say so.
  void start_frame(int number, size_t index, size_t count);
  void end_frame();

  Console& console;
  CancelToken cancel;
  SignalGuard signals;
  ProgressDisplay display;

 private:
  std::string of_frame_; // " of frame 7", of the image in hand
};

} // namespace kindling::app
