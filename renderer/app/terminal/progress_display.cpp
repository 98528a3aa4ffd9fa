// Chooses the moments at which progress is printed.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/progress_display.h"

#include "renderer/app/terminal/process_info.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace kindling::app {

namespace {

// True if standard error is a terminal that can rewrite a line.
bool can_rewrite_lines() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && terminal && std::string_view(terminal) != "dumb";
}

int terminal_columns() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

double seconds_between(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

// Shorter phases get no plain line at their end.
constexpr double kPlainPhaseSeconds = 1.0;

} // namespace

ProgressDisplay::ProgressDisplay(Console& console, ProgressMode mode, const ProgressContext& context)
    : console_(console), context_(context), phase_start_(Clock::now()), shown_(phase_start_) {
  switch (mode) {
  case ProgressMode::automatic: style_ = can_rewrite_lines() ? Style::terminal : Style::plain; break;
  case ProgressMode::plain: style_ = Style::plain; break;
  case ProgressMode::json: style_ = Style::json; break;
  case ProgressMode::none: style_ = Style::none; break;
  }
}

void ProgressDisplay::start_frame(int number, size_t index, size_t count) {
  const std::lock_guard lock(mutex_);
  frame_ = FrameState{number, index, count, std::nullopt};
  frame_start_ = Clock::now();
}

void ProgressDisplay::end_frame() {
  const std::lock_guard lock(mutex_);
  frame_.reset();
  ++frames_done_;
  frames_done_s_ += seconds_between(frame_start_, Clock::now());
}

void ProgressDisplay::on_warning(std::string_view message) {
  {
    const std::lock_guard lock(mutex_);
    if (frame_ && !warnings_.emplace(message).second) return;
  }
  console_.warning(message);
}

void ProgressDisplay::start_phase(Phase phase, double done_before) {
  const std::lock_guard lock(mutex_);
  last_ = {.phase = phase, .done = done_before, .total = 1.0};
  last_.samples_per_pixel = done_before * context_.spp_wanted.value_or(0);
  done_before_ = done_before;
  phase_start_ = Clock::now();
  phase_running_ = true;
  if (style_ == Style::plain)
    shown_ = phase_start_;
  else
    show(phase_start_);
}

void ProgressDisplay::end_phase() {
  const std::lock_guard lock(mutex_);
  if (!phase_running_) return;
  phase_running_ = false;
  const Clock::time_point now = Clock::now();
  if (last_.phase != Phase::render) last_.done = last_.total;
  if (style_ == Style::json || (style_ == Style::plain && seconds_between(phase_start_, now) >= kPlainPhaseSeconds))
    show(now);
  if (style_ == Style::terminal) console_.status({});
}

void ProgressDisplay::on_progress(const ProgressSnapshot& snapshot) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  if (snapshot.phase == Phase::textures && !textures_start_) textures_start_ = now;
  last_ = snapshot;
  note_interruption();
  const double interval_s = style_ == Style::terminal ? 0.1 : style_ == Style::json ? 0.2 : 5.0;
  if (seconds_between(shown_, now) >= interval_s) show(now);
}

ProgressState ProgressDisplay::state_at(Clock::time_point now) const {
  ProgressState state;
  const bool decoding = last_.phase == Phase::textures && textures_start_;
  const double phase_elapsed_s = seconds_between(decoding ? *textures_start_ : phase_start_, now);
  state.phase = last_.phase;
  state.elapsed_s = seconds_since_process_start();
  state.resident_bytes = resident_bytes();
  state.fraction = last_.total > 0.0 ? last_.done / last_.total : 0.0;
  if (last_.phase == Phase::render) {
    state.samples_per_pixel = last_.samples_per_pixel;
    state.spp_wanted = context_.spp_wanted;
    state.converged = last_.converged;
    state.rays = last_.rays;
    state.rays_per_s = phase_elapsed_s > 0.0 ? static_cast<double>(last_.rays) / phase_elapsed_s : 0.0;
  }
  if (phase_running_ && done_before_ < 1.0) {
    const double done_now = std::max(0.0, (state.fraction - done_before_) / (1.0 - done_before_));
    state.remaining_s = remaining_seconds(done_now, phase_elapsed_s);
  }
  state.frame = frame_;
  if (frame_)
    state.frame->remaining_s = remaining_seconds_of_frames(
        frames_done_, frames_done_s_, frame_->count - frame_->index, seconds_between(frame_start_, now),
        last_.phase == Phase::render ? state.remaining_s : std::nullopt);
  return state;
}

void ProgressDisplay::show(Clock::time_point now) {
  shown_ = now;
  switch (style_) {
  case Style::terminal: console_.status(format_status_line(state_at(now), terminal_columns())); break;
  case Style::plain: console_.line("kindling: " + format_plain_line(state_at(now))); break;
  case Style::json: console_.line(format_json_line(state_at(now))); break;
  case Style::none: break;
  }
}

void ProgressDisplay::note_interruption() {
  if (interruption_noted_ || !context_.signals || context_.signals->received() == 0) return;
  interruption_noted_ = true;
  console_.note(context_.checkpoint
                    ? "interrupted: saving the checkpoint and writing the images; a second interrupt quits at once"
                    : "interrupted: finishing the pass and writing the images; a second interrupt quits at once");
}

} // namespace kindling::app
