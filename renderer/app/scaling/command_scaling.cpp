// The steps of `kindling scaling`, scene by scene: warm up, measure round by round, report.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/command_scaling.h"

#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/scaling/scaling_device.h"
#include "renderer/app/scaling/scaling_measure.h"
#include "renderer/app/scaling/scaling_report.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>
#include <tbb/info.h>

#include <algorithm>
#include <chrono>

#include <unistd.h>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

// Prints the warnings of the first loading of a scene. Progress is shown by ScalingProgress.
class WarningsOnly final : public ProgressListener {
 public:
  explicit WarningsOnly(Console& console) : console_(console) {}
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override { console_.warning(message); }
  void on_info(std::string_view message) override { console_.detail(message); }

 private:
  Console& console_;
};

// Shows the current measurement and the remaining time: a status line on a terminal, else a line
// every few seconds.
class ScalingProgress {
 public:
  ScalingProgress(Console& console, size_t scenes)
      : console_(console), terminal_(isatty(STDERR_FILENO) == 1), scenes_(scenes) {}

  // Starts a scene. `expected` is the cost of its measurements in any unit, that of step_done().
  void start_scene(double expected) {
    expected_ = expected;
    done_ = 0.0;
    ++scene_;
    scene_start_ = Clock::now();
  }
  void show(const std::string& next) {
    std::string text = "kindling: " + next;
    const double elapsed_s = std::chrono::duration<double>(Clock::now() - scene_start_).count();
    if (done_ > 0.0) {
      text += fmt::format(", {} left", format_seconds(elapsed_s * std::max(0.0, expected_ / done_ - 1.0)));
      if (scenes_ > scene_)
        text += fmt::format(" of this scene, {} more scene{}", scenes_ - scene_, scenes_ - scene_ == 1 ? "" : "s");
    }
    constexpr auto kInterval = std::chrono::seconds(10);
    if (terminal_) {
      console_.status(text);
    } else if (console_.settings().verbose || Clock::now() - shown_ >= kInterval) {
      shown_ = Clock::now();
      console_.line(text);
    }
  }
  void step_done(double expected) { done_ += expected; }
  void clear() {
    if (terminal_) console_.status({});
  }

 private:
  using Clock = std::chrono::steady_clock;
  Console& console_;
  bool terminal_;
  size_t scenes_, scene_ = 0;
  double expected_ = 0.0, done_ = 0.0;
  Clock::time_point scene_start_ = Clock::now(), shown_ = Clock::now();
};

class ScalingCommand {
 public:
  ScalingCommand(const ScalingOptions& options, const std::string& command_line, Console& console)
      : options_(options), console_(console), warnings_(console), signals_(cancel_),
        progress_(console, options.scene_files.size()) {
    report_.command_line = command_line;
    report_.processor = processor_name();
    report_.cores = tbb::info::default_concurrency();
    report_.integrator = integrator_name(options.image.integrator.kind);
    report_.repeat = options.repeat;
    report_.schedules = options.schedules;
    report_.thread_counts = options.thread_counts;
    if (report_.thread_counts.empty())
      report_.thread_counts = default_thread_counts(options.max_threads > 0 ? options.max_threads : report_.cores);
  }

  Result<int> run() {
    if (Result<void> checked = check(); !checked.ok()) return checked.error();
    if (options_.device) {
      Result<std::string> name = try_device(*options_.device, [this](const std::string& line) { console_.note(line); });
      if (!name.ok()) return name.error();
      device_name_ = std::move(name).value();
    }
    for (const fs::path& file : options_.scene_files) {
      Result<SceneScaling> scene = measure_scene(file);
      progress_.clear();
      report_.interrupted = signals_.received() != 0;
      if (!scene.ok()) return scene.error();
      if (!has_renders(scene.value())) break; // interrupted
      const std::string tables = format_scaling_tables(report_, scene.value());
      if (Result<void> printed = print((report_.scenes.empty() ? "" : "\n") + tables); !printed.ok())
        return printed.error();
      report_.scenes.push_back(std::move(scene).value());
      if (report_.interrupted) break;
    }
    if (report_.scenes.size() > 1)
      if (Result<void> printed = print(format_scaling_summary(report_)); !printed.ok()) return printed.error();
    if (report_.interrupted)
      console_.note(report_.scenes.empty() ? "interrupted before anything was measured: no report was written"
                                           : "interrupted: the reports hold the measurements made so far");
    if (!report_.scenes.empty())
      if (Result<void> written = write(); !written.ok()) return written.error();
    if (signals_.received() != 0) return exit_code_of_signal(signals_.received());
    for (const SceneScaling& scene : report_.scenes)
      if (!find_mismatches(scene).empty())
        return Error{ErrorKind::render_failed, scene.file + ": the image depends on the number of threads, the "
                                                            "schedule or the device, which is an error in Kindling"};
    return kExitOk;
  }

 private:
  struct Report {
    const char* flag;
    const fs::path* file;
    std::string (*format)(const ScalingReport&);
  };
  [[nodiscard]] std::array<Report, 3> reports() const {
    return {{{"--json", &options_.json_file, format_scaling_json},
             {"--csv", &options_.csv_file, format_scaling_csv},
             {"--svg", &options_.svg_file, draw_scaling}}};
  }

  // Finds errors in file names before any work.
  [[nodiscard]] Result<void> check() const {
    std::vector<NamedFile> written;
    for (const Report& report : reports()) {
      if (report.file->empty() || *report.file == kStandardOutput) continue;
      if (Result<void> writable = check_writable(*report.file); !writable.ok())
        return Error{writable.error().kind, fmt::format("{}: {}", report.flag, writable.error().message)};
      written.push_back({report.flag, *report.file});
    }
    if (Result<void> differ = check_outputs_differ(written); !differ.ok()) return differ;
    return check_scenes_remain(written, files_read(options_.image), options_.scene_files, options_.image);
  }
  [[nodiscard]] Result<void> write() const {
    for (const Report& report : reports())
      if (!report.file->empty())
        if (Result<void> written = write_text_file(*report.file, report.format(report_)); !written.ok()) return written;
    return {};
  }

  static bool has_renders(const SceneScaling& scene) {
    for (const AcceleratorScaling& accelerator : scene.accelerators)
      for (const RenderRow& row : accelerator.renders)
        if (!row.samples.empty()) return true;
    return false;
  }

  // The expected seconds of the steps on one thread, from the warm-up.
  struct Costs {
    double prepare_s = 0.0;
    double render_s = 0.0;
  };
  [[nodiscard]] double expected_s(const Costs& costs, const ScalingStep& step) const {
    const int threads = std::min(report_.thread_counts[step.threads], report_.cores);
    return (costs.prepare_s + costs.render_s * static_cast<double>(step.schedules.size())) / threads;
  }

  [[nodiscard]] RenderOptions image_of(const fs::path& file, const AcceleratorVariant& variant) const {
    RenderOptions image = options_.image;
    image.scene_file = file;
    image.accelerator = variant.kind;
    image.quality = variant.quality;
    image.robust = variant.robust;
    image.simd = variant.simd;
    return image;
  }

  // Loads and renders once, so that files are cached and clock rates are up, and chooses the
  // samples per pixel.
  Result<Costs> warm_up(const fs::path& file, SceneScaling& scene) {
    const int threads = std::min(report_.thread_counts.back(), report_.cores);
    progress_.show(fmt::format("{}: warming up", file.filename().string()));
    Result<std::unique_ptr<ScalingStage>> stage =
        prepare_stage(image_of(file, options_.accelerators.front()), threads, &warnings_);
    if (!stage.ok()) return stage.error();
    const WorldStatistics& world = stage.value()->built.world->statistics();
    scene.size_px = stage.value()->built.size_px;
    scene.triangle_count = world.accelerator.triangle_count;
    scene.instance_count = world.accelerator.instance_count;
    scene.geometry_bytes = world.geometry_bytes;
    scene.texture_bytes = world.texture_bytes;
    scene.light_bytes = world.light_bytes;
    Result<RenderSample> one =
        measure_render(*stage.value(), options_.image, 1, options_.schedules.front(), threads, &scene.film_bytes);
    if (!one.ok()) return one.error();
    const double sample_s = one.value().time.cpu_s;
    scene.samples_per_pixel =
        options_.seconds ? samples_for(*options_.seconds, sample_s) : options_.image.samples_per_pixel();
    return Costs{stage.value()->times.total().cpu_s, sample_s * scene.samples_per_pixel};
  }

  Result<SceneScaling> measure_scene(const fs::path& file) {
    SceneScaling scene;
    scene.file = file.string();
    progress_.start_scene(0.0);
    Result<Costs> costs = warm_up(file, scene);
    if (!costs.ok()) return costs.error();
    for (const AcceleratorVariant& variant : options_.accelerators) {
      AcceleratorScaling& accelerator = scene.accelerators.emplace_back();
      accelerator.variant = variant;
      for (const int threads : report_.thread_counts) accelerator.preparations.push_back({threads, {}});
      for (const Schedule schedule : report_.schedules)
        for (const int threads : report_.thread_counts) accelerator.renders.push_back({threads, schedule, {}});
    }
    if (options_.device) {
      const auto tree =
          std::find_if(options_.accelerators.begin(), options_.accelerators.end(),
                       [](const AcceleratorVariant& variant) { return variant.kind == accel::Kind::kdtree; });
      scene.device = DeviceScaling{
          *options_.device, device_name_, static_cast<size_t>(tree - options_.accelerators.begin()), {}, {}};
    }
    const std::vector<ScalingStep> steps = scaling_steps(options_.repeat, scene.accelerators.size(),
                                                         report_.thread_counts.size(), report_.schedules.size());
    double expected = 0.0;
    for (const ScalingStep& step : steps) expected += expected_s(costs.value(), step);
    progress_.start_scene(expected);
    for (const ScalingStep& step : steps) {
      if (signals_.received() != 0) break;
      if (Result<void> measured = measure_step(file, step, scene); !measured.ok()) return measured.error();
      progress_.step_done(expected_s(costs.value(), step));
    }
    return scene;
  }

  Result<void> measure_step(const fs::path& file, const ScalingStep& step, SceneScaling& scene) {
    AcceleratorScaling& accelerator = scene.accelerators[step.accelerator];
    const int threads = report_.thread_counts[step.threads];
    const auto show = [&](std::string_view what) {
      progress_.show(fmt::format("{}: round {} of {}, {}, {} thread{}, {}", file.filename().string(), step.round + 1,
                                 options_.repeat, accelerator.variant.name(), threads, threads == 1 ? "" : "s", what));
    };
    show("loading");
    Result<std::unique_ptr<ScalingStage>> stage = prepare_stage(image_of(file, accelerator.variant), threads, nullptr);
    if (!stage.ok()) return stage.error();
    accelerator.preparations[step.threads].samples.push_back(stage.value()->times);
    accelerator.accelerator_bytes = stage.value()->built.world->statistics().accelerator.memory_bytes;
    for (const size_t schedule : step.schedules) {
      if (signals_.received() != 0) break;
      show(schedule_name(report_.schedules[schedule]));
      Result<RenderSample> sample = measure_render(*stage.value(), options_.image, scene.samples_per_pixel,
                                                   report_.schedules[schedule], threads, nullptr);
      if (!sample.ok()) return sample.error();
      accelerator.renders[schedule * report_.thread_counts.size() + step.threads].samples.push_back(sample.value());
    }
    const bool is_largest_count = step.threads + 1 == report_.thread_counts.size();
    if (scene.device && scene.device->accelerator == step.accelerator && is_largest_count)
      return measure_device_step(*stage.value(), scene, show);
    return {};
  }

  // Measures the device alone, and with the processor.
  template <typename Show>
  Result<void> measure_device_step(const ScalingStage& stage, SceneScaling& scene, const Show& show) {
    DeviceScaling& device = *scene.device;
    const int threads = report_.thread_counts.back();
    const std::string name = device_renderer(device, false);
    if (device.alone.empty() && signals_.received() == 0) { // as for the processor
      show(name + ", warming up");
      if (Result<DeviceSample> warm = measure_device(stage, options_.image, 1, device.kind, threads); !warm.ok())
        return warm.error();
    }
    if (signals_.received() != 0) return {};
    show(name);
    Result<DeviceSample> alone = measure_device(stage, options_.image, scene.samples_per_pixel, device.kind, threads);
    if (!alone.ok()) return alone.error();
    device.alone.push_back(alone.value());
    if (signals_.received() != 0) return {};
    show(device_renderer(device, true));
    // One thread leads the device.
    const RenderRow* processor = find_row(scene.accelerators[device.accelerator], report_.schedules.front(), threads);
    const double threads_s =
        processor->samples.empty() ? 0.0 : processor->samples.back().time.wall_s * threads / std::max(1, threads - 1);
    Result<SharedSample> shared = measure_shared(stage, options_.image, scene.samples_per_pixel, device.kind,
                                                 std::max(1, threads - 1), balanced_share(device, threads_s));
    if (!shared.ok()) return shared.error();
    device.shared.push_back(shared.value());
    return {};
  }

  const ScalingOptions& options_;
  Console& console_;
  WarningsOnly warnings_;
  CancelToken cancel_; // not read: a measurement that has begun is finished
  SignalGuard signals_;
  ScalingProgress progress_;
  ScalingReport report_;
  std::string device_name_; // of --device
};

} // namespace

Result<int> run_scaling(const ScalingOptions& options, const std::string& command_line, Console& console) {
  return ScalingCommand(options, command_line, console).run();
}

} // namespace kindling::app
