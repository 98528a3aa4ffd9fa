// Derives the figures of all reports from the measurements.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/scaling_report.h"

#include "renderer/app/measure/machine_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace kindling::app {

namespace {

// Returns member(sample) for the first `count` samples.
template <typename Sample, typename Member>
std::vector<double> values(const std::vector<Sample>& samples, size_t count, Member&& member) {
  std::vector<double> result;
  for (size_t i = 0; i < std::min(count, samples.size()); ++i) result.push_back(member(samples[i]));
  return result;
}
template <typename Sample, typename Member>
std::vector<double> values(const std::vector<Sample>& samples, Member&& member) {
  return values(samples, samples.size(), std::forward<Member>(member));
}

// Summarizes reference[i] / candidate[i] over the rounds that have both.
Summary ratios(const std::vector<double>& reference, const std::vector<double>& candidate) {
  std::vector<double> result;
  for (size_t i = 0; i < std::min(reference.size(), candidate.size()); ++i)
    if (reference[i] > 0.0 && candidate[i] > 0.0) result.push_back(reference[i] / candidate[i]);
  return summarize(result);
}

template <typename Sample, typename Member>
std::optional<uint64_t> largest(const std::vector<Sample>& samples, Member&& member) {
  std::optional<uint64_t> result;
  for (const Sample& sample : samples)
    if (const std::optional<uint64_t> value = member(sample)) result = std::max(result.value_or(0), *value);
  return result;
}

double wall(const WorkTime& time) { return time.wall_s; }
double cpu(const WorkTime& time) { return time.cpu_s; }

} // namespace

const PreparationPhaseInfo& phase_info(PreparationPhase phase) {
  static constexpr std::array<PreparationPhaseInfo, kPreparationPhases> kInfos{
      {{"files", "read, hashed and parsed"},
       {"meshes", "vertices decoded and checked"},
       {"tangents", "made where the file has none"},
       {"textures", "images read and decoded"},
       {"environment", "read and decoded"},
       {"distribution", "of the environment, for sampling"},
       {"levels", "mip levels of textures"},
       {"pose", "of nodes, skins and cameras"},
       {"geometry", "vertices packed"},
       {"lights", "collected, and their tree"},
       {"accelerator", "built"}}};
  return kInfos[static_cast<size_t>(phase)];
}

WorkTime PreparationSample::total() const {
  WorkTime sum;
  for (const WorkTime& time : phases) sum += time;
  return sum;
}

const RenderRow* find_row(const AcceleratorScaling& accelerator, Schedule schedule, int threads) {
  for (const RenderRow& row : accelerator.renders)
    if (row.schedule == schedule && row.threads == threads) return &row;
  return nullptr;
}

RenderScaling summarize_render(const AcceleratorScaling& accelerator, const RenderRow& row) {
  const auto wall_s = [](const RenderSample& s) { return s.time.wall_s; };
  const auto cpu_s = [](const RenderSample& s) { return s.time.cpu_s; };
  const auto share = [&](const auto& seconds) {
    return median(values(row.samples, [&](const RenderSample& s) {
      const double threads_s = s.time.wall_s * row.threads;
      return threads_s > 0.0 ? seconds(s) / threads_s : 0.0;
    }));
  };
  const auto rate = [&](const auto& count) {
    return median(values(row.samples, [&](const RenderSample& s) {
      return s.time.wall_s > 0.0 ? static_cast<double>(count(s)) / s.time.wall_s : 0.0;
    }));
  };
  RenderScaling result;
  result.wall_s = summarize(values(row.samples, wall_s));
  result.cpu_s = median(values(row.samples, cpu_s));
  result.rays_per_s = rate([](const RenderSample& s) { return s.rays; });
  result.paths_per_s = rate([](const RenderSample& s) { return s.paths; });
  result.idle_share = share([](const RenderSample& s) { return s.idle_s; });
  result.waiting_share =
      median(values(row.samples, [&](const RenderSample& s) { return waiting_share(s.time, row.threads, s.idle_s); }));
  result.training_s = median(values(row.samples, [](const RenderSample& s) { return s.training_s; }));
  if (const RenderRow* one = find_row(accelerator, row.schedule, 1)) {
    result.speedup = ratios(values(one->samples, wall_s), values(row.samples, wall_s));
    result.efficiency = result.speedup.median / row.threads;
    const double growth = ratios(values(row.samples, cpu_s), values(one->samples, cpu_s)).median;
    result.cpu_growth = growth > 0.0 ? growth - 1.0 : 0.0;
  }
  result.peak_bytes = largest(row.samples, [](const RenderSample& s) { return s.peak_bytes; });
  for (const PreparationRow& preparation : accelerator.preparations)
    if (preparation.threads == row.threads)
      if (const auto peak = largest(preparation.samples, [](const PreparationSample& s) { return s.peak_bytes; }))
        result.peak_bytes = std::max(result.peak_bytes.value_or(0), *peak);
  result.growth_bytes = largest(row.samples, [](const RenderSample& s) -> std::optional<uint64_t> {
    if (!s.peak_bytes || !s.resident_bytes) return std::nullopt;
    return *s.peak_bytes - std::min(*s.peak_bytes, *s.resident_bytes);
  });
  return result;
}

double worst_waiting_share(const ScalingReport& report, const SceneScaling& scene) {
  double worst = 0.0;
  for (const AcceleratorScaling& accelerator : scene.accelerators)
    for (const RenderRow& row : accelerator.renders)
      if (!row.samples.empty() && row.threads <= report.cores)
        worst = std::max(worst, summarize_render(accelerator, row).waiting_share);
  return worst;
}

std::optional<AmdahlFit> fit_renders(const AcceleratorScaling& accelerator, Schedule schedule, int cores) {
  std::vector<std::pair<int, double>> speedups;
  for (const RenderRow& row : accelerator.renders)
    if (row.schedule == schedule && row.threads <= cores)
      speedups.emplace_back(row.threads, summarize_render(accelerator, row).speedup.median);
  return fit_amdahl(speedups);
}

std::vector<PhaseScaling> summarize_phases(const SceneScaling& scene) {
  // Concatenates the rows of these accelerators, so that ratios are between rounds of the same one.
  const auto summarize_one = [&](std::string name, std::span<const AcceleratorScaling> accelerators,
                                 const auto& time_of) {
    PhaseScaling phase{std::move(name), {}};
    for (size_t row = 0; row < accelerators.front().preparations.size(); ++row) {
      std::vector<double> wall_s, cpu_s, one_s, many_s;
      for (const AcceleratorScaling& a : accelerators) {
        const auto all = [&](const PreparationRow& r, const auto& part) {
          return values(r.samples, [&](const PreparationSample& s) { return part(time_of(s)); });
        };
        const std::vector<double> one = all(a.preparations.front(), wall), many = all(a.preparations[row], wall);
        const std::vector<double> work = all(a.preparations[row], cpu);
        const auto both = static_cast<std::ptrdiff_t>(std::min(one.size(), many.size()));
        one_s.insert(one_s.end(), one.begin(), one.begin() + both);
        many_s.insert(many_s.end(), many.begin(), many.begin() + both);
        wall_s.insert(wall_s.end(), many.begin(), many.end());
        cpu_s.insert(cpu_s.end(), work.begin(), work.end());
      }
      phase.points.push_back({accelerators.front().preparations[row].threads, summarize(wall_s),
                              ratios(one_s, many_s).median, ratios(cpu_s, wall_s).median});
    }
    return phase;
  };
  std::vector<PhaseScaling> result;
  if (scene.accelerators.empty()) return result;
  const auto add = [&](PhaseScaling phase) {
    if (!phase.points.empty() && phase.points.front().wall_s.max > 0.0) result.push_back(std::move(phase));
  };
  for (size_t p = 0; p + 1 < kPreparationPhases; ++p) {
    const auto phase = static_cast<PreparationPhase>(p);
    add(summarize_one(std::string(phase_info(phase).name), scene.accelerators,
                      [phase](const PreparationSample& s) { return s.of(phase); }));
  }
  for (const AcceleratorScaling& a : scene.accelerators)
    add(summarize_one("accelerator " + a.variant.name(), {&a, 1},
                      [](const PreparationSample& s) { return s.of(PreparationPhase::accelerator); }));
  for (const AcceleratorScaling& a : scene.accelerators)
    add(summarize_one("all with " + a.variant.name(), {&a, 1}, [](const PreparationSample& s) { return s.total(); }));
  return result;
}

std::vector<ImageMismatch> find_mismatches(const SceneScaling& scene) {
  std::vector<ImageMismatch> result;
  for (size_t a = 0; a < scene.accelerators.size(); ++a) {
    std::optional<uint64_t> expected;
    for (const RenderRow& row : scene.accelerators[a].renders)
      for (size_t round = 0; round < row.samples.size(); ++round) {
        if (!expected) expected = row.samples[round].hash;
        if (row.samples[round].hash != *expected)
          result.push_back({scene.accelerators[a].variant.name(), row.schedule, row.threads, round});
      }
    if (!scene.device || scene.device->accelerator != a || !expected) continue;
    const DeviceScaling& device = *scene.device;
    for (size_t round = 0; round < device.alone.size(); ++round)
      if (device.alone[round].hash != *expected) result.push_back({device_renderer(device, false), {}, 0, round});
    for (size_t round = 0; round < device.shared.size(); ++round)
      if (const SharedSample& sample = device.shared[round]; sample.hash != *expected)
        result.push_back({device_renderer(device, true), {}, sample.threads, round});
  }
  return result;
}

std::vector<EfficiencySummary> summarize_scenes(const ScalingReport& report) {
  std::vector<EfficiencySummary> result;
  if (report.scenes.empty()) return result;
  for (size_t a = 0; a < report.scenes.front().accelerators.size(); ++a)
    for (const Schedule schedule : report.schedules)
      for (const int threads : report.thread_counts) {
        if (threads == 1) continue;
        EfficiencySummary summary;
        summary.accelerator = report.scenes.front().accelerators[a].variant.name();
        summary.schedule = schedule;
        summary.threads = threads;
        std::vector<double> efficiencies;
        for (const SceneScaling& scene : report.scenes) {
          const RenderRow* row = find_row(scene.accelerators[a], schedule, threads);
          if (row == nullptr || row->samples.empty()) continue;
          const RenderScaling render = summarize_render(scene.accelerators[a], *row);
          if (!(render.efficiency > 0.0)) continue;
          if (efficiencies.empty() || render.efficiency < summary.worst) {
            summary.worst = render.efficiency;
            summary.worst_scene = scene_name(scene);
          }
          efficiencies.push_back(render.efficiency);
          summary.mean_idle_share += render.idle_share;
        }
        if (efficiencies.empty()) continue;
        summary.mean = geometric_mean(efficiencies);
        summary.mean_idle_share /= static_cast<double>(efficiencies.size());
        result.push_back(summary);
      }
  return result;
}

std::span<const PaperSpeedup> paper_speedups() {
  static constexpr std::array<PaperSpeedup, 2> kPaper{
      {{2, 1.2, 1.4, "AMD Turion X2, 2 cores"}, {3, 1.43, 1.43, "AMD Phenom 8400, 3 cores"}}};
  return kPaper;
}

std::string scene_name(const SceneScaling& scene) { return std::filesystem::path(scene.file).filename().string(); }

} // namespace kindling::app
