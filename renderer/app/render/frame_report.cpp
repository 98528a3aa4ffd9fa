// Formats reports on frames as text and JSON.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/frame_report.h"

#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace kindling::app {

namespace {

std::string frames(size_t count) { return fmt::format("{} frame{}", count, count == 1 ? "" : "s"); }

} // namespace

std::string format_frame_numbers(const std::vector<int>& numbers) {
  std::string text;
  for (size_t i = 0; i < numbers.size();) {
    size_t end = i + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    text += (i > 0 ? ", " : "") + fmt::format("{}", numbers[i]);
    if (end - i > 1) text += (end - i > 2 ? "-" : ", ") + fmt::format("{}", numbers[end - 1]);
    i = end;
  }
  return text;
}

std::string format_frame_line(const RenderReport& r, size_t index, size_t count) {
  const PhaseTimes& t = r.times;
  return fmt::format(
      "frame {} ({} of {}){}: {}: build {}, render {}, write {}", r.frame.value_or(0), index, count,
      r.interrupted ? fmt::format(" interrupted at {} of {} spp", r.statistics.samples_per_pixel, r.spp_wanted) : "",
      format_seconds(t.total_s), format_seconds(t.build_s), format_seconds(t.render_s), format_seconds(t.write_s));
}

std::string format_frames_summary(const FramesReport& r) {
  std::string text =
      fmt::format("rendered {} of {} in {}", r.rendered.size(), frames(r.wanted), format_seconds(r.total_s));
  if (!r.rendered.empty()) text += ": " + format_frame_numbers(r.rendered);
  if (!r.skipped.empty())
    text += fmt::format("\n  skipped {} that {} there: {}", frames(r.skipped.size()),
                        r.skipped.size() == 1 ? "was" : "were", format_frame_numbers(r.skipped));
  if (r.rendered.empty()) return text;
  const double count = static_cast<double>(r.rendered.size());
  const PhaseTimes& t = r.phases;
  text += fmt::format("\n  time    load {} once; of a frame: build {}, render {}, write {}", format_seconds(r.load_s),
                      format_seconds(t.build_s / count), format_seconds(t.render_s / count),
                      format_seconds(t.write_s / count));
  return text;
}

std::string format_frames_json(const FramesReport& r, bool one_line) {
  nlohmann::ordered_json json;
  if (one_line) json["event"] = "frames";
  json["version"] = version();
  json["command_line"] = r.command_line;
  json["wanted"] = r.wanted;
  json["rendered"] = r.rendered;
  json["skipped"] = r.skipped;
  json["exit_code"] = r.exit_code;
  json["phases"] = {
      {"load", r.load_s}, {"build", r.phases.build_s}, {"render", r.phases.render_s}, {"write", r.phases.write_s}};
  json["total_s"] = r.total_s;
  if (!one_line) {
    json["frames"] = nlohmann::ordered_json::array();
    for (const std::string& frame : r.statistics) json["frames"].push_back(nlohmann::ordered_json::parse(frame));
  }
  return json.dump(one_line ? -1 : 2, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace kindling::app
