// Measurements of `kindling scaling`, derived figures, and reports as tables, JSON, CSV and SVG.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/measure/measurement.h"
#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/scaling/scaling_fit.h"
#include "renderer/base/math.h"
#include "renderer/base/stopwatch.h"
#include "renderer/device/make_device.h"
#include "renderer/session/tile_scheduler.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// The phases before the first path is traced, in order.
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

// One loading and building, whose phases follow each other.
struct PreparationSample {
  std::array<WorkTime, kPreparationPhases> phases;
  std::optional<uint64_t> peak_bytes; // peak resident memory of the process; unset if the system does not report it

  [[nodiscard]] WorkTime& of(PreparationPhase phase) { return phases[static_cast<size_t>(phase)]; }
  [[nodiscard]] const WorkTime& of(PreparationPhase phase) const { return phases[static_cast<size_t>(phase)]; }
  [[nodiscard]] WorkTime total() const;
};

// One render.
struct RenderSample {
  WorkTime time;                          // render phase
  double idle_s = 0.0;                    // without a tile, summed over the threads
  double training_s = 0.0;                // training of a guide, part of the time
  uint64_t rays = 0;                      // all kinds
  uint64_t paths = 0;                     // samples of pixels
  uint64_t hash = 0;                      // hash of the image
  std::optional<uint64_t> peak_bytes;     // peak resident memory of the process during the render
  std::optional<uint64_t> resident_bytes; // before the render
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
  std::vector<PreparationRow> preparations; // by increasing threads, from 1
  std::vector<RenderRow> renders;           // by schedule, then by increasing threads
  size_t accelerator_bytes = 0;
};

// One render on a device.
struct DeviceSample {
  WorkTime time;            // render phase
  double start_s = 0.0;     // part of it: until the device had the scene
  uint64_t rays = 0;        // all kinds
  uint64_t paths = 0;       // samples of pixels
  uint64_t scene_bytes = 0; // in its memory
  uint64_t hash = 0;        // of the image
};
// One frame of which the processor rendered the upper part and the device the rest.
struct SharedSample {
  double wall_s = 0.0;                      // of all
  double processor_s = 0.0, device_s = 0.0; // of their parts, at the same time
  double merge_s = 0.0;
  double processor_share = 0.0; // of the pixels
  int threads = 1;              // of the processor
  uint64_t paths = 0;
  uint64_t hash = 0; // of the merged image
};
struct DeviceScaling {
  DeviceKind kind = DeviceKind::host;
  std::string name;
  size_t accelerator = 0;           // index of the kd-tree whose images are the device's
  std::vector<DeviceSample> alone;  // by round
  std::vector<SharedSample> shared; // by round
};

struct SceneScaling {
  std::string file;
  V2i size_px{0, 0};
  uint32_t samples_per_pixel = 0;
  size_t triangle_count = 0; // with all instances
  size_t instance_count = 0;
  size_t geometry_bytes = 0, texture_bytes = 0, light_bytes = 0, film_bytes = 0;
  std::vector<AcceleratorScaling> accelerators;
  std::optional<DeviceScaling> device;
};

struct ScalingReport {
  std::string command_line;
  std::string processor; // empty if unknown
  int cores = 1;         // available to this process
  std::string integrator;
  uint32_t repeat = 0; // requested rounds
  std::vector<Schedule> schedules;
  std::vector<int> thread_counts; // increasing from 1
  bool interrupted = false;       // scenes and rounds are missing
  std::vector<SceneScaling> scenes;
};

// The figures of one row: medians over the rounds; ratios are medians of the ratios within rounds
// that have both sides.
struct RenderScaling {
  Summary wall_s;
  double cpu_s = 0.0;
  Summary speedup; // T(1) / T(n) with the same accelerator and schedule
  double efficiency = 0.0;
  double rays_per_s = 0.0, paths_per_s = 0.0;
  double idle_share = 0.0;    // share of the threads' time without a tile
  double waiting_share = 0.0; // waiting_share()
  double cpu_growth =
      0.0; // CPU time over that of one thread, minus 1: the cost of sharing caches, memory and clock rates
  double training_s = 0.0;
  std::optional<uint64_t> peak_bytes;   // during loading, building and rendering
  std::optional<uint64_t> growth_bytes; // during the render: film, contexts of the threads, guide
};
[[nodiscard]] RenderScaling summarize_render(const AcceleratorScaling& accelerator, const RenderRow& row);
[[nodiscard]] const RenderRow* find_row(const AcceleratorScaling& accelerator, Schedule schedule, int threads);

// The largest waiting share of a scene's renders with no more threads than cores, which other work
// on the machine causes.
[[nodiscard]] double worst_waiting_share(const ScalingReport& report, const SceneScaling& scene);

// Fits the speed-ups at up to `cores` threads; nothing without a second number of threads.
[[nodiscard]] std::optional<AmdahlFit> fit_renders(const AcceleratorScaling& accelerator, Schedule schedule, int cores);

// The scaling of a phase over all accelerators; only the last phase has one entry for each
// accelerator.
struct PhaseScaling {
  std::string name; // "geometry", "accelerator kdtree", "all with kdtree"
  struct Point {
    int threads = 1;
    Summary wall_s;
    double speedup = 0.0;     // by rounds, as for renders; 0 if not measured
    double parallelism = 0.0; // CPU time over wall time: the number of cores used
  };
  std::vector<Point> points; // by increasing threads
};
// The phases that took any time, then their sum.
[[nodiscard]] std::vector<PhaseScaling> summarize_phases(const SceneScaling& scene);

// The figures of a device, medians over the rounds; ratios are medians of the ratios within rounds.
struct DeviceSummary {
  Summary alone_s, shared_s;
  double start_s = 0.0;
  double samples_per_s = 0.0;        // of the render phase without the start
  double rays_per_s = 0.0;           // likewise
  double shared_samples_per_s = 0.0; // of all
  double shared_speedup = 0.0;       // over the device alone
  double processor_share = 0.0;      // of the last shared frame
  double processor_s = 0.0, device_s = 0.0, merge_s = 0.0;
  struct Processor {
    int threads = 1;
    double median_s = 0.0;
    double samples_per_s = 0.0;
    double ratio = 0.0; // of the times, T(threads) / T(device without the start)
  };
  std::vector<Processor> processors; // by increasing threads, whose first schedule is meant
};
[[nodiscard]] DeviceSummary summarize_device(const ScalingReport& report, const SceneScaling& scene);

// An image that differs from the first one of its accelerator, which is an error. Those of a
// device, alone or merged, must be the kd-tree's.
struct ImageMismatch {
  std::string renderer;             // "kdtree", "gpu", "gpu and processor"
  std::optional<Schedule> schedule; // unset for devices
  int threads = 1;                  // of the processor; 0: none
  size_t round = 0;
};
[[nodiscard]] std::vector<ImageMismatch> find_mismatches(const SceneScaling& scene);

// The geometric mean and the minimum of the efficiencies over all scenes.
struct EfficiencySummary {
  std::string accelerator;
  Schedule schedule = Schedule::tiles;
  int threads = 1;
  double mean = 0.0;
  double worst = 0.0;
  std::string worst_scene;
  double mean_idle_share = 0.0; // arithmetic mean
};
[[nodiscard]] std::vector<EfficiencySummary> summarize_scenes(const ScalingReport& report);

// The published speed-ups of static regions, read as T(1) / T(n): Xia, "Research on ray tracing"
// (2011), section on the multi-core ray tracer, figure 1 at 900 x 675 pixels. The paper has no idle
// times.
struct PaperSpeedup {
  int threads = 1;
  double low = 1.0, high = 1.0;
  std::string_view processor;
};
[[nodiscard]] std::span<const PaperSpeedup> paper_speedups();

// The file name without its folder.
[[nodiscard]] std::string scene_name(const SceneScaling& scene);

// "gpu", "gpu and processor".
[[nodiscard]] std::string device_renderer(const DeviceScaling& device, bool shared);
// The table of a device and its comparison with threads; empty without one.
[[nodiscard]] std::string format_device_scaling(const ScalingReport& report, const SceneScaling& scene);

// The tables of one scene for a terminal; ends with '\n'.
[[nodiscard]] std::string format_scaling_tables(const ScalingReport& report, const SceneScaling& scene);
// The table of all scenes.
[[nodiscard]] std::string format_scaling_summary(const ScalingReport& report);
// README.md describes the keys and columns.
[[nodiscard]] std::string format_scaling_json(const ScalingReport& report);
[[nodiscard]] std::string format_scaling_csv(const ScalingReport& report);
// Curves of speed-up and efficiency over threads, a panel for each scene; a self-contained SVG.
[[nodiscard]] std::string draw_scaling(const ScalingReport& report);

} // namespace kindling::app
