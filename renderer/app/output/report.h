// The report of a render: a summary for people, JSON for programs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/facade/load_environment.h"
#include "renderer/film/film.h"
#include "renderer/import/load_gltf.h"
#include "renderer/integrator/integrator.h"
#include "renderer/scene/shutter.h"
#include "renderer/session/checkpoint.h"
#include "renderer/session/render_session.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// Wall times of the phases, seconds.
struct PhaseTimes {
  double load_s = 0.0;          // reading, decoding and validating files, the environment included
  ImportTimes import;           // parts of load_s
  EnvironmentTimes environment; // in parallel with these
  double build_s = 0.0;         // posing, lights, materials and the accelerator
  double render_s = 0.0;
  double denoise_s = 0.0;
  double write_s = 0.0;
  double total_s = 0.0;         // since the process was started, or since the frame before
  double before_render_s = 0.0; // from the same moment to the first camera ray
};

struct RenderReport {
  std::string command_line;
  std::string scene_file;
  uint64_t scene_hash = 0;
  std::optional<int> frame;     // number of the frame with --frames
  std::optional<double> time_s; // time of the animations; unset: the rest pose
  V2i size_px{0, 0};
  PixelRect crop;
  std::optional<Shutter> shutter; // in times of the animations
  uint32_t spp_wanted = 0;
  AdaptiveSettings adaptive;
  double mean_spp = 0.0; // over the pixels of the crop
  uint32_t seed = 0;
  std::string integrator;
  std::optional<WhittedSettings> whitted; // set for this integrator
  Guiding guiding = Guiding::off;
  Schedule schedule = Schedule::tiles;
  std::string accelerator;             // as --accel takes it
  std::string accelerator_description; // "Embree 3.13.5"
  std::string view;
  bool interrupted = false;
  std::optional<CheckpointReport> checkpoint;
  PhaseTimes times;
  RenderStatistics statistics;
  WorldStatistics world;
  uint64_t film_bytes = 0;
  uint64_t peak_resident_bytes = 0;
  uint64_t warnings = 0;
  std::vector<std::string> outputs;

  // Seconds from the start of the process until every pixel had its first sample.
  [[nodiscard]] double time_to_first_pixel_s() const { return times.before_render_s + statistics.first_pass_s; }
  [[nodiscard]] double rays_per_s() const { return per_second(statistics.rays.total()); }
  [[nodiscard]] double paths_per_s() const { return per_second(statistics.rays.paths); }

 private:
  [[nodiscard]] double per_second(uint64_t count) const {
    return statistics.render_s > 0.0 ? static_cast<double>(count) / statistics.render_s : 0.0;
  }
};

// "motion: 3 instances that move, 1 mesh that deforms, 9 keys at most, 1.2 MiB"
[[nodiscard]] std::string describe_motion(const MotionStatistics& motion);
// Several lines without a final '\n'.
[[nodiscard]] std::string format_summary(const RenderReport& report);
// README.md describes the keys, which do not change.
[[nodiscard]] std::string format_stats_json(const RenderReport& report, bool one_line);

} // namespace kindling::app
