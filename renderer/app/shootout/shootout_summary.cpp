// Compares the fastest rows of the kd-tree with those of Embree.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/shootout_summary.h"

#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace kindling::app {

namespace {

using SetFilter = bool (*)(const RaySetInfo&);
using RivalFilter = std::function<bool(const AcceleratorResult&)>;

// The mean ratio of speeds over the wanted kinds of rays.
std::optional<double> speed_against(const SceneResult& scene, const AcceleratorResult& own, SetFilter wanted,
                                    std::optional<CallForm> form, const RivalFilter& rival) {
  std::vector<double> ratios;
  for (size_t set = 0; set < scene.sets.size(); ++set) {
    if (!wanted(scene.sets[set])) continue;
    const TraversalResult* mine = fastest_row(own, set, form);
    const TraversalResult* theirs = nullptr;
    for (const AcceleratorResult& accelerator : scene.accelerators) {
      if (!rival(accelerator)) continue;
      const TraversalResult* row = fastest_row(accelerator, set, form);
      if (row && (!theirs || median(row->times_s) < median(theirs->times_s))) theirs = row;
    }
    if (mine && theirs) ratios.push_back(speed_ratio(theirs->times_s, mine->times_s));
  }
  if (ratios.empty()) return std::nullopt;
  return geometric_mean(ratios);
}

// The ratio of a quantity of builds.
std::optional<double> build_against(const SceneResult& scene, const AcceleratorResult& own,
                                    double (*quantity)(const BuildResult&), const RivalFilter& rival) {
  std::optional<double> smallest;
  for (const AcceleratorResult& accelerator : scene.accelerators)
    if (rival(accelerator)) {
      const double value = quantity(accelerator.build);
      smallest = std::min(value, smallest.value_or(value));
    }
  if (!smallest) return std::nullopt;
  return *smallest > 0.0 ? quantity(own.build) / *smallest : 0.0;
}

// Rays of files may be anything, also bounces of another renderer.
bool is_bounce(const RaySetInfo& set) {
  return set.query == RayQuery::nearest && set.coherent_group == 0 && set.name.starts_with("bounce");
}
bool is_other(const RaySetInfo& set) {
  return set.query == RayQuery::nearest && set.coherent_group == 0 && !is_bounce(set);
}
bool is_nearest(const RaySetInfo& set) { return set.query == RayQuery::nearest; }
bool is_coherent(const RaySetInfo& set) { return set.query == RayQuery::nearest && set.coherent_group > 0; }
bool is_any_hit(const RaySetInfo& set) { return set.query == RayQuery::any_hit; }

double build_time(const BuildResult& build) { return median(build.many_threads_s); }
double memory(const BuildResult& build) { return static_cast<double>(build.statistics.memory_bytes); }

EmbreeComparison compare(const SceneResult& scene, const AcceleratorResult& own) {
  EmbreeComparison comparison{own.name(), {}};
  const auto embree = [](std::optional<accel::Quality> quality, bool robust_only) {
    return [quality, robust_only](const AcceleratorResult& a) {
      return a.is(accel::Kind::embree) && (a.variant.robust || !robust_only) &&
             (!quality || a.variant.quality == *quality);
    };
  };
  const auto add_speed = [&](const char* measure, SetFilter sets, std::optional<CallForm> form, double aim) {
    comparison.lines.push_back({measure, speed_against(scene, own, sets, form, embree({}, true)),
                                speed_against(scene, own, sets, form, embree({}, false)), aim, false});
  };
  const auto add_build = [&](const char* measure, double (*quantity)(const BuildResult&), accel::Quality quality,
                             double aim) {
    comparison.lines.push_back({measure, build_against(scene, own, quantity, embree(quality, true)),
                                build_against(scene, own, quantity, embree(quality, false)), aim, true});
  };
  add_speed("speed, bounces, best call of each", is_bounce, std::nullopt, 1.3);
  add_speed("speed, nearest hit, single calls", is_nearest, CallForm::single, 1.1);
  add_speed("speed, camera, best call of each", is_coherent, std::nullopt, 1.0);
  add_speed("speed, any hit, best call of each", is_any_hit, std::nullopt, 1.0);
  if (std::any_of(scene.sets.begin(), scene.sets.end(), is_other))
    add_speed("speed, nearest hit of other rays, best call of each", is_other, std::nullopt, 1.0);
  add_build("build time of medium quality (balanced)", build_time, accel::Quality::balanced, 4.0);
  add_build("build time of high quality (best)", build_time, accel::Quality::best, 1.0);
  add_build("memory of medium quality (balanced)", memory, accel::Quality::balanced, 1.3);
  return comparison;
}

std::optional<double> mean(const std::vector<EmbreeComparison>& scenes, size_t line,
                           std::optional<double> EmbreeComparisonLine::*side) {
  std::vector<double> values;
  for (const EmbreeComparison& scene : scenes)
    if (scene.lines[line].*side) values.push_back(*(scene.lines[line].*side));
  if (values.empty()) return std::nullopt;
  return geometric_mean(values);
}

} // namespace

std::vector<EmbreeComparison> compare_with_embree(const SceneResult& scene) {
  std::vector<EmbreeComparison> comparisons;
  const auto is = [](accel::Kind kind) {
    return [kind](const AcceleratorResult& accelerator) { return accelerator.is(kind); };
  };
  if (std::none_of(scene.accelerators.begin(), scene.accelerators.end(), is(accel::Kind::embree))) return {};
  for (const AcceleratorResult& accelerator : scene.accelerators)
    if (is(accel::Kind::kdtree)(accelerator)) comparisons.push_back(compare(scene, accelerator));
  return comparisons;
}

std::vector<EmbreeComparison> compare_with_embree(const ShootoutReport& report) {
  if (report.scenes.empty()) return {};
  std::vector<EmbreeComparison> means = compare_with_embree(report.scenes.front()); // all scenes have the same variants
  for (size_t c = 0; c < means.size(); ++c) {
    std::vector<EmbreeComparison> scenes;
    for (const SceneResult& scene : report.scenes) scenes.push_back(compare_with_embree(scene)[c]);
    for (size_t line = 0; line < means[c].lines.size(); ++line) {
      means[c].lines[line].robust = mean(scenes, line, &EmbreeComparisonLine::robust);
      means[c].lines[line].any = mean(scenes, line, &EmbreeComparisonLine::any);
    }
  }
  return means;
}

std::string format_ratio(const std::optional<double>& ratio) {
  if (!ratio) return "-";
  if (!(*ratio > 0.0)) return "n/a";
  return *ratio < 0.1 ? fmt::format("{:.2g}x", *ratio) : fmt::format("{:.2f}x", *ratio);
}

std::string format_aim(const EmbreeComparisonLine& line) {
  return fmt::format("{} {:.1f}x", line.lower_wins ? "<=" : ">=", line.aim);
}

std::string format_comparisons(const std::vector<EmbreeComparison>& comparisons, const std::string& of_what) {
  std::string text;
  for (const EmbreeComparison& comparison : comparisons) {
    TextTable table({{"ratio"}, {"to robust Embree", true}, {"to any Embree", true}, {"aim", true}});
    for (const EmbreeComparisonLine& line : comparison.lines)
      table.add({line.measure, format_ratio(line.robust), format_ratio(line.any), format_aim(line)});
    text += fmt::format("\n{} against the best of Embree{}\n{}", comparison.contender, of_what, table.str());
  }
  return text;
}

} // namespace kindling::app
