// Reads an accumulation file and its previous generation, and checks both.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/info/accumulation_info.h"

#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/options/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include <sys/stat.h>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

int64_t saved_s(const fs::path& file) {
  struct stat status {};
  return stat(file.c_str(), &status) == 0 ? int64_t{status.st_mtime} : 0;
}

std::vector<CoverageKind> kinds_of(const Coverage& coverage) {
  const auto before = [](const BlockCoverage* a, const BlockCoverage* b) {
    const auto earlier = [](const SampleRange& x, const SampleRange& y) {
      return std::pair(x.first, x.end) < std::pair(y.first, y.end);
    };
    if (a->stopped != b->stopped) return b->stopped;
    return std::lexicographical_compare(a->spans.begin(), a->spans.end(), b->spans.begin(), b->spans.end(), earlier);
  };
  std::map<const BlockCoverage*, uint64_t, decltype(before)> pixels(before);
  for (size_t i = 0; i < coverage.block_count(); ++i)
    pixels[&coverage[i]] += static_cast<uint64_t>(coverage.block(i).pixel_count());
  std::vector<CoverageKind> kinds;
  for (const auto& [samples, count] : pixels) kinds.push_back({*samples, count});
  std::stable_sort(kinds.begin(), kinds.end(),
                   [](const CoverageKind& a, const CoverageKind& b) { return a.pixels > b.pixels; });
  return kinds;
}

double mean_samples(const std::vector<CoverageKind>& kinds) {
  double samples = 0.0, pixels = 0.0;
  for (const CoverageKind& kind : kinds) {
    for (const SampleRange& span : kind.samples.spans)
      samples += static_cast<double>(span.count()) * static_cast<double>(kind.pixels);
    pixels += static_cast<double>(kind.pixels);
  }
  return pixels > 0.0 ? samples / pixels : 0.0;
}

std::optional<std::string> damage_of(const fs::path& file) {
  const Result<void> checked = check_accumulation(file);
  return checked.ok() ? std::nullopt : std::optional(checked.error().message);
}

std::optional<AccumulationInfo::Previous> previous_of(const fs::path& file) {
  AccumulationInfo::Previous previous;
  previous.file = previous_accumulation(file);
  std::error_code ignored;
  if (!fs::exists(previous.file, ignored)) return std::nullopt;
  previous.saved_s = saved_s(previous.file);
  const Result<AccumulationSummary> summary = read_accumulation_summary(previous.file);
  if (summary.ok()) {
    previous.mean_samples = mean_samples(kinds_of(summary.value().coverage));
    previous.damage = damage_of(previous.file);
  } else {
    previous.damage = summary.error().message;
  }
  return previous;
}

fs::path scene_of(const AccumulationIdentity& identity) {
  std::vector<const char*> words;
  for (const std::string& argument : identity.arguments) words.push_back(argument.c_str());
  const Result<CommandLine> line = parse_command_line(words);
  const auto* render = line.ok() ? std::get_if<RenderOptions>(&line.value().command) : nullptr;
  return render != nullptr ? render->scene_file : fs::path();
}

} // namespace

Result<AccumulationInfo> collect_accumulation_info(const fs::path& file) {
  AccumulationInfo info;
  info.file = file;
  info.previous = previous_of(file);
  Result<AccumulationSummary> summary = read_accumulation_summary(file);
  if (!summary.ok()) {
    if (!info.previous || info.previous->damage) return summary.error();
    return Error{summary.error().kind,
                 fmt::format("{}; {} can be read: it has {:.1f} samples per pixel", summary.error().message,
                             info.previous->file.string(), info.previous->mean_samples)};
  }
  info.summary = std::move(summary).value();
  info.damage = damage_of(file);
  std::error_code ignored;
  info.file_bytes = fs::file_size(file, ignored);
  info.saved_s = saved_s(file);
  info.scene_file = scene_of(info.summary.identity);
  info.part = part_of_arguments(info.summary.identity.arguments);
  info.coverage = kinds_of(info.summary.coverage);
  info.mean_samples = mean_samples(info.coverage);
  info.done_share = info.summary.coverage.done_share(info.summary.identity.part);
  return info;
}

} // namespace kindling::app
