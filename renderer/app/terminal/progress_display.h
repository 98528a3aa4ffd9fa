// Shows the progress of a render on standard error, and warnings as they come.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/progress_mode.h"
#include "renderer/app/terminal/console.h"
#include "renderer/app/terminal/progress_format.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/base/progress.h"

#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace kindling::app {

// Facts that progress reports do not contain.
struct ProgressContext {
  std::optional<uint32_t> spp_wanted;   // unset: a time limit ends the render
  const SignalGuard* signals = nullptr; // may be null; asked for an interruption by the user
  bool checkpoint = false;              // a checkpoint is saved on interruption
};

// Prints a status line on a terminal, plain lines or JSON lines. A status line is rewritten at most
// ten times a second. A plain line is printed every 5 s and at the end of long phases. A JSON line
// is printed for each report of the library, at most five times a second, and at the end of each
// phase. ProgressMode::automatic takes the status line on a terminal, else plain lines.
class ProgressDisplay final : public ProgressListener {
 public:
  ProgressDisplay(Console& console, ProgressMode mode, const ProgressContext& context);

  void on_progress(const ProgressSnapshot& snapshot) override;
  // Prints a warning, unless an earlier frame had the same.
  void on_warning(std::string_view message) override;
  void on_info(std::string_view message) override { console_.detail(message); }

  // `done_before` is the share of the phase that earlier runs have done, in [0, 1].
  void start_phase(Phase phase, double done_before = 0.0);
  // Ends the phase and removes the status line.
  void end_phase();

  // Starts a frame, the index-th of count, counted from 1.
  void start_frame(int number, size_t index, size_t count);
  void end_frame();

 private:
  using Clock = std::chrono::steady_clock;
  enum class Style { terminal, plain, json, none };

  [[nodiscard]] ProgressState state_at(Clock::time_point now) const;
  void show(Clock::time_point now);
  void note_interruption();

  Console& console_;
  Style style_;
  ProgressContext context_;
  std::mutex mutex_; // reports come from worker threads
  ProgressSnapshot last_;
  Clock::time_point phase_start_;
  double done_before_ = 0.0;
  Clock::time_point shown_;
  std::optional<Clock::time_point> textures_start_;
  std::optional<FrameState> frame_;
  Clock::time_point frame_start_;
  size_t frames_done_ = 0;
  double frames_done_s_ = 0.0;
  std::set<std::string, std::less<>> warnings_; // printed for earlier frames
  bool interruption_noted_ = false;
  bool phase_running_ = false;
};

} // namespace kindling::app
