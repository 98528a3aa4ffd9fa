// Builds progress lines from parts that fit the width.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/terminal/progress_format.h"

#include "renderer/app/text/text_format.h"
#include "renderer/base/phase_name.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace kindling::app {

namespace {

std::string format_samples(const ProgressState& state) {
  // Rounded down, so that 64 of 64 means finished.
  const bool whole = state.samples_per_pixel >= 10.0 || state.samples_per_pixel == std::floor(state.samples_per_pixel);
  const std::string done = whole ? fmt::format("{:.0f}", std::floor(state.samples_per_pixel))
                                 : fmt::format("{:.1f}", std::floor(state.samples_per_pixel * 10.0) / 10.0);
  return state.spp_wanted ? fmt::format("{}/{} spp", done, *state.spp_wanted) : fmt::format("{} spp", done);
}

std::string format_ray_rate(double rays_per_s) {
  // "12.3 M" + "rays/s", "812" + " rays/s"
  const std::string rate = format_count(rays_per_s);
  return rate + (rate.find(' ') == std::string::npos ? " rays/s" : "rays/s");
}

// The parts after the bar and the percentage, the most important first.
std::vector<std::string> status_parts(const ProgressState& state) {
  std::vector<std::string> parts;
  if (state.phase == Phase::render) parts.push_back(format_samples(state));
  // Rounded down, so that 100% means all.
  if (state.converged) parts.push_back(fmt::format("{:.0f}% converged", std::floor(100.0 * *state.converged)));
  if (state.remaining_s) parts.push_back(format_seconds(*state.remaining_s) + " left");
  if (state.frame && state.frame->remaining_s) parts.push_back(format_seconds(*state.frame->remaining_s) + " for all");
  if (state.phase == Phase::render) parts.push_back(format_ray_rate(state.rays_per_s));
  parts.push_back(format_seconds(state.elapsed_s) + " elapsed");
  if (state.resident_bytes > 0) parts.push_back(format_bytes(state.resident_bytes));
  return parts;
}

double clamp_fraction(double fraction) { return std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0; }

} // namespace

std::optional<double> remaining_seconds(double fraction, double phase_elapsed_s) {
  if (!(fraction >= 0.02) || phase_elapsed_s < 0.5) return std::nullopt;
  return phase_elapsed_s * (1.0 - std::min(fraction, 1.0)) / fraction;
}

std::optional<double> remaining_seconds_of_frames(size_t done, double done_s, size_t left, double elapsed_s,
                                                  std::optional<double> remaining_s) {
  if (done == 0 && !remaining_s) return std::nullopt;
  const double frame_s = done > 0 ? done_s / static_cast<double>(done) : elapsed_s + *remaining_s;
  return remaining_s.value_or(std::max(frame_s - elapsed_s, 0.0)) + frame_s * static_cast<double>(left);
}

std::string format_status_line(const ProgressState& state, int columns) {
  constexpr int kWidestBar = 30;
  constexpr int kNarrowestBar = 8;
  const double fraction = clamp_fraction(state.fraction);
  const auto width = static_cast<size_t>(std::max(columns - 1, 0)); // the last column would wrap on some terminals
  std::string line = state.frame ? fmt::format("{}/{} ", state.frame->index, state.frame->count) : "";
  line += fmt::format("{:<8} ", phase_name(state.phase));
  const int bar = std::clamp(columns / 5, kNarrowestBar, kWidestBar);
  const std::string percent = fmt::format("{:5.1f}%", 100.0 * fraction);
  if (line.size() + static_cast<size_t>(bar) + 3 + percent.size() <= width) {
    const int filled = static_cast<int>(fraction * bar);
    line += '[' + std::string(static_cast<size_t>(filled), '#') + std::string(static_cast<size_t>(bar - filled), '-') +
            "] ";
  }
  line = (line + percent).substr(0, width);
  for (const std::string& part : status_parts(state)) {
    if (line.size() + 2 + part.size() > width) break;
    line += "  " + part;
  }
  return line;
}

std::string format_plain_line(const ProgressState& state) {
  std::string line =
      state.frame ? fmt::format("frame {} ({} of {}): ", state.frame->number, state.frame->index, state.frame->count)
                  : "";
  line += fmt::format("{} {:.0f}%", phase_name(state.phase), 100.0 * clamp_fraction(state.fraction));
  const char* separator = " ";
  for (const std::string& part : status_parts(state)) {
    line += separator + part;
    separator = ", ";
  }
  return line;
}

std::string format_json_line(const ProgressState& state) {
  nlohmann::ordered_json object;
  object["event"] = "progress";
  object["phase"] = phase_name(state.phase);
  object["fraction"] = clamp_fraction(state.fraction);
  const bool rendering = state.phase == Phase::render;
  object["spp"] = rendering ? nlohmann::ordered_json(state.samples_per_pixel) : nlohmann::ordered_json();
  object["spp_wanted"] = state.spp_wanted ? nlohmann::ordered_json(*state.spp_wanted) : nlohmann::ordered_json();
  object["converged"] = state.converged ? nlohmann::ordered_json(*state.converged) : nlohmann::ordered_json();
  object["rays"] = state.rays;
  object["rays_per_s"] = state.rays_per_s;
  object["elapsed_s"] = state.elapsed_s;
  object["remaining_s"] = state.remaining_s ? nlohmann::ordered_json(*state.remaining_s) : nlohmann::ordered_json();
  object["rss_bytes"] = state.resident_bytes;
  if (const std::optional<FrameState>& frame = state.frame) {
    object["frame"] = frame->number;
    object["frame_index"] = frame->index;
    object["frame_count"] = frame->count;
    object["frames_remaining_s"] =
        frame->remaining_s ? nlohmann::ordered_json(*frame->remaining_s) : nlohmann::ordered_json();
  }
  return object.dump();
}

} // namespace kindling::app
