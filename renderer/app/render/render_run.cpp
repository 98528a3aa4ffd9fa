// Loads with progress, reports early interruptions, and names frames.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/render_run.h"

#include "renderer/app/terminal/exit_code.h"

#include <fmt/format.h>

#include <unistd.h>

#include <optional>
#include <utility>

namespace kindling::app {

namespace {

ProgressContext progress_context(const RenderOptions& options, const SignalGuard& signals) {
  std::optional<uint32_t> wanted;
  if (!options.time_limit_s || options.spp) wanted = options.samples_per_pixel();
  if (options.part.samples)
    if (const Result<SampleRange> part = part_samples(options.samples_per_pixel(), *options.part.samples); part.ok())
      wanted = part.value().count();
  return {wanted, &signals, options.checkpoint.enabled()};
}

} // namespace

RenderRun::RenderRun(const RenderOptions& options, Console& run_console)
    : console(run_console),
      signals(cancel, {.deadlines = {},
                       .storing = [this] { return storing_ > 0; },
                       .end = [this, saves = options.checkpoint.enabled()](int signal) { end(signal, saves); }}),
      display(console, options.progress, progress_context(options, signals)) {}

Result<std::unique_ptr<RenderScene>> RenderRun::load_scene(const RenderOptions& options) {
  display.start_phase(Phase::load);
  Result<std::unique_ptr<RenderScene>> scene = load_render_scene(options.scene_file, options, &display);
  if (scene.ok()) scene.value()->abandon = &cancel.abandon_flag();
  if (scene.ok()) display.end_phase();
  return scene;
}

// Nothing is cleaned up: the threads of the render are in the middle of their work.
void RenderRun::end(int signal, bool checkpoint) {
  console.note(!renders_     ? "interrupted before the render: nothing was written"
               : !checkpoint ? "interrupted in the middle of work that takes too long: no image was written"
                             : "interrupted in the middle of work that takes too long: the checkpoint holds the "
                               "samples of its last save, and no image was written");
  _exit(exit_code_of_signal(signal));
}

bool RenderRun::interrupted_early() {
  if (signals.received() == 0) return false;
  display.end_phase();
  console.note(of_frame_.empty() ? "interrupted before the render: nothing was written"
                                 : fmt::format("interrupted before the render{0}: nothing{0} was written", of_frame_));
  return true;
}

Result<void> RenderRun::open_viewer(const RenderOptions& options) {
  if (!options.tev) return {};
  Result<TevConnection> connection = TevConnection::open(*options.tev);
  if (!connection.ok()) return connection.error();
  viewer_ = std::make_unique<TevPreview>(std::move(connection).value(),
                                         [this](const std::string& message) { display.on_warning(message); });
  return {};
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
