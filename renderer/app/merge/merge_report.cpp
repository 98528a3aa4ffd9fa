// Prints the plan of a merge, and formats its summary.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/merge/merge_report.h"

#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kindling::app {

namespace {

std::string files(size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

} // namespace

double MergeReport::missing_share() const {
  const double all = static_cast<double>(plan.identity.crop.pixel_count()) * plan.identity.samples_per_pixel;
  return all > 0.0 ? static_cast<double>(plan.gaps.missing_samples) / all : 0.0;
}

void report_plan(const MergePlan& plan, bool allow_missing, Console& console) {
  for (const LeftOut& file : plan.left_out)
    console.note(fmt::format("{}: {}: left out", file.file.string(), file.reason));
  for (const DuplicatePart& duplicate : plan.duplicates)
    console.note(fmt::format("{}: has the samples of {}: left out", duplicate.file.string(),
                             plan.parts[duplicate.same_as].string()));
  for (const std::string& line : plan.gaps.lines) {
    const std::string message = "missing: " + line;
    allow_missing ? console.warning(message) : console.note(message);
  }
  if (allow_missing && plan.gaps.empty_pixels > 0)
    console.warning(fmt::format("{} without any sample: black with alpha 0", files(plan.gaps.empty_pixels, "pixel")));
}

std::string format_merge_summary(const MergeReport& r) {
  const AccumulationIdentity& identity = r.plan.identity;
  std::string text = fmt::format("merged {}: {}x{} at {:g} spp", files(r.plan.parts.size(), "part"), identity.size_px.x,
                                 identity.size_px.y, r.mean_spp);
  if (!r.plan.gaps.none()) text += fmt::format(" of {}", identity.samples_per_pixel);
  text += fmt::format("\n  work    render {} by {}, {} rays\n", format_seconds(r.work.render_s),
                      fmt::format("{} process{}", r.work.runs, r.work.runs == 1 ? "" : "es"),
                      format_count(static_cast<double>(r.work.rays.total())));
  text += fmt::format("  time    check {}, merge {}, write {}; {} in all\n", format_seconds(r.check_s),
                      format_seconds(r.merge_s), format_seconds(r.write_s), format_seconds(r.total_s));
  text += fmt::format("  memory  peak {}: film {}", format_bytes(r.peak_resident_bytes), format_bytes(r.film_bytes));
  return text;
}

std::string format_merge_json(const MergeReport& r) {
  const AccumulationIdentity& identity = r.plan.identity;
  nlohmann::ordered_json json;
  json["version"] = version();
  json["program"] = identity.program;
  json["command_line"] = r.command_line;
  json["scene_hash"] = format_hash(identity.scene_hash);
  json["width"] = identity.size_px.x;
  json["height"] = identity.size_px.y;
  json["crop"] = {identity.crop.min.x, identity.crop.min.y, identity.crop.max.x, identity.crop.max.y};
  json["spp_wanted"] = identity.samples_per_pixel;
  json["spp_mean"] = r.mean_spp;
  json["parts"] = nlohmann::ordered_json::array();
  for (const auto& part : r.plan.parts) json["parts"].push_back(part.string());
  json["duplicates"] = nlohmann::ordered_json::array();
  for (const DuplicatePart& duplicate : r.plan.duplicates)
    json["duplicates"].push_back(
        {{"file", duplicate.file.string()}, {"same_as", r.plan.parts[duplicate.same_as].string()}});
  json["left_out"] = nlohmann::ordered_json::array();
  for (const LeftOut& file : r.plan.left_out)
    json["left_out"].push_back({{"file", file.file.string()}, {"reason", file.reason}});
  json["missing"] = r.plan.gaps.lines;
  json["missing_share"] = r.missing_share();
  json["empty_pixels"] = r.plan.gaps.empty_pixels;
  json["work"] = {{"render_s", r.work.render_s},
                  {"thread_s", r.work.thread_s},
                  {"runs", r.work.runs},
                  {"rays", r.work.rays.total()},
                  {"non_finite_samples", r.work.rays.non_finite}};
  json["phases"] = {{"check", r.check_s}, {"merge", r.merge_s}, {"write", r.write_s}};
  json["total_s"] = r.total_s;
  json["memory"] = {{"film_bytes", r.film_bytes}};
  json["peak_rss_bytes"] = r.peak_resident_bytes;
  json["outputs"] = r.outputs;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace kindling::app
