// Writes a shootout as JSON; README.md describes the keys.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_load.h"
#include "renderer/app/measure/measurement_json.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/shootout/shootout_summary.h"
#include "renderer/app/terminal/version.h"
#include "renderer/app/text/text_format.h"

#include <nlohmann/json.hpp>

namespace kindling::app {

namespace {

using Json = nlohmann::ordered_json;

Json disagreements_json(const Disagreements& disagreements) {
  return {{"hit_or_miss", disagreements.hit_or_miss},
          {"distance", disagreements.distance},
          {"at_edge", disagreements.at_edge}};
}

Json comparisons_json(const std::vector<EmbreeComparison>& comparisons) {
  const auto number_or_null = [](const std::optional<double>& value) {
    return value.value_or(0.0) > 0.0 ? Json(*value) : Json();
  };
  Json json = Json::array();
  for (const EmbreeComparison& comparison : comparisons) {
    Json lines = Json::array();
    for (const EmbreeComparisonLine& line : comparison.lines)
      lines.push_back({{"ratio", line.measure},
                       {"to_robust_embree", number_or_null(line.robust)},
                       {"to_any_embree", number_or_null(line.any)},
                       {"aim", line.aim},
                       {"lower_wins", line.lower_wins}});
    json.push_back({{"name", comparison.contender}, {"lines", std::move(lines)}});
  }
  return json;
}

Json race_accelerator_json(const SceneResult& scene, size_t index) {
  const AcceleratorResult& a = scene.accelerators[index];
  const accel::Statistics& s = a.build.statistics;
  Json json;
  json["name"] = a.name();
  if (a.plugin) {
    json["description"] = a.description;
    json["plugin"] = {{"file", a.plugin->file.string()}, {"options", a.plugin->options}};
    json["fault"] = a.fault.empty() ? Json() : Json(a.fault);
  } else if (a.device) {
    json["description"] = accel::kind_description(a.variant.kind);
    json["quality"] = quality_name(a.variant.quality);
    json["robust"] = a.variant.robust;
    json["device"] = {{"kind", device_kind_name(a.device->kind)},
                      {"name", a.device->name},
                      {"tree_bytes", a.device->tree_bytes},
                      {"answers", a.device->check.ray_count},
                      {"different", a.device->check.disagreements.total()}};
    json["fault"] = a.fault.empty() ? Json() : Json(a.fault);
  } else {
    json["description"] = accel::kind_description(a.variant.kind);
    json["quality"] = quality_name(a.variant.quality);
    json["robust"] = a.variant.robust;
    json["simd"] = accel::simd_target_name(s.simd);
  }
  json["build"] = {{"one_thread", summary_json(a.build.one_thread_s)},
                   {"many_threads", summary_json(a.build.many_threads_s)}};
  json["memory_bytes"] = s.memory_bytes;
  json["build_peak_bytes"] = a.build.peak_growth_bytes ? Json(*a.build.peak_growth_bytes) : Json();
  json["huge_page_bytes"] = a.build.huge_page_bytes;
  json["nodes"] = s.node_count;
  json["leaves"] = s.leaf_count;
  json["references"] = s.reference_count;
  if (s.leaf_sizes.empty()) {
    json["leaf_sizes"] = Json();
  } else {
    const LeafSizes sizes = summarize_leaf_sizes(s.leaf_sizes);
    json["leaf_sizes"] = {
        {"mean", sizes.mean}, {"median", sizes.median}, {"max", sizes.max}, {"leaves_by_size", s.leaf_sizes}};
  }
  json["cost"] = a.costs.empty() ? Json() : Json::array();
  for (size_t set = 0; set < a.costs.size(); ++set)
    json["cost"].push_back({{"rays", scene.sets[set].name},
                            {"nodes", a.costs[set].nodes},
                            {"leaves", a.costs[set].leaves},
                            {"triangles", a.costs[set].triangles}});
  json["traversal"] = Json::array();
  for (const TraversalResult& result : a.traversal) {
    if (result.times_s.empty()) continue; // it has no such call
    const RaySetInfo& set = scene.sets[result.set];
    Json row = {{"rays", set.name}, {"call", call_form_name(result.form)}};
    row["mega_rays_per_s"] = mega_rays_per_s(set, median(result.times_s));
    row["ratio_to_first"] = result.ratio_to_first;
    row["disagreements"] = disagreements_json(result.disagreements);
    row.update(summary_json(result.times_s));
    json["traversal"].push_back(std::move(row));
  }
  json["geometric_mean_ratio"] = {{"single", mean_ratio(scene, index, CallForm::single)},
                                  {"batch", mean_ratio(scene, index, CallForm::batch)},
                                  {"best", mean_ratio(scene, index, std::nullopt)}};
  json["disagreements"] = disagreements_json(sum_disagreements(a));
  if (a.oracle) {
    json["brute_force"] = disagreements_json(a.oracle->disagreements);
    json["brute_force"]["answers"] = a.oracle->ray_count;
  }
  return json;
}

Json race_scene_json(const SceneResult& scene) {
  Json json;
  json["file"] = scene.file;
  json["geometry_hash"] = format_hash(scene.geometry_hash);
  json["width"] = scene.size_px.x;
  json["height"] = scene.size_px.y;
  json["triangles"] = scene.triangle_count;
  json["instances"] = scene.instance_count;
  const double waiting = worst_waiting_share(scene);
  json["waiting_share"] = waiting;
  const auto known = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  json["machine"] = {{"other_cores", known(scene.machine.other_cores)},
                     {"steal_share", known(scene.machine.steal_share)},
                     {"median_spread", median_spread(scene)}};
  const std::string warning = scene_warning(scene);
  json["warning"] = warning.empty() ? Json() : Json(warning);
  json["rays"] = Json::array();
  for (const RaySetInfo& set : scene.sets)
    json["rays"].push_back({{"name", set.name},
                            {"query", set.query == RayQuery::nearest ? "nearest" : "any-hit"},
                            {"coherent_group", set.coherent_group},
                            {"count", set.ray_count},
                            {"hits", set.hit_count}});
  json["accelerators"] = Json::array();
  for (size_t a = 0; a < scene.accelerators.size(); ++a)
    json["accelerators"].push_back(race_accelerator_json(scene, a));
  json["against_embree"] = comparisons_json(compare_with_embree(scene));
  return json;
}

} // namespace

std::string format_shootout_json(const ShootoutReport& report) {
  Json json;
  json["version"] = version();
  json["compiler"] = compiler();
  json["command_line"] = report.command_line;
  json["processor"] = report.processor;
  json["clock"] = clock_name(report.clock);
  json["traversal_threads"] = 1;
  json["build_threads"] = report.build_threads;
  json["repeat"] = report.repeat;
  json["build_repeat"] = report.build_repeat;
  json["batch_size"] = report.batch_size;
  json["scenes"] = Json::array();
  for (const SceneResult& scene : report.scenes) json["scenes"].push_back(race_scene_json(scene));
  json["against_embree"] = comparisons_json(compare_with_embree(report));
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

} // namespace kindling::app
