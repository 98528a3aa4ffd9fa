// `kindling render`, phase by phase: check, load, build, render, write, report.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/command_render.h"

#include "renderer/app/choose.h"
#include "renderer/app/exit_code.h"
#include "renderer/app/load_environment.h"
#include "renderer/app/outputs.h"
#include "renderer/app/process_info.h"
#include "renderer/app/progress_display.h"
#include "renderer/app/replay.h"
#include "renderer/app/report.h"
#include "renderer/app/signals.h"
#include "renderer/camera/camera.h"
#include "renderer/import/load_gltf.h"
#include "renderer/scene/animated_members.h"
#include "renderer/session/render_session.h"
#include "renderer/texture/texture_memory.h"
#include "renderer/world/build_world.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_group.h>

#include <chrono>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// One run of the command: what its phases hand to each other.
class RenderCommand {
 public:
  RenderCommand(const RenderOptions& options, const std::string& command_line, Console& console)
      : options_(options), console_(console), signals_(cancel_),
        display_(console, options.progress, progress_context(options, signals_)) {
    report_.command_line = command_line;
    report_.scene_file = options.scene_file.string();
  }

  Result<int> run() {
    if (Result<void> done = check(); !done.ok()) return done.error();
    if (Result<void> done = load(); !done.ok()) return done.error();
    if (interrupted_early()) return exit_code_of_signal(signals_.received());
    if (Result<void> done = build(); !done.ok()) {
      if (interrupted_early()) return exit_code_of_signal(signals_.received());
      return done.error();
    }
    if (interrupted_early()) return exit_code_of_signal(signals_.received());
    return options_.replay_pixel ? replay() : render_and_write();
  }

 private:
  static ProgressContext progress_context(const RenderOptions& options, const SignalGuard& signals) {
    const bool endless = options.time_limit_s && !options.spp;
    return {endless ? std::nullopt : std::optional(options.samples_per_pixel()), &signals};
  }

  // All that can be refused before any work.
  Result<void> check() {
    if (!options_.replay_pixel) {
      Result<std::vector<fs::path>> outputs = choose_outputs(options_);
      if (!outputs.ok()) return outputs.error();
      outputs_ = std::move(outputs).value();
      if (!options_.stats_file.empty())
        if (Result<void> writable = check_writable(options_.stats_file); !writable.ok())
          return Error{writable.error().kind, "--stats: " + writable.error().message};
      DisplayOptions display_options;
      display_options.view = options_.view;
      display_options.exposure_stops = static_cast<float>(options_.exposure_stops);
      display_options.ocio_config = options_.ocio_config;
      Result<DisplayTransform> view = DisplayTransform::create(display_options);
      if (!view.ok()) return view.error();
      view_ = std::move(view).value();
    }
    return {};
  }

  // The scene, its pose and its camera; the environment is read at the same time.
  Result<void> load() {
    const Clock::time_point start = Clock::now();
    display_.start_phase(Phase::load);
    if (options_.texture_memory_bytes) texture_memory_.emplace(*options_.texture_memory_bytes);
    ImportOptions import_options;
    import_options.texture_memory = texture_memory_ ? &*texture_memory_ : nullptr;
    std::optional<Result<EnvironmentPointer>> environment;
    tbb::task_group group;
    group.run([&] { environment.emplace(load_environment(options_)); });
    Result<Scene> scene = load_gltf(options_.scene_file, import_options, &display_);
    group.wait();
    if (!scene.ok()) return scene.error();
    if (!environment->ok()) return environment->error();
    scene_ = std::move(scene).value();
    environment_ = environment->value();
    report_.scene_hash = scene_.content_hash;
    report_.times.load_s = seconds_since(start);
    report_.times.textures_s = display_.textures_s();
    display_.end_phase();

    const Clock::time_point pose_start = Clock::now();
    const Result<int> root = choose_scene(scene_, options_.scene_name);
    if (!root.ok()) return root.error();
    if (const Result<int> variant = show_variant(scene_, options_.variant_name); !variant.ok()) return variant.error();
    apply_light_options(options_.lights, scene_);
    const Result<std::optional<Shutter>> shutter = choose_shutter(scene_, root.value(), options_);
    if (!shutter.ok()) return shutter.error();
    report_.shutter = shutter.value();
    const std::optional<double> time_s = time_of_picture(shutter.value(), options_);
    if (time_s) animate_members(scene_, *time_s);
    Result<PosedScene> posed = pose_scene(scene_, {root.value(), time_s, shutter.value()});
    if (!posed.ok()) return posed.error();
    posed_ = std::move(posed).value();
    Result<std::optional<PlacedCamera>> camera = choose_camera(scene_, posed_, options_);
    if (!camera.ok()) return camera.error();
    placed_camera_ = std::move(camera).value();
    if (placed_camera_)
      if (Result<void> overridden = override_lens(placed_camera_->camera, options_.lens); !overridden.ok())
        return overridden.error();
    const Result<V2i> size = choose_size(placed_camera_ ? &placed_camera_->camera : nullptr, options_);
    if (!size.ok()) return size.error();
    size_px_ = size.value();
    report_.times.build_s = seconds_since(pose_start);
    return {};
  }

  Result<void> build() {
    const Clock::time_point start = Clock::now();
    display_.start_phase(Phase::build);
    WorldOptions world_options;
    world_options.accelerator = options_.accelerator;
    world_options.quality = options_.quality;
    world_options.environment = environment_;
    world_options.texture_memory = texture_memory_ ? &*texture_memory_ : nullptr;
    Result<std::unique_ptr<const World>> world =
        build_world(std::move(scene_), std::move(posed_), world_options, &cancel_, &display_);
    if (!world.ok()) return world.error();
    world_ = std::move(world).value();
    if (!placed_camera_) {
      const float aspect = static_cast<float>(size_px_.x) / static_cast<float>(size_px_.y);
      placed_camera_ = fit_camera(world_->bounds(), aspect);
      if (Result<void> overridden = override_fov(placed_camera_->camera, options_); !overridden.ok())
        return overridden.error();
      if (Result<void> overridden = override_lens(placed_camera_->camera, options_.lens); !overridden.ok())
        return overridden.error();
      display_.on_warning(report_.scene_file + ": no camera: seen through one fitted to the scene's bounds");
    }
    const Result<std::string> focus = focus_lens(*placed_camera_, *world_, size_px_, options_.lens);
    if (!focus.ok()) return focus.error();
    if (!focus.value().empty()) console_.detail(focus.value());
    camera_.emplace(
        placed_camera_->camera, placed_camera_->camera_to_world, size_px_,
        CameraMotion{.later_transforms = placed_camera_->later_transforms, .shutter_open = world_->has_motion()});
    report_.times.build_s += seconds_since(start);
    display_.end_phase();
    console_.detail(
        fmt::format("{}: {} triangles, {} instances, built in {:.3f} s", accel::kind_description(options_.accelerator),
                    world_->statistics().accelerator.triangle_count, world_->statistics().accelerator.instance_count,
                    world_->statistics().accelerator.build_s));
    if (report_.shutter) console_.detail(describe_motion(world_->statistics().motion));
    return {};
  }

  [[nodiscard]] RenderSettings settings() const {
    RenderSettings settings;
    settings.integrator = options_.integrator;
    settings.size_px = size_px_;
    settings.crop = options_.crop;
    settings.samples_per_pixel = options_.samples_per_pixel();
    settings.adaptive = options_.adaptive;
    settings.outliers = options_.outliers;
    settings.time_limit_s = options_.time_limit_s;
    settings.seed = options_.seed;
    settings.guiding = options_.guiding;
    settings.sampler = options_.sampler;
    settings.filter = PixelFilter(options_.filter);
    settings.aovs = options_.aovs;
    if (settings.adaptive.enabled()) settings.aovs.insert(Aov::samples);
    settings.threads = options_.threads;
    settings.tile_size_px = options_.tile_size_px;
    settings.schedule = options_.schedule;
    return settings;
  }

  Result<int> replay() {
    const Result<ReplayedSample> sample =
        replay_sample(*world_, *camera_, settings(), *options_.replay_pixel, options_.replay_sample);
    if (!sample.ok()) return sample.error();
    if (Result<void> printed = print(format_replay(sample.value(), *options_.replay_pixel, options_.replay_sample));
        !printed.ok())
      return printed.error();
    return kExitOk;
  }

  Result<int> render_and_write() {
    display_.start_phase(Phase::render);
    report_.times.before_render_s = seconds_since_process_start();
    Result<RenderOutcome> outcome = render(*world_, *camera_, settings(), &cancel_, &display_);
    display_.end_phase();
    if (!outcome.ok()) return outcome.error();
    if (const std::string failure = texture_memory_ ? texture_memory_->failure() : ""; !failure.empty())
      return Error{ErrorKind::input_output, "--texture-memory: textures could not be read back: " + failure};
    fill_report(outcome.value());
    warn_of_non_finite(outcome.value().statistics.rays);
    const int code = outcome.value().interrupted ? exit_code_of_signal(signals_.received()) : kExitOk;
    if (outcome.value().statistics.samples_per_pixel == 0) {
      console_.note("interrupted before every pixel had a sample: nothing was written");
      return code;
    }
    const Result<void> written = write(outcome.value().film);
    report_.times.total_s = seconds_since_process_start();
    report_.peak_resident_bytes = peak_resident_bytes();
    report_.warnings = console_.warning_count();
    const Result<void> stats = write_stats();
    if (!console_.settings().json)
      console_.line(format_summary(report_));
    else
      console_.line(format_stats_json(report_, true));
    if (!written.ok()) return written.error();
    if (!stats.ok()) return stats.error();
    return code;
  }

  // Every file is tried, so that a full disk costs no more than it must; the first error is returned, others are
  // printed.
  Result<void> write(const Film& film) {
    const Clock::time_point start = Clock::now();
    display_.start_phase(Phase::write);
    const ImageMetadata metadata = make_metadata(report_, *camera_);
    Result<void> first_error;
    for (size_t i = 0; i < outputs_.size(); ++i) {
      Result<void> written = write_film(outputs_[i], film, *view_, metadata, {options_.exr_half, options_.png_bits});
      if (written.ok()) {
        report_.outputs.push_back(outputs_[i].string());
      } else if (first_error.ok()) {
        first_error = written;
      } else {
        console_.error(written.error().message);
      }
      display_.on_progress({.phase = Phase::write, .done = i + 1.0, .total = static_cast<double>(outputs_.size())});
    }
    display_.end_phase();
    report_.times.write_s = seconds_since(start);
    std::string names; // after the status line is gone: both streams may be the same terminal
    for (const std::string& output : report_.outputs) names += output + "\n";
    const Result<void> printed = print(names);
    return first_error.ok() ? printed : first_error;
  }

  Result<void> write_stats() {
    if (options_.stats_file.empty()) return {};
    return write_text_file(options_.stats_file, format_stats_json(report_, false) + "\n");
  }

  static Result<void> print(const std::string& text) {
    std::string reason;
    if (write_standard_output(text, reason)) return {};
    return Error{ErrorKind::input_output, "standard output: " + reason};
  }

  void fill_report(const RenderOutcome& outcome) {
    report_.size_px = size_px_;
    report_.crop = outcome.film.crop();
    report_.spp_wanted = options_.samples_per_pixel();
    report_.adaptive = options_.adaptive;
    report_.mean_spp =
        static_cast<double>(outcome.film.total_samples()) / static_cast<double>(report_.crop.pixel_count());
    report_.seed = options_.seed;
    report_.integrator = integrator_name(options_.integrator.kind);
    if (options_.integrator.kind == IntegratorKind::whitted) report_.whitted = options_.integrator.whitted;
    report_.guiding = options_.guiding;
    report_.schedule = options_.schedule;
    report_.accelerator = accel::kind_name(options_.accelerator);
    report_.accelerator_description = accel::kind_description(options_.accelerator);
    report_.view = view_->view();
    report_.interrupted = outcome.interrupted;
    report_.statistics = outcome.statistics;
    report_.times.render_s = outcome.statistics.render_s;
    report_.world = world_->statistics();
    report_.film_bytes = outcome.film.memory_bytes();
  }

  void warn_of_non_finite(const RayCounters& rays) {
    if (rays.non_finite == 0 || !rays.first_non_finite) return;
    const auto& [pixel, sample] = *rays.first_non_finite;
    display_.on_warning(fmt::format("non-finite radiance at pixel ({}, {}), sample {} ({} samples dropped in all); "
                                    "replay: {} --pixel {},{} --sample {}",
                                    pixel.x, pixel.y, sample, rays.non_finite, report_.command_line, pixel.x, pixel.y,
                                    sample));
  }

  // A signal before the render: there is nothing to write yet.
  bool interrupted_early() {
    if (signals_.received() == 0) return false;
    display_.end_phase();
    console_.note("interrupted before the render: nothing was written");
    return true;
  }

  const RenderOptions& options_;
  Console& console_;
  CancelToken cancel_;
  SignalGuard signals_;
  ProgressDisplay display_;
  RenderReport report_;

  std::vector<fs::path> outputs_;
  std::optional<DisplayTransform> view_;
  Scene scene_;
  PosedScene posed_;
  EnvironmentPointer environment_;
  std::optional<PlacedCamera> placed_camera_;
  V2i size_px_{0, 0};
  std::optional<TextureMemory> texture_memory_; // outlives the world
  std::unique_ptr<const World> world_;
  std::optional<Camera> camera_;
};

} // namespace

Result<int> run_render(const RenderOptions& options, const std::string& command_line, Console& console) {
  std::optional<tbb::global_control> limit;
  if (options.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(options.threads));
  return RenderCommand(options, command_line, console).run();
}

} // namespace kindling::app
