// Renders one image step by step: pose, build, render, write, report.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/render_image.h"

#include "renderer/app/checkpoint/accumulation_outputs.h"
#include "renderer/app/flags/part_flags.h"
#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/output/render_metadata.h"
#include "renderer/app/output/replay.h"
#include "renderer/app/output/report.h"
#include "renderer/app/setup/memory_warning.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/app/text/text_format.h"
#include "renderer/facade/lens.h"
#include "renderer/facade/render_stage.h"
#include "renderer/session/checkpoint.h"
#include "renderer/session/matte_metadata.h"
#include "renderer/session/render_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

namespace kindling::app {

namespace {

constexpr double kMinRenderS = 1e-3; // of a time limit that loading has used up

class ImageRender {
 public:
  ImageRender(const ImageRequest& request, RenderScene& scene, RenderRun& run)
      : request_(request), options_(request.options), scene_(scene), run_(run),
        accumulations_(request.outputs, request.options.checkpoint) {
    report_.command_line = request.command_line;
    report_.scene_file = options_.scene_file.string();
    report_.scene_hash = scene.content_hash;
    report_.frame = request.frame;
    scene.shares_exposure =
        !options_.exposure_stops && !std::all_of(request.outputs.begin(), request.outputs.end(), is_exr);
    report_.time_s = options_.time_s;
    if (request.start_s > 0.0) return; // loading counts for the first frame
    report_.times.load_s = scene.load_s;
    report_.times.import = scene.import_times;
    report_.times.environment = scene.environment_times;
  }

  Result<ImageResult> run() {
    if (options_.checkpoint.enabled()) {
      CheckpointOptions checkpoint = options_.checkpoint;
      checkpoint.replace = (options_.frames.force || checkpoint.replace) && !checkpoint.must_exist;
      Result<std::unique_ptr<Checkpoint>> opened = Checkpoint::open(
          checkpoint, {.warning = [this](const std::string& message) { run_.console.warning(message); },
                       .note = [this](const std::string& message) { run_.console.note(message); }});
      if (!opened.ok()) return opened.error();
      checkpoint_ = std::move(opened).value();
    }
    Result<PosedImage> posed = pose_image(scene_, options_);
    if (!posed.ok()) return posed.error();
    if (Result<void> inside = check_replay_pixel(posed.value().size_px); !inside.ok()) return inside.error();
    settings_ = make_render_settings(options_, posed.value().size_px);
    if (Result<void> part = set_part(options_, settings_); !part.ok()) return part.error();
    identity_ = make_identity(options_, options_, posed.value().resolved, scene_.content_hash);
    identity_.arguments = options_.arguments;
    identity_.part = settings_.wanted_samples();
    if (checkpoint_)
      if (Result<void> begun = checkpoint_->begin(identity_); !begun.ok()) return begun.error();
    if (run_.interrupted_early()) return nothing_written();
    run_.display.start_phase(Phase::build);
    if (const std::optional<std::string> warning = warn_of_render_memory(scene_, posed.value(), options_))
      run_.display.on_warning(*warning);
    Result<RenderStage> stage =
        build_stage(scene_, std::move(posed).value(), options_, request_.more, &run_.cancel, run_.display);
    run_.display.end_phase();
    if (run_.interrupted_early()) return nothing_written();
    if (!stage.ok()) return stage.error();
    stage_ = std::move(stage).value();
    settings_.names = scene_.names;
    settings_.motion = stage_.motion;
    settings_.catchers = stage_.catchers;
    if (stage_.shutter) run_.display.on_info(describe_motion(stage_.world->statistics().motion));
    return options_.replay_pixel ? replay() : render_and_write();
  }

 private:
  [[nodiscard]] Result<void> check_replay_pixel(const V2i& size) const {
    const std::optional<V2i>& pixel = options_.replay_pixel;
    if (!pixel || (pixel->x < size.x && pixel->y < size.y)) return {};
    return usage_error(fmt::format("--pixel: {},{} is not inside the image; use 0,0 to {},{}", pixel->x, pixel->y,
                                   size.x - 1, size.y - 1));
  }

  [[nodiscard]] ImageResult nothing_written() const {
    return {exit_code_of_signal(run_.signals.received()), std::nullopt};
  }

  Result<ImageResult> replay() {
    const Result<ReplayedSample> sample =
        replay_sample(*stage_.world, *stage_.camera, settings_, *options_.replay_pixel, options_.replay_sample);
    if (!sample.ok()) return sample.error();
    if (Result<void> printed = print(format_replay(sample.value(), *options_.replay_pixel, options_.replay_sample));
        !printed.ok())
      return printed.error();
    return ImageResult{};
  }

  Result<ImageResult> render_and_write() {
    Result<RenderOutcome> outcome = render_samples();
    if (!outcome.ok()) return outcome.error();
    std::optional<RenderRun::Storing> storing;
    if (!checkpoint_) storing.emplace(run_); // with a checkpoint a later resume can write the images
    if (const std::string failure = scene_.texture_memory ? scene_.texture_memory->failure() : ""; !failure.empty())
      return Error{ErrorKind::input_output, "--texture-memory: textures could not be read back: " + failure};
    fill_report(outcome.value());
    warn_of_non_finite(outcome.value().statistics.rays);
    if (outcome.value().statistics.samples_per_pixel == 0) {
      run_.console.note("interrupted before every pixel had a sample: no image was written");
      if (Result<void> sums = checkpoint_ ? last_save() : write_accumulations(); !sums.ok()) return sums.error();
      return ImageResult{exit_code_of_signal(run_.signals.received()), std::nullopt};
    }
    const Result<void> written = write(outcome.value().film);
    report_.times.total_s = seconds_since_start();
    report_.peak_resident_bytes = peak_resident_bytes();
    report_.warnings = run_.console.warning_count();
    const Result<void> stats = write_stats();
    if (run_.console.settings().json)
      run_.console.line(format_stats_json(report_, true));
    else if (!request_.frame)
      run_.console.line(format_summary(report_));
    if (!written.ok()) return written.error();
    if (!stats.ok()) return stats.error();
    if (!last_save().ok()) return last_save().error();
    if (report_.interrupted) run_.end_deadlines();
    const int code = report_.interrupted ? exit_code_of_signal(run_.signals.received()) : kExitOk;
    return ImageResult{code, std::move(report_)};
  }

  [[nodiscard]] double seconds_since_start() const { return seconds_since_process_start() - request_.start_s; }

  Result<RenderOutcome> render_samples() {
    fill_settings();
    identity_.metadata = metadata_to_json(metadata());
    if (checkpoint_) checkpoint_->set_metadata(identity_.metadata);
    RenderContinuity continuity = checkpoint_ ? checkpoint_->continuity() : RenderContinuity{};
    accumulations_.join(identity_, continuity);
    if (continuity.save)
      continuity.save = [this, save = std::move(continuity.save)](const RenderState& state) {
        const RenderRun::Storing storing(run_);
        save(state);
      };
    if (TevPreview* const viewer = run_.viewer()) {
      viewer->start_image(image_name(), settings_.size_px, settings_.wanted_pixels());
      continuity.after_block = [viewer](const PixelRect& block, const Film& film) { viewer->take_block(block, film); };
    }
    if (options_.time_limit_total_s) limit_what_is_left(continuity);
    run_.start_render();
    run_.display.start_phase(Phase::render, checkpoint_ ? checkpoint_->done_share() : 0.0);
    report_.times.before_render_s = seconds_since_start();
    Result<RenderOutcome> outcome =
        render(*stage_.world, *stage_.camera, settings_, &run_.cancel, &run_.display, std::move(continuity));
    run_.display.end_phase();
    if (run_.viewer() && outcome.ok()) run_.viewer()->finish_image(outcome.value().film);
    return outcome;
  }

  // Returns the name that a viewer shows.
  [[nodiscard]] std::string image_name() const {
    const std::string scene = options_.scene_file.filename().string();
    return request_.frame ? fmt::format("{} frame {}", scene, *request_.frame) : scene;
  }

  // Leaves time for what follows the render.
  void limit_what_is_left(const RenderContinuity& continuity) {
    const double earlier_s = continuity.resume_from ? continuity.resume_from->work.render_s : 0.0;
    const double after_s =
        accumulations_.images().empty() ? 0.0 : predict_write_s(accumulations_.images(), options_, stage_.size_px);
    const double left_s = *options_.time_limit_total_s - seconds_since_start() - after_s;
    settings_.time_limit_s = earlier_s + std::max(left_s, kMinRenderS);
    if (left_s < kMinRenderS)
      run_.console.warning(fmt::format("--time-limit-total: {} were over when the render began, and writing takes "
                                       "about {}: every pixel gets one sample",
                                       format_seconds(seconds_since_start()), format_seconds(after_s)));
  }

  [[nodiscard]] ImageMetadata metadata() const {
    ImageMetadata metadata = make_metadata(report_, *stage_.camera);
    add_lens_metadata(stage_.placed_camera.camera.lens, metadata);
    if (scene_.names) add_matte_metadata(*scene_.names, settings_.aovs, metadata);
    if (stage_.exposure_stops) metadata.numbers[kSharedExposureKey] = static_cast<float>(*stage_.exposure_stops);
    return metadata;
  }

  Result<void> write(const Film& film) {
    const ImageMetadata facts = metadata();
    WrittenImages written = write_images(
        accumulations_.images(), film,
        {*request_.view, facts, options_, run_.display, run_.console, &run_.cancel, request_.frame_pixels});
    report_.interrupted |= written.denoising_cancelled;
    report_.times.denoise_s = written.denoise_s;
    report_.times.write_s = written.write_s;
    return finish(std::move(written));
  }

  // Writes only .kacc files: there are too few samples for images.
  Result<void> write_accumulations() { return finish({}); }

  Result<void> finish(WrittenImages written) {
    accumulations_.finish(written);
    report_.outputs = std::move(written.files);
    std::string names; // after the status line is cleared: both streams may be one terminal
    for (const std::string& output : report_.outputs) names += output + "\n";
    const Result<void> printed = print(names);
    return written.first_error ? Result<void>(*written.first_error) : printed;
  }

  Result<void> write_stats() {
    if (options_.stats_file.empty()) return {};
    return write_text_file(options_.stats_file, format_stats_json(report_, false) + "\n");
  }

  // If the last save failed, images are written first and then its error is returned.
  [[nodiscard]] Result<void> last_save() const { return checkpoint_ ? checkpoint_->last_save() : Result<void>(); }

  // Fills in the part of the report that is known before the render.
  void fill_settings() {
    report_.size_px = stage_.size_px;
    report_.shutter = stage_.shutter;
    report_.spp_wanted = settings_.wanted_samples().count();
    report_.adaptive = options_.adaptive;
    report_.seed = options_.seed;
    report_.integrator = integrator_name(options_.integrator.kind);
    if (options_.integrator.kind == IntegratorKind::whitted) report_.whitted = options_.integrator.whitted;
    report_.guiding = options_.guiding;
    report_.schedule = options_.schedule;
    report_.accelerator = accel::kind_name(options_.accelerator);
    report_.accelerator_description = accel::kind_description(options_.accelerator);
    report_.view = request_.view->view();
    report_.times.build_s = stage_.build_s;
    report_.world = stage_.world->statistics();
  }

  void fill_report(const RenderOutcome& outcome) {
    report_.crop = outcome.film.crop();
    report_.mean_spp =
        static_cast<double>(outcome.film.total_samples()) / static_cast<double>(report_.crop.pixel_count());
    report_.interrupted = outcome.interrupted;
    if (outcome.work.training_paths && !options_.training_paths)
      report_.command_line += training_flag(*outcome.work.training_paths);
    if (outcome.work.light_paths && settings_.time_limit_s)
      report_.command_line += light_paths_flag(*outcome.work.light_paths);
    if (outcome.work.photons && settings_.time_limit_s) report_.command_line += photons_flag(*outcome.work.photons);
    if (outcome.work.direct_samples && settings_.time_limit_s)
      report_.command_line += direct_samples_flag(*outcome.work.direct_samples);
    if (outcome.work.reflection_samples && settings_.time_limit_s)
      report_.command_line += reflection_samples_flag(*outcome.work.reflection_samples);
    if (outcome.work.path_reuse && settings_.time_limit_s)
      report_.command_line += path_reuse_flag(*outcome.work.path_reuse);
    if (checkpoint_) report_.checkpoint = checkpoint_->report();
    report_.statistics = outcome.statistics;
    report_.times.render_s = outcome.statistics.render_s;
    report_.film_bytes = outcome.film.memory_bytes();
  }

  void warn_of_non_finite(const RayCounters& rays) {
    if (rays.non_finite == 0 || !rays.first_non_finite) return;
    const auto& [pixel, sample] = *rays.first_non_finite;
    run_.display.on_warning(fmt::format("non-finite radiance at pixel ({}, {}), sample {} ({} samples dropped in all); "
                                        "replay: {} --pixel {},{} --sample {}",
                                        pixel.x, pixel.y, sample, rays.non_finite, report_.command_line, pixel.x,
                                        pixel.y, sample));
  }

  const ImageRequest& request_;
  const RenderOptions& options_;
  RenderScene& scene_;
  RenderRun& run_;
  std::unique_ptr<Checkpoint> checkpoint_; // null if none is asked for
  RenderStage stage_;
  RenderSettings settings_;
  AccumulationIdentity identity_;
  AccumulationOutputs accumulations_;
  RenderReport report_;
};

} // namespace

Result<ImageResult> render_image(const ImageRequest& request, RenderScene& scene, RenderRun& run) {
  return ImageRender(request, scene, run).run();
}

} // namespace kindling::app
