// Sets the rows of a device beside the fastest rows of the others.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_devices.h"

#include "renderer/app/shootout/shootout_summary.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {
namespace {

std::optional<double> mean_of(const std::vector<DeviceComparisonLine>& lines, size_t rival) {
  std::vector<double> ratios;
  for (const DeviceComparisonLine& line : lines)
    if (line.ratios[rival]) ratios.push_back(*line.ratios[rival]);
  if (ratios.empty()) return std::nullopt;
  return geometric_mean(ratios);
}

std::string rate(double mega_rays, const Summary& time_s) {
  if (!(time_s.median > 0.0)) return "n/a";
  return fmt::format("{:.3f} ±{:.0f}%", mega_rays / time_s.median, time_s.spread_percent() / 2);
}

} // namespace

std::optional<DeviceComparison> compare_device(const SceneResult& scene) {
  const auto found = std::find_if(scene.accelerators.begin(), scene.accelerators.end(),
                                  [](const AcceleratorResult& a) { return a.device && a.fault.empty(); });
  if (found == scene.accelerators.end()) return std::nullopt;
  DeviceComparison comparison{
      found->name(), found->device->name, found->device->tree_bytes, found->device->check, {}, {}, {}};
  std::vector<const AcceleratorResult*> rivals;
  for (const AcceleratorResult& other : scene.accelerators)
    if (!other.device && other.fault.empty()) {
      rivals.push_back(&other);
      comparison.rivals.push_back(other.name());
    }
  for (size_t set = 0; set < scene.sets.size(); ++set) {
    const TraversalResult* launch = fastest_row(*found, set, CallForm::launch);
    const TraversalResult* with_copies = fastest_row(*found, set, CallForm::launch_with_copies);
    if (launch == nullptr || with_copies == nullptr) continue;
    DeviceComparisonLine& line = comparison.lines.emplace_back();
    line.rays = scene.sets[set].name;
    line.launch_s = summarize(launch->times_s);
    line.with_copies_s = summarize(with_copies->times_s);
    line.mega_rays = static_cast<double>(scene.sets[set].ray_count) * 1e-6;
    for (const AcceleratorResult* rival : rivals) {
      const TraversalResult* theirs = fastest_row(*rival, set, std::nullopt);
      line.ratios.push_back(theirs != nullptr ? std::optional(speed_ratio(theirs->times_s, launch->times_s))
                                              : std::nullopt);
    }
  }
  for (size_t rival = 0; rival < rivals.size(); ++rival) comparison.means.push_back(mean_of(comparison.lines, rival));
  return comparison;
}

DeviceTable tabulate(const DeviceComparison& comparison) {
  DeviceTable table;
  table.heading = {"rays", "launch", "with copies"};
  for (const std::string& rival : comparison.rivals) table.heading.push_back("to " + rival);
  for (const DeviceComparisonLine& line : comparison.lines) {
    std::vector<std::string>& row = table.rows.emplace_back();
    row = {line.rays, rate(line.mega_rays, line.launch_s), rate(line.mega_rays, line.with_copies_s)};
    for (const auto& ratio : line.ratios) row.push_back(format_ratio(ratio));
  }
  std::vector<std::string>& means = table.rows.emplace_back(std::vector<std::string>{"geometric mean", "", ""});
  for (const auto& mean : comparison.means) means.push_back(format_ratio(mean));
  return table;
}

std::string describe_check(const DeviceComparison& comparison) {
  return fmt::format("{} of its memory; {} of {} answers differ from those of the tree on the processor",
                     format_bytes(comparison.tree_bytes), comparison.check.disagreements.total(),
                     comparison.check.ray_count);
}

std::string format_device_table(const SceneResult& scene) {
  const std::optional<DeviceComparison> comparison = compare_device(scene);
  if (!comparison) return {};
  const DeviceTable cells = tabulate(*comparison);
  std::vector<TextTable::Column> columns;
  for (const std::string& name : cells.heading) columns.push_back({name, !columns.empty()});
  TextTable table(columns);
  for (const std::vector<std::string>& row : cells.rows) table.add(row);
  return fmt::format("\n{} ({}): all rays of a kind in one launch, million rays/s of wall time, and the ratio of the "
                     "launch to the fastest call on one thread\n{}  {}\n",
                     comparison->contender, printable(comparison->device), table.str(), describe_check(*comparison));
}

} // namespace kindling::app
