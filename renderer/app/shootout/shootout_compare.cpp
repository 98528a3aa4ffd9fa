// Finds the rows that two reports share, and formats their ratios.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_compare.h"

#include "renderer/app/measure/measurement.h"
#include "renderer/app/text/text_format.h"
#include "renderer/base/text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

namespace kindling::app {

namespace {

using ReportJson = nlohmann::json;

constexpr uint64_t kMaxBytes = uint64_t{64} << 20;

Error no_report(const std::string& name, const std::string& why) {
  return {ErrorKind::input_output, fmt::format("{}: {}; a file of 'kindling shootout --json' is needed", name, why)};
}

// Parses a report and checks what is read of it below.
Result<ReportJson> parse_report(const std::string& name, const std::string& text) {
  ReportJson report = ReportJson::parse(text, nullptr, false);
  if (report.is_discarded() || !report.is_object()) return no_report(name, "is no JSON object");
  const auto scenes = report.find("scenes");
  if (scenes == report.end() || !scenes->is_array()) return no_report(name, "has no list 'scenes'");
  for (const ReportJson& scene : *scenes) {
    if (!scene.is_object() || !scene.contains("file") || !scene["file"].is_string() ||
        !scene.contains("accelerators") || !scene["accelerators"].is_array())
      return no_report(name, "has a scene without 'file' or 'accelerators'");
    for (const ReportJson& accelerator : scene["accelerators"])
      if (!accelerator.is_object() || !accelerator.contains("name") || !accelerator["name"].is_string() ||
          !accelerator.contains("traversal") || !accelerator["traversal"].is_array())
        return no_report(name, "has an accelerator without 'name' or 'traversal'");
  }
  return report;
}

// "-" for what is missing, or is a list.
std::string text_of(const ReportJson& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null() || found->is_structured()) return "-";
  const std::string text = found->is_string() ? found->get<std::string>() : found->dump();
  return text.empty() ? "-" : printable(text);
}

double number_of(const ReportJson& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

// What makes figures differ beside the machine.
std::string difference_lines(const ReportJson& first, const ReportJson& second) {
  std::string text;
  for (const char* key :
       {"processor", "version", "compiler", "clock", "build_threads", "repeat", "build_repeat", "batch_size"}) {
    const std::string a = text_of(first, key), b = text_of(second, key);
    if (a != b) text += fmt::format("  {}: {} | {}\n", key, a, b);
  }
  return text.empty() ? "  processor, version, compiler and settings are the same\n" : text;
}

std::string scene_key(const ReportJson& scene) {
  return std::filesystem::path(text_of(scene, "file")).filename().string();
}

// The scene of the same file, or of the same name of a file in another folder.
const ReportJson* find_scene(const ReportJson& scenes, const ReportJson& wanted) {
  for (const bool whole : {true, false})
    for (const ReportJson& scene : scenes)
      if (whole ? text_of(scene, "file") == text_of(wanted, "file") : scene_key(scene) == scene_key(wanted))
        return &scene;
  return nullptr;
}

const ReportJson* find_by(const ReportJson& list, const char* key, const std::string& value) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const ReportJson& entry) {
    return entry.is_object() && text_of(entry, key) == value;
  });
  return found == list.end() ? nullptr : &*found;
}

const ReportJson* find_row(const ReportJson& traversal, const ReportJson& wanted) {
  const auto found = std::find_if(traversal.begin(), traversal.end(), [&](const ReportJson& row) {
    return row.is_object() && text_of(row, "rays") == text_of(wanted, "rays") &&
           text_of(row, "call") == text_of(wanted, "call");
  });
  return found == traversal.end() ? nullptr : &*found;
}

std::string ratio_cell(double ratio) { return ratio > 0.0 ? fmt::format("{:.2f}x", ratio) : "-"; }

// One accelerator in both reports.
struct Pair {
  std::string name;
  const ReportJson* first;
  const ReportJson* second;
};

// The second time over the first one, both positive.
double time_ratio(const Pair& pair, const char* threads) {
  const auto median_of = [&](const ReportJson& accelerator) {
    const auto build = accelerator.find("build");
    if (build == accelerator.end() || !build->is_object() || !build->contains(threads)) return 0.0;
    return (*build)[threads].is_object() ? number_of((*build)[threads], "median_s") : 0.0;
  };
  const double a = median_of(*pair.first), b = median_of(*pair.second);
  return a > 0.0 && b > 0.0 ? b / a : 0.0;
}

// The kinds of rays and calls of all accelerators, those of the first one first: Embree and devices
// have calls of their own.
std::vector<const ReportJson*> rows_of(const std::vector<Pair>& pairs) {
  std::vector<const ReportJson*> rows;
  for (const Pair& pair : pairs)
    for (const ReportJson& row : (*pair.first)["traversal"]) {
      if (!row.is_object()) continue;
      const bool known = std::any_of(rows.begin(), rows.end(), [&](const ReportJson* other) {
        return text_of(*other, "rays") == text_of(row, "rays") && text_of(*other, "call") == text_of(row, "call");
      });
      if (!known) rows.push_back(&row);
    }
  return rows;
}

// Ratios of speeds, with "~" where the rounds of either report differ by more than the ratio.
std::string speed_table(const std::vector<Pair>& pairs) {
  std::vector<TextTable::Column> columns{{"rays"}, {"call"}};
  for (const Pair& pair : pairs) columns.push_back({pair.name, true});
  TextTable table(columns);
  std::vector<std::vector<double>> all(pairs.size());
  for (const ReportJson* shown : rows_of(pairs)) {
    const ReportJson& row = *shown;
    std::vector<std::string> cells{text_of(row, "rays"), text_of(row, "call")};
    for (size_t p = 0; p < pairs.size(); ++p) {
      const ReportJson* a = find_row((*pairs[p].first)["traversal"], row);
      const ReportJson* b = find_row((*pairs[p].second)["traversal"], row);
      const double before = a ? number_of(*a, "mega_rays_per_s") : 0.0,
                   after = b ? number_of(*b, "mega_rays_per_s") : 0.0;
      const double ratio = before > 0.0 && after > 0.0 ? after / before : 0.0;
      if (ratio > 0.0) all[p].push_back(ratio);
      const double noise =
          ratio > 0.0 ? std::max(number_of(*a, "spread_percent"), number_of(*b, "spread_percent")) / 200.0 : 0.0;
      const double change = ratio > 0.0 ? std::max(ratio, 1.0 / ratio) - 1.0 : 0.0;
      cells.push_back(ratio_cell(ratio) + (ratio > 0.0 && change <= noise ? " ~" : "  "));
    }
    table.add(cells);
  }
  const auto add_mean = [&](const char* name, const char* call, const auto& value) {
    std::vector<std::string> cells{name, call};
    for (size_t p = 0; p < pairs.size(); ++p) cells.push_back(ratio_cell(value(p)) + "  ");
    table.add(cells);
  };
  add_mean("geometric mean", "", [&](size_t p) { return geometric_mean(all[p]); });
  add_mean("build time", "1 thread", [&](size_t p) { return time_ratio(pairs[p], "one_thread"); });
  add_mean("build time", "all threads", [&](size_t p) { return time_ratio(pairs[p], "many_threads"); });
  return table.str();
}

} // namespace

Result<std::string> compare_shootouts(const std::string& first_name, const std::string& first_json,
                                      const std::string& second_name, const std::string& second_json) {
  const Result<ReportJson> first = parse_report(first_name, first_json),
                           second = parse_report(second_name, second_json);
  if (!first.ok()) return first.error();
  if (!second.ok()) return second.error();
  std::string text =
      fmt::format("{} | {}\n{}", first_name, second_name, difference_lines(first.value(), second.value()));
  size_t compared = 0;
  for (const ReportJson& scene : first.value()["scenes"]) {
    const ReportJson* other = find_scene(second.value()["scenes"], scene);
    text += "\n" + scene_key(scene) + "\n";
    if (other == nullptr) {
      text += fmt::format("  is not in {}\n", second_name);
      continue;
    }
    if (text_of(scene, "geometry_hash") != text_of(*other, "geometry_hash"))
      text += fmt::format("  the geometry differs ({} | {}): ratios mean little\n", text_of(scene, "geometry_hash"),
                          text_of(*other, "geometry_hash"));
    for (const auto& [name, one] : {std::pair(first_name, &scene), std::pair(second_name, other)})
      if (text_of(*one, "warning") != "-") text += fmt::format("  {}: {}\n", name, text_of(*one, "warning"));
    std::vector<Pair> pairs;
    for (const ReportJson& accelerator : scene["accelerators"]) {
      const std::string name = text_of(accelerator, "name");
      if (const ReportJson* same = find_by((*other)["accelerators"], "name", name))
        pairs.push_back({name, &accelerator, same});
      else
        text += fmt::format("  {} is not in {}\n", name, second_name);
    }
    for (const ReportJson& accelerator : (*other)["accelerators"])
      if (const std::string name = text_of(accelerator, "name"); !find_by(scene["accelerators"], "name", name))
        text += fmt::format("  {} is not in {}\n", name, first_name);
    if (pairs.empty()) continue;
    ++compared;
    text +=
        fmt::format("  speed of {} over {} (build times: above 1 is slower); ~: within the spread of the rounds\n{}",
                    second_name, first_name, speed_table(pairs));
  }
  for (const ReportJson& scene : second.value()["scenes"])
    if (!find_scene(first.value()["scenes"], scene))
      text += fmt::format("\n{}\n  is not in {}\n", scene_key(scene), first_name);
  if (compared == 0)
    return Error{ErrorKind::input_output,
                 fmt::format("{} and {}: no scene with the same accelerator is in both", first_name, second_name)};
  return text;
}

Result<std::string> compare_shootout_files(const std::filesystem::path& first, const std::filesystem::path& second) {
  std::vector<std::string> texts;
  for (const std::filesystem::path& file : {first, second}) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(file, code)) // a pipe would block
      return no_report(file.string(), "cannot be read");
    std::ifstream stream(file, std::ios::binary);
    const uint64_t size = std::filesystem::file_size(file, code);
    if (!stream || code) return no_report(file.string(), "cannot be read");
    if (size > kMaxBytes) return no_report(file.string(), "has more than 64 MiB");
    texts.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return compare_shootouts(first.string(), texts[0], second.string(), texts[1]);
}

} // namespace kindling::app
