// Formats a shootout as tables, and derives the figures that all reports share.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_load.h"
#include "renderer/app/shootout/shootout_devices.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/shootout/shootout_summary.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <span>

namespace kindling::app {

namespace {

std::string or_dash(size_t count, const std::string& text) { return count > 0 ? text : "-"; }

std::string build_table(const ShootoutReport& report, const SceneResult& scene) {
  TextTable table({{"accelerator"},
                   {"build, 1 thread", true},
                   {fmt::format("{} thread{}", report.build_threads, report.build_threads == 1 ? "" : "s"), true},
                   {"kernels"},
                   {"memory", true},
                   {"at peak", true},
                   {"huge pages", true},
                   {"nodes", true},
                   {"leaves", true},
                   {"refs/leaf", true},
                   {"max", true},
                   {"refs/triangle", true}});
  for (const AcceleratorResult& accelerator : scene.accelerators) {
    const BuildResult& build = accelerator.build;
    const accel::Statistics& s = build.statistics;
    const auto ratio = [](size_t a, size_t b) {
      return a > 0 && b > 0 ? fmt::format("{:.2f}", static_cast<double>(a) / static_cast<double>(b)) : "-";
    };
    table.add({accelerator.name(), or_dash(build.one_thread_s.size(), format_short_time(median(build.one_thread_s))),
               or_dash(build.many_threads_s.size(), format_short_time(median(build.many_threads_s))),
               accelerator.plugin || accelerator.device ? "-" : std::string(accel::simd_target_name(s.simd)),
               or_dash(s.memory_bytes, format_bytes(s.memory_bytes)),
               build.peak_growth_bytes ? format_bytes(*build.peak_growth_bytes) : "-",
               or_dash(build.huge_page_bytes, format_bytes(build.huge_page_bytes)),
               or_dash(s.node_count, format_count(static_cast<double>(s.node_count))),
               or_dash(s.leaf_count, format_count(static_cast<double>(s.leaf_count))),
               ratio(s.reference_count, s.leaf_count),
               s.leaf_sizes.empty() ? "-" : fmt::format("{}", summarize_leaf_sizes(s.leaf_sizes).max),
               ratio(s.reference_count, s.triangle_count)});
  }
  return table.str();
}

std::string speed_cell(const RaySetInfo& set, const TraversalResult& result, bool with_ratio) {
  if (result.times_s.empty()) return "-";
  const Summary summary = summarize(result.times_s);
  if (!(summary.median > 0.0)) return "n/a";
  std::string text = fmt::format("{:.3f} ±{:.0f}%", mega_rays_per_s(set, summary.median), summary.spread_percent() / 2);
  if (with_ratio) text += "  " + format_ratio(result.ratio_to_first);
  return text;
}

std::string speed_table(const SceneResult& scene) {
  std::vector<TextTable::Column> columns{{"rays"}, {"call"}};
  std::vector<size_t> shown; // devices have a table of their own
  for (size_t a = 0; a < scene.accelerators.size(); ++a) {
    if (scene.accelerators[a].device) continue;
    shown.push_back(a);
    columns.push_back({scene.accelerators[a].name(), true});
  }
  TextTable table(columns);
  for (size_t row = 0; row < scene.accelerators.front().traversal.size(); ++row) {
    const TraversalResult& first = scene.accelerators.front().traversal[row];
    if (!every_accelerator_has(first.form)) continue;
    const RaySetInfo& set = scene.sets[first.set];
    std::vector<std::string> cells{set.name, std::string(call_form_name(first.form))};
    for (const size_t a : shown) cells.push_back(speed_cell(set, scene.accelerators[a].traversal[row], a > 0));
    table.add(cells);
  }
  if (shown.size() > 1) {
    const auto add_mean = [&](const std::string& call, std::optional<CallForm> form) {
      std::vector<std::string> cells{"geometric mean", call, ""};
      for (const size_t a : std::span(shown).subspan(1)) cells.push_back(format_ratio(mean_ratio(scene, a, form)));
      table.add(cells);
    };
    add_mean("single", CallForm::single);
    add_mean("batch", CallForm::batch);
    add_mean("best of each", std::nullopt);
  }
  return table.str();
}

// The cost of traversal, for accelerators that report it; empty if none does.
std::string cost_table(const SceneResult& scene) {
  TextTable table({{"accelerator"}, {"rays"}, {"nodes", true}, {"leaves", true}, {"triangles", true}});
  bool any = false;
  for (const AcceleratorResult& accelerator : scene.accelerators)
    for (size_t set = 0; set < accelerator.costs.size(); ++set) {
      const MeanCost& cost = accelerator.costs[set];
      if (scene.sets[set].ray_count == 0) continue;
      table.add({accelerator.name(), scene.sets[set].name, fmt::format("{:.2f}", cost.nodes),
                 fmt::format("{:.2f}", cost.leaves), fmt::format("{:.1f}", cost.triangles)});
      any = true;
    }
  return any ? "\nvisited per ray by single queries, means\n" + table.str() : std::string();
}

// Packets and streams, for accelerators that have them; empty if none does.
std::string embree_call_table(const SceneResult& scene) {
  std::vector<const AcceleratorResult*> embrees;
  for (const AcceleratorResult& accelerator : scene.accelerators)
    for (const TraversalResult& result : accelerator.traversal)
      if (is_embree_call(result.form) && !result.times_s.empty()) {
        embrees.push_back(&accelerator);
        break;
      }
  if (embrees.empty()) return {};
  std::vector<TextTable::Column> columns{{"rays"}, {"call"}};
  for (const AcceleratorResult* embree : embrees) columns.push_back({embree->variant.name(), true});
  TextTable table(columns);
  for (size_t row = 0; row < embrees.front()->traversal.size(); ++row) {
    const TraversalResult& first = embrees.front()->traversal[row];
    if (!is_embree_call(first.form) || first.times_s.empty()) continue;
    const RaySetInfo& set = scene.sets[first.set];
    std::vector<std::string> cells{set.name, std::string(call_form_name(first.form))};
    for (const AcceleratorResult* embree : embrees) cells.push_back(speed_cell(set, embree->traversal[row], false));
    table.add(cells);
  }
  return "\nEmbree's own calls: packets as wide as its kernels, streams of 128\n" + table.str();
}

// The answers that brute force gives too, in races with plugins.
std::string oracle_line(const AcceleratorResult& accelerator) {
  if (!accelerator.oracle) return {};
  const Disagreements& found = accelerator.oracle->disagreements;
  return fmt::format("  {}: {} disagreement{} with brute force among {} single answers ({} hit or miss, {} distance)\n",
                     accelerator.name(), found.total(), found.total() == 1 ? "" : "s", accelerator.oracle->ray_count,
                     found.hit_or_miss, found.distance);
}

std::string disagreement_lines(const SceneResult& scene) {
  std::string text;
  for (const AcceleratorResult& accelerator : scene.accelerators) {
    if (!accelerator.fault.empty()) {
      text += fmt::format("  {}: out of the race; it {}\n", accelerator.name(), printable(accelerator.fault));
      continue;
    }
    uint64_t compared = 0;
    for (const TraversalResult& result : accelerator.traversal)
      if (!result.times_s.empty()) compared += scene.sets[result.set].ray_count;
    const Disagreements sum = sum_disagreements(accelerator);
    text +=
        fmt::format("  {}: {} disagreement{} with single calls of {} among {} answers ({} hit or miss, {} distance)",
                    accelerator.name(), sum.total(), sum.total() == 1 ? "" : "s", scene.accelerators.front().name(),
                    compared, sum.hit_or_miss, sum.distance);
    if (sum.total() > 0) text += fmt::format(", {} of them at an edge of a triangle", sum.at_edge);
    if (sum.total() > 0 && !accelerator.is_robust() && !accelerator.plugin)
      text += "; accelerators that are not robust let rays through at edges";
    text += '\n' + oracle_line(accelerator);
  }
  return text;
}

} // namespace

std::string_view call_form_name(CallForm form) {
  switch (form) {
  case CallForm::single: return "single";
  case CallForm::batch: return "batch";
  case CallForm::coherent: return "coherent";
  case CallForm::packet: return "packet";
  case CallForm::coherent_packet: return "packet-coherent";
  case CallForm::stream: return "stream";
  case CallForm::coherent_stream: return "stream-coherent";
  case CallForm::launch: return "launch";
  case CallForm::launch_with_copies: return "launch-with-copies";
  }
  return "single";
}

double mega_rays_per_s(const RaySetInfo& set, double seconds) {
  return seconds > 0.0 ? static_cast<double>(set.ray_count) / seconds * 1e-6 : 0.0;
}

const TraversalResult* fastest_row(const AcceleratorResult& accelerator, size_t set, std::optional<CallForm> form) {
  const TraversalResult* best = nullptr;
  for (const TraversalResult& row : accelerator.traversal)
    if (row.set == set && !row.times_s.empty() && (!form || row.form == *form))
      if (best == nullptr || median(row.times_s) < median(best->times_s)) best = &row;
  return best;
}

double mean_ratio(const SceneResult& scene, size_t accelerator, std::optional<CallForm> form) {
  std::vector<double> ratios;
  for (size_t set = 0; set < scene.sets.size(); ++set) {
    const TraversalResult* mine = fastest_row(scene.accelerators[accelerator], set, form);
    const TraversalResult* theirs = fastest_row(scene.accelerators.front(), set, form);
    if (mine && theirs) ratios.push_back(speed_ratio(theirs->times_s, mine->times_s));
  }
  return geometric_mean(ratios);
}

double worst_waiting_share(const SceneResult& scene) {
  double worst = 0.0;
  for (const AcceleratorResult& accelerator : scene.accelerators)
    for (const WorkTime& work : {accelerator.traversal_work, accelerator.build.one_thread_work})
      worst = std::max(worst, waiting_share(work));
  return worst;
}

double median_spread(const SceneResult& scene) {
  std::vector<double> spreads;
  for (const AcceleratorResult& accelerator : scene.accelerators)
    for (const TraversalResult& row : accelerator.traversal)
      if (row.times_s.size() >= 3) spreads.push_back(summarize(row.times_s).spread_percent() / 100.0);
  return median(spreads);
}

std::string scene_warning(const SceneResult& scene) {
  constexpr double kQuietSpread = 0.15;
  std::string text = disturbance_warning(worst_waiting_share(scene));
  const std::vector<std::string> signs = describe_disturbances(scene.machine);
  if (text.empty() && !signs.empty()) text = "The machine was not quiet; do not quote these figures.";
  for (const std::string& sign : signs) text += " " + sign;
  if (const double spread = median_spread(scene); spread >= kQuietSpread)
    text += fmt::format("{}Rounds over the same rays differ by {:.0f} % (median): more rays or a quieter machine give "
                        "better figures.",
                        text.empty() ? "" : " ", spread * 100.0);
  return text;
}

Disagreements sum_disagreements(const AcceleratorResult& accelerator) {
  Disagreements sum;
  for (const TraversalResult& result : accelerator.traversal) sum.add(result.disagreements);
  return sum;
}

LeafSizes summarize_leaf_sizes(const std::vector<size_t>& leaf_sizes) {
  size_t leaves = 0, references = 0, below = 0;
  LeafSizes result;
  for (size_t n = 0; n < leaf_sizes.size(); ++n) {
    leaves += leaf_sizes[n];
    references += n * leaf_sizes[n];
    if (leaf_sizes[n] > 0) result.max = n;
  }
  if (leaves > 0) result.mean = static_cast<double>(references) / static_cast<double>(leaves);
  for (; result.median < result.max; ++result.median)
    if (2 * (below += leaf_sizes[result.median]) >= leaves) break;
  return result;
}

std::string_view clock_description(ShootoutClock clock) {
  return clock == ShootoutClock::cpu ? "CPU time of the thread" : "wall time";
}

std::string scene_name(const SceneResult& scene) { return std::filesystem::path(scene.file).filename().string(); }

std::string format_scene_tables(const ShootoutReport& report, const SceneResult& scene) {
  std::string text = fmt::format("{}\n  {} triangles, {} instances; rays of an image of {}x{}\n", printable(scene.file),
                                 scene.triangle_count, scene.instance_count, scene.size_px.x, scene.size_px.y);
  for (const RaySetInfo& set : scene.sets)
    if (set.ray_count == 0) text += fmt::format("  no rays of kind {}: no path has any\n", set.name);
  if (const std::string warning = scene_warning(scene); !warning.empty()) text += "  " + warning + "\n";
  text += fmt::format("\nbuilds, median of {}\n{}", report.build_repeat, build_table(report, scene));
  text +=
      fmt::format("\ntraversal on one thread, million rays/s: median of {} ± half the spread, {}; batches of {}\n{}",
                  report.repeat, clock_description(report.clock), report.batch_size, speed_table(scene));
  text += embree_call_table(scene) + format_device_table(scene);
  text += cost_table(scene);
  text += "\ncross-check\n" + disagreement_lines(scene);
  text += format_comparisons(compare_with_embree(scene), "");
  return text;
}

} // namespace kindling::app
