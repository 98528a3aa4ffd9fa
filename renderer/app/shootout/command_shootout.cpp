// The steps of a shootout, scene by scene: load, record rays, build, trace, report.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/command_shootout.h"

#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/shootout/race_scene.h"
#include "renderer/app/shootout/shootout_compare.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/app/shootout/shootout_summary.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/terminal/signals.h"
#include "renderer/app/text/text_format.h"
#include "renderer/camera/camera.h"
#include "renderer/device/failure_reason.h"
#include "renderer/device/make_device.h"
#include "renderer/facade/render_scene.h"
#include "renderer/facade/render_stage.h"
#include "renderer/session/npz_rays.h"
#include "renderer/session/ray_file.h"
#include "renderer/session/record_rays.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <unistd.h>

#include <algorithm>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

// A prepared scene: world, camera, image size.
struct Stage {
  std::unique_ptr<RenderScene> scene;       // owns the world
  RecordingAccelerator* recorder = nullptr; // owned by the world
  RenderStage built;
};

class ShootoutCommand {
 public:
  ShootoutCommand(const ShootoutOptions& options, const std::string& command_line, Console& console)
      : options_(options), console_(console), terminal_(isatty(STDERR_FILENO) == 1), signals_(cancel_),
        display_(console, terminal_ ? ProgressMode::automatic : ProgressMode::none, {std::nullopt, &signals_}) {
    report_.command_line = command_line;
    report_.processor = processor_name();
    report_.clock = options.clock;
    report_.build_threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
    report_.repeat = options.repeat;
    report_.build_repeat = options.build_repeat;
    report_.batch_size = options.batch_size;
  }

  Result<int> run() {
    if (Result<void> checked = check(); !checked.ok()) return checked.error();
    if (Result<void> opened = open_raced_device(); !opened.ok()) return opened.error();
    for (size_t i = 0; i < options_.scene_files.size(); ++i) {
      Result<SceneResult> scene = race(options_.scene_files[i]);
      if (signals_.received() != 0) return interrupted();
      if (!scene.ok()) return scene.error();
      const std::string tables = format_scene_tables(report_, scene.value());
      if (Result<void> printed = print((i > 0 ? "\n" : "") + tables); !printed.ok()) return printed.error();
      report_.scenes.push_back(std::move(scene).value());
    }
    if (options_.scene_files.size() > 1) {
      const std::string means = format_comparisons(
          compare_with_embree(report_), fmt::format(", geometric means of {} scenes", report_.scenes.size()));
      if (Result<void> printed = print(means); !printed.ok()) return printed.error();
    }
    if (Result<void> written = write(); !written.ok()) return written.error();
    return contestant_failed_ ? kExitRenderFailed : kExitOk;
  }

 private:
  // Finds errors in file names before any work.
  Result<void> check() {
    const std::pair<const char*, const fs::path*> files[] = {{"--json", &options_.json_file},
                                                             {"--csv", &options_.csv_file},
                                                             {"--html", &options_.html_file},
                                                             {"--record-rays", &options_.record_rays_file}};
    std::vector<NamedFile> read = files_read(options_.view), written;
    for (const auto& [flag, file] : files) {
      if (file->empty() || *file == kStandardOutput) continue;
      if (Result<void> writable = check_writable(*file); !writable.ok())
        return Error{writable.error().kind, fmt::format("{}: {}", flag, writable.error().message)};
      written.push_back({flag, *file});
    }
    for (const PluginSpec& plugin : options_.plugins) {
      std::error_code missing;
      if (!fs::is_regular_file(plugin.file, missing))
        return Error{
            ErrorKind::input_output,
            fmt::format("--plugin: {}: there is no such file; a shared library is needed", plugin.file.string())};
      read.push_back({"the file of --plugin", plugin.file});
    }
    std::error_code ignored;
    const bool recorded = !options_.rays_file.empty() && fs::exists(options_.rays_file, ignored);
    if (!options_.rays_file.empty())
      (recorded ? read : written).push_back({recorded ? "the file of --rays" : "--rays", options_.rays_file});
    if (Result<void> differ = check_outputs_differ(written); !differ.ok()) return differ;
    if (Result<void> remain = check_scenes_remain(written, read, options_.scene_files, options_.view); !remain.ok())
      return remain;
    if (options_.rays_file.empty()) return {};
    if (recorded) {
      Result<RayRecording> rays = is_npz() ? read_npz_rays(options_.rays_file) : read_ray_file(options_.rays_file);
      if (!rays.ok()) return Error{rays.error().kind, "--rays: " + rays.error().message};
      replayed_ = std::move(rays).value();
    } else if (is_npz()) {
      return Error{ErrorKind::input_output,
                   fmt::format("--rays: {}: there is no such file; rays are recorded to .kray files",
                               options_.rays_file.string())};
    } else if (Result<void> writable = check_writable(options_.rays_file); !writable.ok()) {
      return Error{writable.error().kind, "--rays: " + writable.error().message};
    }
    return {};
  }

  Result<void> open_raced_device() {
    if (!options_.device) return {};
    Result<std::unique_ptr<Device>> opened =
        open_device(*options_.device, report_.build_threads, [this](const std::string& line) { console_.note(line); });
    if (!opened.ok())
      return Error{opened.error().kind, "--device: " + failure_reason(opened.error().message) + "; leave out --device"};
    device_ = std::move(opened).value();
    return {};
  }

  // The accelerators, the device with the first kd-tree among them, and the plugins.
  void name_contestants(SceneResult& result) const {
    for (const AcceleratorVariant& variant : options_.accelerators)
      result.accelerators.emplace_back().variant = variant;
    if (device_) {
      const auto tree = std::find_if(options_.accelerators.begin(), options_.accelerators.end(),
                                     [](const auto& variant) { return variant.kind == accel::Kind::kdtree; });
      AcceleratorResult& raced = result.accelerators.emplace_back();
      raced.variant = tree != options_.accelerators.end() ? *tree : AcceleratorVariant{accel::Kind::kdtree};
      raced.device = RacedDevice{*options_.device, device_->name(), 0, {}};
    }
    for (const PluginSpec& plugin : options_.plugins) result.accelerators.emplace_back().plugin = plugin;
  }

  Result<SceneResult> race(const fs::path& file) {
    Result<Stage> prepared = prepare(file);
    if (!prepared.ok()) return prepared.error();
    const Stage& stage = prepared.value();
    SceneResult result;
    result.file = file.string();
    result.geometry_hash = hash_geometry(stage.built.world->accelerator_input());
    result.size_px = stage.built.size_px;
    Result<std::vector<RaySet>> sets = rays_of(stage, result);
    if (!sets.ok()) return sets.error();
    name_contestants(result);

    accel::BuildInput geometry = stage.built.world->accelerator_input();
    const std::vector<accel::TriangleMesh> opaque = opaque_meshes(geometry);
    if (!options_.plugins.empty() || device_) {
      geometry.meshes = opaque; // these know no hit filter
      geometry.filter = {};
    }
    const bool maps = !options_.html_file.empty() && options_.heat_map_width_px > 0;
    const SceneRace race{.settings = {options_.batch_size, options_.repeat, options_.build_repeat,
                                      report_.build_threads, options_.clock, options_.embree_calls, &geometry},
                         .limits = {options_.plugin_time_limit_s, &cancel_},
                         .device = device_.get(),
                         .heat_map = maps ? std::optional(heat_map_camera(stage)) : std::nullopt,
                         .progress = [&](const std::string& next) {
                           show(fmt::format("{}: {}", scene_name(result), next));
                           return !cancel_.cancelled();
                         }};
    const MachineReading before = read_machine();
    Result<bool> raced = race_scene(race, std::move(sets).value(), result);
    if (!raced.ok()) return raced.error();
    const bool finished = raced.value();
    result.machine = compare_readings(before, read_machine());
    show("");
    if (finished) {
      report_first_disagreements(result);
      report_faults(result);
      const accel::Statistics& statistics = result.accelerators.front().build.statistics;
      result.triangle_count = statistics.triangle_count;
      result.instance_count = statistics.instance_count;
    }
    return result;
  }

  // The meshes without their opacity, as far as they need it.
  static std::vector<accel::TriangleMesh> opaque_meshes(const accel::BuildInput& geometry) {
    std::vector<accel::TriangleMesh> meshes(geometry.meshes.begin(), geometry.meshes.end());
    for (accel::TriangleMesh& mesh : meshes) mesh.opaque = true;
    return meshes;
  }

  // Names the plugins and devices that are out of the race, and those whose answers are wrong too
  // often for rounding.
  void report_faults(const SceneResult& scene) {
    for (const AcceleratorResult& accelerator : scene.accelerators) {
      if (!accelerator.plugin && !accelerator.device) continue;
      std::string fault = accelerator.fault;
      if (const size_t wrong = wrong_answers(scene, accelerator); fault.empty() && wrong > 0)
        fault = fmt::format("lies: {} of its answers are wrong; its speed means nothing", wrong);
      if (fault.empty()) continue;
      contestant_failed_ = true;
      console_.warning(
          fmt::format("{}: the {} {}", accelerator.name(), accelerator.device ? "device" : "plugin", fault));
    }
  }

  // Prints the first disagreeing ray of each kind with -v, for a look into the rays that --rays
  // saves.
  void report_first_disagreements(const SceneResult& scene) {
    for (const AcceleratorResult& accelerator : scene.accelerators)
      for (const TraversalResult& result : accelerator.traversal)
        if (const auto& first = result.disagreements.first)
          console_.detail(fmt::format("{}, {}, {}: ray {} at {:g}, {} has it at {:g}", accelerator.name(),
                                      scene.sets[result.set].name, call_form_name(result.form), first->ray,
                                      first->found_t, scene.accelerators.front().name(), first->expected_t));
  }

  // Loads a scene, chooses its camera and its light as a render does, and builds a World whose
  // accelerator can record rays. Nothing moves, and backs of faces are shown: filters and motion
  // would be a race of their own.
  Result<Stage> prepare(const fs::path& file) {
    RenderOptions view = options_.view;
    view.accelerator = accel::Kind::embree;
    view.backfaces = Backfaces::show;
    Stage stage;
    display_.start_phase(Phase::load);
    Result<std::unique_ptr<RenderScene>> scene = load_render_scene(file, view, &display_);
    if (!scene.ok()) return scene.error();
    display_.end_phase();
    stage.scene = std::move(scene).value();
    for (SceneCamera& camera : stage.scene->scene.cameras) camera.shutter.reset();
    Result<PosedImage> posed = pose_image(*stage.scene, view);
    if (!posed.ok()) return posed.error();
    stage.scene->wrap_accelerator = [&stage](std::unique_ptr<accel::Accelerator> inner) {
      auto recorder = std::make_unique<RecordingAccelerator>(std::move(inner));
      stage.recorder = recorder.get();
      return recorder;
    };
    display_.start_phase(Phase::build);
    Result<RenderStage> built = build_stage(*stage.scene, std::move(posed).value(), view, false, &cancel_, display_);
    display_.end_phase();
    if (!built.ok()) return built.error();
    stage.scene->wrap_accelerator = nullptr;
    stage.built = std::move(built).value();
    return stage;
  }

  [[nodiscard]] bool is_npz() const { return options_.rays_file.extension() == ".npz"; }

  // The rays of the race, saved if --record-rays asks for it.
  Result<std::vector<RaySet>> rays_of(const Stage& stage, SceneResult& result) {
    Result<std::vector<RaySet>> sets = find_rays(stage, result);
    if (!sets.ok() || options_.record_rays_file.empty() || cancel_.cancelled()) return sets;
    RayRecording recording{result.geometry_hash, result.size_px, std::move(sets).value()};
    if (Result<void> written = write_ray_file(options_.record_rays_file, recording); !written.ok())
      return Error{written.error().kind, "--record-rays: " + written.error().message};
    console_.note(fmt::format("rays recorded to {}", options_.record_rays_file.string()));
    return std::move(recording.sets);
  }

  // The rays of the file of --rays; if it does not exist, rays are recorded and saved there.
  Result<std::vector<RaySet>> find_rays(const Stage& stage, SceneResult& result) {
    if (replayed_) {
      if (replayed_->geometry_hash != 0 && replayed_->geometry_hash != result.geometry_hash)
        return Error{
            ErrorKind::usage,
            fmt::format("--rays: {}: recorded in geometry {}, but {} is {}; use the scene, --scene and --time of "
                        "the recording (with points or lines the camera, --size and --point-size too), or another "
                        "name to record again",
                        options_.rays_file.string(), format_hash(replayed_->geometry_hash), result.file,
                        format_hash(result.geometry_hash))};
      console_.note(fmt::format("rays replayed from {}", options_.rays_file.string()));
      if (replayed_->size_px != V2i(0, 0)) result.size_px = replayed_->size_px;
      return std::move(replayed_->sets);
    }
    show(fmt::format("{}: recording rays", result.file));
    RecordSettings settings;
    settings.rays_per_kind = options_.rays_per_kind;
    RayRecording recording{result.geometry_hash, stage.built.size_px,
                           record_rays(*stage.built.world, *stage.recorder, *stage.built.camera, settings, &cancel_)};
    show("");
    if (!options_.rays_file.empty() && !cancel_.cancelled()) {
      if (Result<void> written = write_ray_file(options_.rays_file, recording); !written.ok())
        return Error{written.error().kind, "--rays: " + written.error().message};
      console_.note(fmt::format("rays recorded to {}", options_.rays_file.string()));
    }
    return std::move(recording.sets);
  }

  [[nodiscard]] Camera heat_map_camera(const Stage& stage) const {
    const V2i& size = stage.built.size_px;
    const auto side = [&](int full) {
      return std::max(1, full * options_.heat_map_width_px / std::max(size.x, size.y));
    };
    return {stage.built.placed_camera.camera, stage.built.placed_camera.camera_to_world,
            V2i(side(size.x), side(size.y))};
  }

  // Shows the current step in the status line of a terminal, or else as a detail. An empty text
  // removes it.
  void show(const std::string& text) {
    if (terminal_)
      console_.status(text.empty() ? text : "kindling: " + text);
    else if (!text.empty())
      console_.detail(text);
  }

  Result<void> write() {
    const std::pair<const fs::path*, std::string (*)(const ShootoutReport&)> files[] = {
        {&options_.json_file, format_shootout_json},
        {&options_.csv_file, format_shootout_csv},
        {&options_.html_file, format_shootout_html}};
    for (const auto& [file, format] : files)
      if (!file->empty())
        if (Result<void> written = write_text_file(*file, format(report_)); !written.ok()) return written.error();
    return {};
  }

  int interrupted() {
    show("");
    console_.note("interrupted: no report was written");
    return exit_code_of_signal(signals_.received());
  }

  const ShootoutOptions& options_;
  Console& console_;
  bool terminal_;
  CancelToken cancel_;
  SignalGuard signals_;
  ProgressDisplay display_;
  ShootoutReport report_;
  std::optional<RayRecording> replayed_;
  std::unique_ptr<Device> device_; // null without --device
  bool contestant_failed_ = false; // a plugin or the device
};

} // namespace

Result<int> run_shootout(const ShootoutOptions& options, const std::string& command_line, Console& console) {
  if (options.compare) {
    const Result<std::string> compared = compare_shootout_files(options.scene_files[0], options.scene_files[1]);
    if (!compared.ok()) return compared.error();
    if (Result<void> printed = print(compared.value()); !printed.ok()) return printed.error();
    return kExitOk;
  }
  std::optional<tbb::global_control> limit;
  if (options.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(options.threads));
  return ShootoutCommand(options, command_line, console).run();
}

} // namespace kindling::app
