// Formats the contents of an accumulation file as a table and as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/info/accumulation_info.h"
#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kindling::app {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMaxKinds = 8; // rows of coverage in the table
constexpr size_t kMaxSpans = 4; // per row

std::string time_text(int64_t seconds) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::string rect_text(const PixelRect& rect) {
  return fmt::format("{},{},{},{}", rect.min.x, rect.min.y, rect.max.x, rect.max.y);
}

bool same(const PixelRect& a, const PixelRect& b) { return a.min == b.min && a.max == b.max; }

std::string size_text(const AccumulationSummary& summary) {
  const AccumulationIdentity& identity = summary.identity;
  std::string text = fmt::format("{}x{} pixels", identity.size_px.x, identity.size_px.y);
  if (!same(identity.crop, {V2i(0), identity.size_px})) text += ", crop " + rect_text(identity.crop);
  if (!same(summary.coverage.area(), identity.crop)) text += ", in this file " + rect_text(summary.coverage.area());
  return text;
}

std::string part_text(const AccumulationInfo& info) {
  std::string text;
  if (info.part.samples) text = part_number_text(*info.part.samples) + " of the samples";
  if (info.part.tiles)
    text += (text.empty() ? "" : ", ") + fmt::format("{} of the pixels", part_number_text(*info.part.tiles));
  return text;
}

std::string samples_text(const AccumulationInfo& info) {
  const AccumulationIdentity& identity = info.summary.identity;
  std::string text = fmt::format("{:.4g} of {} per pixel, {:.1f} %", info.mean_samples,
                                 identity.part.empty() ? 0 : identity.part.count(), 100.0 * info.done_share);
  if (identity.part != SampleRange{0, identity.samples_per_pixel})
    text += fmt::format("; {} to {} of {}", identity.part.first, identity.part.end, identity.samples_per_pixel);
  if (identity.planned_samples != identity.samples_per_pixel)
    text += fmt::format("; planned for {}", identity.planned_samples);
  return text;
}

std::string spans_text(const BlockCoverage& samples) {
  std::string text;
  for (size_t i = 0; i < std::min(samples.spans.size(), kMaxSpans); ++i)
    text += fmt::format("{}{} to {}", i == 0 ? "" : ", ", samples.spans[i].first, samples.spans[i].end);
  if (samples.spans.size() > kMaxSpans) text += fmt::format(" and {} more", samples.spans.size() - kMaxSpans);
  if (samples.spans.empty()) text = "none";
  return text + (samples.stopped ? ", converged" : "");
}

std::string coverage_table(const AccumulationInfo& info) {
  TextTable table({{"samples"}, {"pixels", true}});
  uint64_t others = 0;
  for (size_t i = 0; i < info.coverage.size(); ++i)
    if (i < kMaxKinds || info.coverage.size() == kMaxKinds + 1)
      table.add({spans_text(info.coverage[i].samples), fmt::format("{}", info.coverage[i].pixels)});
    else
      others += info.coverage[i].pixels;
  if (others > 0) table.add({fmt::format("{} others", info.coverage.size() - kMaxKinds), fmt::format("{}", others)});
  return table.empty() ? std::string() : "\ncoverage\n" + table.str();
}

std::string settings_table(const AccumulationInfo& info) {
  TextTable table({{"setting"}, {"value"}});
  const Json settings = Json::parse(info.summary.identity.image, nullptr, false);
  if (!settings.is_object()) return {};
  for (const auto& [key, value] : settings.items())
    if (!value.is_null())
      table.add({key, value.is_string() ? value.get<std::string>()
                                        : value.dump(-1, ' ', false, Json::error_handler_t::replace)});
  return table.empty() ? std::string() : "\nsettings\n" + table.str();
}

std::string previous_text(const std::optional<AccumulationInfo::Previous>& previous) {
  if (!previous) return "none";
  if (previous->damage) return fmt::format("damaged: {}", *previous->damage);
  return fmt::format("{}: {:.4g} samples per pixel, saved {}", previous->file.string(), previous->mean_samples,
                     time_text(previous->saved_s));
}

} // namespace

std::string format_accumulation_table(const AccumulationInfo& info) {
  const AccumulationSummary& summary = info.summary;
  const AccumulationIdentity& identity = summary.identity;
  std::string text = printable(info.file.string()) + "\n";
  const auto add = [&](std::string_view name, std::string_view value) {
    if (!value.empty()) text += fmt::format("  {:<12}{}\n", name, printable(value));
  };
  add("scene", info.scene_file.empty() ? "unknown: this program cannot parse the command" : info.scene_file.string());
  add("scene hash", format_hash(identity.scene_hash));
  add("program", identity.program + (identity.program == program_identity() ? "" : ", not this program"));
  add("size", size_text(summary));
  add("part", part_text(info));
  add("samples", samples_text(info));
  add("work",
      fmt::format("{} by {} process{}, {} rays", format_seconds(summary.work.render_s), summary.work.runs,
                  summary.work.runs == 1 ? "" : "es", format_count(static_cast<double>(summary.work.rays.total()))));
  if (const std::optional<float>& chosen = summary.work.light_paths)
    add("light paths", *chosen > 0.0f ? fmt::format("for {:g} of the samples, chosen", *chosen) : "none, chosen");
  if (const std::optional<float>& chosen = summary.work.photons)
    add("photons", *chosen > 0.0f ? fmt::format("{:g} for each sample of a pixel, chosen", *chosen) : "none, chosen");
  if (const std::optional<int>& chosen = summary.work.direct_samples)
    add("light samples", fmt::format("{} at the first surface, chosen", *chosen));
  if (const std::optional<int>& chosen = summary.work.reflection_samples)
    add("reflections", *chosen > 0 ? fmt::format("{} samples at the first surface, chosen", *chosen) : "none, chosen");
  if (const std::optional<int>& chosen = summary.work.path_reuse)
    add("path reuse", *chosen > 1 ? fmt::format("between {} pixels, chosen", *chosen) : "none, chosen");
  if (const std::optional<RateRule>& rule = summary.work.rate_rule)
    add("sample rates", rule->kind() == SampleRateKind::noise ? "by noise, chosen" : "even, chosen");
  if (summary.work.rays.non_finite > 0)
    add("dropped", fmt::format("{} samples that were not finite", summary.work.rays.non_finite));
  add("memory", fmt::format("{}, in this file {}", format_bytes(summary.sum_bytes), format_bytes(info.file_bytes)));
  add("saved", time_text(info.saved_s));
  add("previous", previous_text(info.previous));
  add("checksums", info.damage ? "wrong: " + *info.damage : "correct");
  std::string command = "kindling";
  for (const std::string& argument : identity.arguments) command += ' ' + shell_quote(argument);
  add("command", command);
  add("folder", identity.folder.string());
  return text + coverage_table(info) + settings_table(info);
}

std::string format_accumulation_json(const AccumulationInfo& info) {
  const AccumulationSummary& summary = info.summary;
  const AccumulationIdentity& identity = summary.identity;
  const auto rect = [](const PixelRect& r) { return Json{r.min.x, r.min.y, r.max.x, r.max.y}; };
  const auto text_or_null = [](const std::optional<std::string>& text) { return text ? Json(*text) : Json(); };
  Json json;
  json["file"] = info.file.string();
  json["file_bytes"] = info.file_bytes;
  json["saved"] = time_text(info.saved_s);
  json["sound"] = !info.damage;
  json["damage"] = text_or_null(info.damage);
  json["previous"] = nullptr;
  if (const auto& previous = info.previous)
    json["previous"] = {{"file", previous->file.string()},
                        {"saved", time_text(previous->saved_s)},
                        {"sound", !previous->damage},
                        {"damage", text_or_null(previous->damage)},
                        {"spp_mean", previous->damage ? Json() : Json(previous->mean_samples)}};
  json["program"] = identity.program;
  json["same_program"] = identity.program == program_identity();
  json["scene"] = info.scene_file.empty() ? Json() : Json(info.scene_file.string());
  json["scene_hash"] = format_hash(identity.scene_hash);
  json["folder"] = identity.folder.string();
  json["arguments"] = identity.arguments;
  json["width"] = identity.size_px.x;
  json["height"] = identity.size_px.y;
  json["crop"] = rect(identity.crop);
  json["area"] = rect(summary.coverage.area());
  json["part"] = info.part.samples ? Json(part_number_text(*info.part.samples)) : Json();
  json["tile_part"] = info.part.tiles ? Json(part_number_text(*info.part.tiles)) : Json();
  json["samples"] = {identity.part.first, identity.part.end};
  json["spp_wanted"] = identity.samples_per_pixel;
  json["spp_planned"] = identity.planned_samples;
  json["spp_mean"] = info.mean_samples;
  json["done_share"] = info.done_share;
  json["coverage"] = Json::array();
  for (const CoverageKind& kind : info.coverage) {
    Json spans = Json::array();
    for (const SampleRange& span : kind.samples.spans) spans.push_back({span.first, span.end});
    json["coverage"].push_back({{"samples", spans}, {"suffice", kind.samples.stopped}, {"pixels", kind.pixels}});
  }
  json["work"] = {{"render_s", summary.work.render_s},
                  {"thread_s", summary.work.thread_s},
                  {"runs", summary.work.runs},
                  {"rays", summary.work.rays.total()},
                  {"non_finite_samples", summary.work.rays.non_finite}};
  json["light_paths"] = summary.work.light_paths ? Json(*summary.work.light_paths) : Json();
  json["photons"] = summary.work.photons ? Json(*summary.work.photons) : Json();
  json["direct_samples"] = summary.work.direct_samples ? Json(*summary.work.direct_samples) : Json();
  json["reflection_samples"] = summary.work.reflection_samples ? Json(*summary.work.reflection_samples) : Json();
  json["path_reuse"] = summary.work.path_reuse ? Json(*summary.work.path_reuse) : Json();
  json["sample_rates"] = summary.work.rate_rule ? Json(sample_rates_name(summary.work.rate_rule->kind())) : Json();
  json["memory_bytes"] = summary.sum_bytes;
  const Json settings = Json::parse(identity.image, nullptr, false);
  json["settings"] = settings.is_object() ? settings : Json();
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace kindling::app
