// What all pictures of one run share.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render_run.h"

#include <fmt/format.h>

#include <optional>

namespace kindling::app {

namespace {

ProgressContext progress_context(const RenderOptions& options, const SignalGuard& signals) {
  const bool endless = options.time_limit_s && !options.spp;
  return {endless ? std::nullopt : std::optional(options.samples_per_pixel()), &signals, options.checkpoint.enabled()};
}

} // namespace

RenderRun::RenderRun(const RenderOptions& options, Console& run_console)
    : console(run_console), signals(cancel), display(console, options.progress, progress_context(options, signals)) {}

bool RenderRun::interrupted_early() {
  if (signals.received() == 0) return false;
  display.end_phase();
  console.note(of_frame_.empty() ? "interrupted before the render: nothing was written"
                                 : fmt::format("interrupted before the render{0}: nothing{0} was written", of_frame_));
  return true;
}

void RenderRun::start_frame(int number, size_t index, size_t count) {
  of_frame_ = fmt::format(" of frame {}", number);
  display.start_frame(number, index, count);
}

void RenderRun::end_frame() {
  of_frame_.clear();
  display.end_frame();
}

} // namespace kindling::app
