// Lets contestants of all kinds race on one scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/race_scene.h"

#include "renderer/app/shootout/device_contestant.h"
#include "renderer/app/shootout/plugins/plugin_contestant.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace kindling::app {

namespace {

size_t count_triangles(const accel::BuildInput& geometry) {
  size_t count = 0;
  for (size_t i = 0; i < geometry.instances.size(); ++i) {
    const accel::MeshGroup& group = geometry.groups[geometry.instances[i].group];
    for (const accel::TriangleMesh& mesh : geometry.meshes.subspan(group.first_mesh, group.mesh_count))
      count += mesh.triangle_count();
  }
  return count;
}

// The contestants of a scene, and the steps of its race.
class SceneRacer {
 public:
  SceneRacer(const SceneRace& race, std::vector<RaySet> sets, SceneResult& result)
      : race_(race), geometry_(*race.settings.geometry), sets_(std::move(sets)), result_(result) {}

  Result<bool> run() {
    // All sets are in one list, because plugins get them together: those of the race, their shares
    // for brute force, those of heat maps.
    raced_ = sets_.size();
    if (has_plugins()) {
      std::vector<RaySet> checked = oracle_sets(sets_, count_triangles(geometry_));
      std::move(checked.begin(), checked.end(), std::back_inserter(sets_));
    }
    if (race_.heat_map) sets_.push_back(center_rays(*race_.heat_map));
    if (Result<void> made = make_contestants(); !made.ok()) return made.error();

    const std::span<const RaySet> raced = std::span(sets_).first(raced_);
    const bool finished =
        race_builds(contestants_, result_.accelerators, race_.settings, race_.progress) &&
        race_traversal(raced, contestants_, race_.settings, race_.progress, result_) &&
        (!has_plugins() || check_against_oracle(std::span<const RaySet>(sets_).subspan(raced_, raced_), raced_,
                                                contestants_, geometry_, race_.progress, result_)) &&
        check_devices(raced) && count_steps(raced) && map_times();
    if (finished) end_plugins();
    return finished;
  }

 private:
  [[nodiscard]] bool has_plugins() const {
    return std::any_of(result_.accelerators.begin(), result_.accelerators.end(),
                       [](const AcceleratorResult& accelerator) { return accelerator.plugin.has_value(); });
  }

  Result<void> make_contestants() {
    std::optional<SharedMemory> shared;
    if (has_plugins()) {
      Result<SharedMemory> memory = share_race(geometry_, sets_);
      if (!memory.ok()) return memory.error();
      shared = std::move(memory).value();
    }
    for (AcceleratorResult& accelerator : result_.accelerators) {
      if (accelerator.device) {
        owned_.push_back(std::make_unique<DeviceContestant>(*race_.device, geometry_, accelerator.variant, sets_));
      } else if (!accelerator.plugin) {
        owned_.push_back(
            std::make_unique<LocalContestant>(geometry_, accelerator.variant, sets_, race_.settings.embree_calls));
      } else {
        auto plugin = std::make_unique<PluginContestant>(*accelerator.plugin, geometry_, sets_, *shared, race_.limits);
        plugin->open();
        accelerator.description = plugin->description();
        accelerator.fault = plugin->fault();
        owned_.push_back(std::move(plugin));
      }
      contestants_.push_back(owned_.back().get());
    }
    return {};
  }

  bool check_devices(std::span<const RaySet> raced) {
    for (size_t a = 0; a < contestants_.size(); ++a) {
      AcceleratorResult& accelerator = result_.accelerators[a];
      if (!accelerator.device) continue;
      accelerator.device->tree_bytes = static_cast<const DeviceContestant*>(contestants_[a])->tree_bytes();
      if (!check_device(raced, *contestants_[a], race_.progress, accelerator)) return false;
    }
    return true;
  }

  bool count_steps(std::span<const RaySet> raced) {
    for (size_t a = 0; a < contestants_.size(); ++a) {
      AcceleratorResult& accelerator = result_.accelerators[a];
      if (accelerator.plugin || accelerator.device) continue; // they report none
      if (!race_.progress(fmt::format("steps of {}", accelerator.name()))) return false;
      accelerator.costs = measure_costs(contestants_[a]->queries(), raced);
      if (race_.heat_map) accelerator.step_map = count_step_map(contestants_[a]->queries(), *race_.heat_map);
    }
    return true;
  }

  bool map_times() {
    if (!race_.heat_map) return true;
    for (size_t a = 0; a < contestants_.size(); ++a) {
      AcceleratorResult& accelerator = result_.accelerators[a];
      if (!race_.progress(fmt::format("heat map of {}", accelerator.name()))) return false;
      if (!accelerator.fault.empty()) continue;
      const std::vector<float> times = contestants_[a]->time_singles(sets_.size() - 1);
      if (!times.empty()) accelerator.heat_map = {race_.heat_map->size_px(), times};
    }
    return true;
  }

  // Lets plugins destroy what they built, which may fail as well.
  void end_plugins() {
    for (size_t a = 0; a < contestants_.size(); ++a) {
      AcceleratorResult& accelerator = result_.accelerators[a];
      if (!accelerator.plugin || !accelerator.fault.empty()) continue;
      static_cast<PluginContestant*>(contestants_[a])->release();
      accelerator.fault = contestants_[a]->fault();
    }
  }

  const SceneRace& race_;
  const accel::BuildInput& geometry_;
  std::vector<RaySet> sets_;
  SceneResult& result_;
  size_t raced_ = 0; // the first sets, which are raced on
  std::vector<std::unique_ptr<Contestant>> owned_;
  std::vector<Contestant*> contestants_;
};

} // namespace

Result<bool> race_scene(const SceneRace& race, std::vector<RaySet> sets, SceneResult& result) {
  return SceneRacer(race, std::move(sets), result).run();
}

uint64_t wrong_answers(const SceneResult& scene, const AcceleratorResult& accelerator) {
  if (accelerator.device) return accelerator.device->check.disagreements.total();
  uint64_t answers = 0;
  for (const TraversalResult& row : accelerator.traversal)
    if (!row.times_s.empty()) answers += scene.sets[row.set].ray_count;
  if (const uint64_t wrong = sum_disagreements(accelerator).total(); wrong * 1000 > answers) return wrong;
  if (!accelerator.oracle) return 0;
  const uint64_t wrong = accelerator.oracle->disagreements.total();
  return wrong * 1000 > accelerator.oracle->ray_count ? wrong : 0;
}

} // namespace kindling::app
