// What `kindling scaling` has measured, what follows from it, and the forms in which it is told: tables, JSON, CSV, curves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/measure/measurement.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/scaling/scaling_fit.h"
#include "renderer/base/math.h"
#include "renderer/base/stopwatch.h"
#include "renderer/session/tile_scheduler.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// What is done before the first path is traced, in order.
enum class PreparationPhase : uint8_t {
  files,
  meshes,
  tangents,
  textures,
  environment,
  distribution,
  levels,
  pose,
  geometry,
  lights,
  accelerator
};
inline constexpr size_t kPreparationPhases = 11;
struct PreparationPhaseInfo {
  std::string_view name;
  std::string_view meaning;
};
[[nodiscard]] const PreparationPhaseInfo& phase_info(PreparationPhase phase);

// One loading and building; the phases follow each other.
struct PreparationSample {
  std::array<WorkTime, kPreparationPhases> phases;
  std::optional<uint64_t> peak_bytes; // most resident memory of the process; unset where the system does not tell

  [[nodiscard]] WorkTime& of(PreparationPhase phase) { return phases[static_cast<size_t>(phase)]; }
  [[nodiscard]] const WorkTime& of(PreparationPhase phase) const { return phases[static_cast<size_t>(phase)]; }
  [[nodiscard]] WorkTime total() const;
};

// One render.
struct RenderSample {
  WorkTime time;                          // of the render phase
  double idle_s = 0.0;                    // without a tile, summed over the threads
  double training_s = 0.0;                // of a guide, part of the time
  uint64_t rays = 0;                      // of all kinds
  uint64_t paths = 0;                     // samples of pixels
  uint64_t hash = 0;                      // of the image
  std::optional<uint64_t> peak_bytes;     // most resident memory of the process during the render
  std::optional<uint64_t> resident_bytes; // before it
};

struct PreparationRow {
  int threads = 1;
  std::vector<PreparationSample> samples; // by round
};
struct RenderRow {
  int threads = 1;
  Schedule schedule = Schedule::tiles;
  std::vector<RenderSample> samples; // by round
};

struct AcceleratorScaling {
  AcceleratorVariant variant;
  std::vector<PreparationRow> preparations; // by rising threads, the first with one
  std::vector<RenderRow> renders;           // schedules in order, by rising threads within
  size_t accelerator_bytes = 0;
};

struct SceneScaling {
  std::string file;
  V2i size_px{0, 0};
  uint32_t samples_per_pixel = 0;
  size_t triangle_count = 0; // as placed
  size_t instance_count = 0;
  size_t geometry_bytes = 0, texture_bytes = 0, light_bytes = 0, film_bytes = 0;
  std::vector<AcceleratorScaling> accelerators;
};

struct ScalingReport {
  std::string command_line;
  std::string processor; // empty where the system does not tell
  int cores = 1;         // that this process may use
  std::string integrator;
  uint32_t repeat = 0; // asked for
  std::vector<Schedule> schedules;
  std::vector<int> thread_counts; // rising, the first is 1
  bool interrupted = false;       // scenes and rounds are missing
  std::vector<SceneScaling> scenes;
};

// What is quoted of one row; each figure is a median over the rounds, a ratio one of the ratios within the rounds that have both.
struct RenderScaling {
  Summary wall_s;
  double cpu_s = 0.0;
  Summary speedup; // T1 / Tn of the same accelerator and schedule
  double efficiency = 0.0;
  double rays_per_s = 0.0, paths_per_s = 0.0;
  double idle_share = 0.0; // of the threads' time, without a tile
  double waiting_share =
      0.0;                 // of the threads' time, neither idle nor on a processor: others had it, or pages were read
  double cpu_growth = 0.0; // CPU time over that of one thread, less 1: what cores take from each other
  double training_s = 0.0;
  std::optional<uint64_t> peak_bytes;   // of loading, building and rendering
  std::optional<uint64_t> growth_bytes; // by the render: film, the threads' contexts, guide
};
[[nodiscard]] RenderScaling summarize_render(const AcceleratorScaling& accelerator, const RenderRow& row);
[[nodiscard]] const RenderRow* find_row(const AcceleratorScaling& accelerator, Schedule schedule, int threads);

// Of the speed-ups at up to `cores` threads, beyond which no processor is left; nothing without a second count.
[[nodiscard]] std::optional<AmdahlFit> fit_renders(const AcceleratorScaling& accelerator, Schedule schedule, int cores);

// A phase over all accelerators (they differ in the last alone, for which there is one line for each).
struct PhaseScaling {
  std::string name; // of the phase; "accelerator kdtree", "all with kdtree"
  struct Point {
    int threads = 1;
    Summary wall_s;
    double speedup = 0.0;     // by rounds, as for renders; 0 if nothing was measured
    double parallelism = 0.0; // CPU time over wall time: on how many cores it ran
  };
  std::vector<Point> points; // by rising threads
};
// Phases that took any time, then the sum of the medians.
[[nodiscard]] std::vector<PhaseScaling> summarize_phases(const SceneScaling& scene);

// Images that differ from the first of their accelerator: they should not.
struct ImageMismatch {
  size_t accelerator = 0;
  Schedule schedule = Schedule::tiles;
  int threads = 1;
  size_t round = 0;
};
[[nodiscard]] std::vector<ImageMismatch> find_mismatches(const SceneScaling& scene);

// Over all scenes: geometric mean and worst of the efficiencies.
struct EfficiencySummary {
  std::string accelerator;
  Schedule schedule = Schedule::tiles;
  int threads = 1;
  double mean = 0.0;
  double worst = 0.0;
  std::string worst_scene;
  double mean_idle_share = 0.0; // arithmetic
};
[[nodiscard]] std::vector<EfficiencySummary> summarize_scenes(const ScalingReport& report);

// What the paper of the Whitted tracer's figures measured of its static regions, taken as T1 / Tn: Xia, "Research on ray tracing" (2011),
// section on the multi-core ray tracer, figure 1 at 900 x 675 pixels. It tells no idle time.
struct PaperSpeedup {
  int threads = 1;
  double low = 1.0, high = 1.0;
  std::string_view processor;
};
[[nodiscard]] std::span<const PaperSpeedup> paper_speedups();

// "SCENE.glb" of its path.
[[nodiscard]] std::string scene_name(const SceneScaling& scene);

// The tables of one scene for a terminal; ends with '\n'.
[[nodiscard]] std::string format_scaling_tables(const ScalingReport& report, const SceneScaling& scene);
// The table over all scenes.
[[nodiscard]] std::string format_scaling_summary(const ScalingReport& report);
// README.md describes the keys and columns.
[[nodiscard]] std::string format_scaling_json(const ScalingReport& report);
[[nodiscard]] std::string format_scaling_csv(const ScalingReport& report);
// Speed-up and efficiency over threads, a panel for each scene; complete in itself.
[[nodiscard]] std::string draw_scaling(const ScalingReport& report);

} // namespace kindling::app
