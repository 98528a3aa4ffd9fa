// Checks names, skips finished frames, renders the others, reports.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/render_frames.h"

#include "renderer/app/output/choose_view.h"
#include "renderer/app/output/equal_frames.h"
#include "renderer/app/output/file_conflicts.h"
#include "renderer/app/output/frame_names.h"
#include "renderer/app/output/outputs.h"
#include "renderer/app/output/video.h"
#include "renderer/app/output/video_frame.h"
#include "renderer/app/render/frame_report.h"
#include "renderer/app/render/render_image.h"
#include "renderer/app/setup/camera_path.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/process_info.h"
#include "renderer/image/output_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <utility>

namespace kindling::app {

namespace {

namespace fs = std::filesystem;

// The videos among the outputs.
struct FrameVideos {
  std::vector<std::unique_ptr<VideoWriter>> writers;
  std::vector<std::string> commands; // that make them from images of the frames, where there is no ffmpeg
  std::vector<std::string> notes;
};

// Takes the videos from the outputs. Without ffmpeg images of the frames take their place.
FrameVideos take_videos(RenderOptions& options) {
  FrameVideos videos;
  const auto first = std::stable_partition(options.outputs.begin(), options.outputs.end(),
                                           [](const fs::path& output) { return !is_video(output); });
  const std::vector<fs::path> files(first, options.outputs.end());
  options.outputs.erase(first, options.outputs.end());
  const std::optional<fs::path> ffmpeg = files.empty() ? std::nullopt : find_ffmpeg();
  const double frames_per_s = options.shutter.frames_per_s.value_or(kDefaultFramesPerSecond);
  for (const fs::path& file : files) {
    if (ffmpeg) {
      videos.writers.push_back(std::make_unique<VideoWriter>(*ffmpeg, file, frames_per_s));
      options.frames.video_only |= options.outputs.empty();
      continue;
    }
    fs::path images = file;
    images.replace_filename(file.stem().string() + "-####.png");
    if (std::find(options.outputs.begin(), options.outputs.end(), images) == options.outputs.end())
      options.outputs.push_back(images);
    videos.commands.push_back(video_command(images, options.frames.numbers.front(), frames_per_s, file));
    videos.notes.push_back(fmt::format("{}: there is no ffmpeg (apt-get install ffmpeg): the frames are written as {}, "
                                       "and the command that makes the video is printed",
                                       file.string(), images.string()));
  }
  return videos;
}

class Frames {
 public:
  Frames(const RenderOptions& options, const std::string& command_line, RenderRun& run)
      : options_(options), videos_(take_videos(options_)), run_(run) {
    report_.command_line = command_line;
    report_.wanted = numbers().size();
    one_stats_file_ = !options.stats_file.empty() && count_frame_groups(options.stats_file) == 0;
  }

  Result<int> run() {
    if (Result<void> checked = check_names(); !checked.ok()) return checked.error();
    Result<DisplayTransform> view = choose_view(options_);
    if (!view.ok()) return view.error();
    if (Result<void> remain = check_inputs_remain(written_, with_role(kViewFile, view.value().files())); !remain.ok())
      return remain.error();
    const size_t last = last_to_render();
    if (last < numbers().size()) {
      Result<std::optional<CameraPath>> path = load_camera_path(options_);
      if (!path.ok()) return path.error();
      path_ = std::move(path).value();
      Result<std::unique_ptr<RenderScene>> scene = run_.load_scene(options_);
      if (!scene.ok()) return scene.error();
      scene_ = std::move(scene).value();
      if (Result<void> remain = check_inputs_remain(written_, with_role(kSceneFile, scene_->files)); !remain.ok())
        return remain.error();
      scene_->keep();
      if (const std::string equal = equal_frames_warning(scene_->scene, scene_->root, options_); !equal.empty())
        run_.console.warning(equal);
      report_.load_s = scene_->load_s;
    }
    Result<void> failed;
    for (size_t i = 0; i < numbers().size() && failed.ok() && report_.exit_code == kExitOk; ++i) {
      if (is_finished(i))
        failed = skip(i);
      else
        failed = render(i, view.value(), i == last);
    }
    return finish(failed);
  }

 private:
  [[nodiscard]] const std::vector<int>& numbers() const { return options_.frames.numbers; }
  [[nodiscard]] bool makes_videos() const { return !videos_.writers.empty(); }

  // Checks the outputs of all frames. No two frames may share a name, as a_#1.png of frame 1 and
  // a_#.png of frame 11 do.
  Result<void> check_names() {
    std::set<FileIdentity> names;
    for (const int frame : numbers()) {
      const RenderOptions own = options_of_frame(options_, frame);
      Result<std::vector<fs::path>> outputs = choose_outputs(own);
      if (!outputs.ok()) return outputs.error();
      for (NamedFile& file : files_written(own, outputs.value())) written_.push_back(std::move(file));
      for (const fs::path& output : outputs.value())
        if (!names.insert(FileIdentity(output)).second)
          return Error{ErrorKind::usage,
                       fmt::format("--output: {}: two images would have this name; use names that differ in more "
                                   "than the frame number",
                                   output.string())};
    }
    for (const std::unique_ptr<VideoWriter>& video : videos_.writers) {
      if (Result<void> writable = check_writable(video->file()); !writable.ok()) return writable;
      written_.push_back({"--output", video->file()});
      if (!names.insert(FileIdentity(video->file())).second)
        return usage_error(fmt::format("--output: {}: given twice", video->file().string()));
    }
    if (Result<void> remain = check_inputs_remain(written_, files_read(options_)); !remain.ok()) return remain;
    for (const std::string& note : videos_.notes) run_.console.warning(note);
    return {};
  }

  [[nodiscard]] bool is_finished(size_t i) const {
    if (options_.frames.force) return false;
    const RenderOptions own = options_of_frame(options_, numbers()[i]);
    std::error_code ignored;
    if (!one_stats_file_ && !own.stats_file.empty() && !fs::exists(own.stats_file, ignored)) return false;
    if (!std::all_of(own.outputs.begin(), own.outputs.end(), is_finished_image)) return false;
    return !makes_videos() || find_frame_of_video(own.outputs); // a video needs all frames
  }

  // Returns the frame of the first image that shows it as the video does.
  [[nodiscard]] static std::optional<VideoFrame> find_frame_of_video(const std::vector<fs::path>& images) {
    for (const fs::path& image : images)
      if (std::optional<VideoFrame> frame = read_video_frame(image)) return frame;
    return std::nullopt;
  }

  // Returns the index of the last frame to render; the number of frames if there is none.
  [[nodiscard]] size_t last_to_render() const {
    for (size_t i = numbers().size(); i-- > 0;)
      if (!is_finished(i)) return i;
    return numbers().size();
  }

  // `i` is finished.
  Result<void> skip(size_t i) {
    report_.skipped.push_back(numbers()[i]);
    run_.console.detail(fmt::format("frame {}: exists, skipped", numbers()[i]));
    if (!makes_videos()) return {};
    const std::optional<VideoFrame> frame = find_frame_of_video(options_of_frame(options_, numbers()[i]).outputs);
    if (!frame)
      return Error{ErrorKind::input_output, fmt::format("frame {}: its image has changed meanwhile", numbers()[i])};
    return add_to_videos(frame->rgb, frame->size_px);
  }

  Result<void> render(size_t i, const DisplayTransform& view, bool last) {
    const int frame = numbers()[i];
    ImageRequest request{options_of_frame(options_, frame),
                         fmt::format("{} --frames {}", report_.command_line, frame),
                         {},
                         &view,
                         frame,
                         !last};
    request.outputs = request.options.outputs;
    if (one_stats_file_) request.options.stats_file.clear();
    if (Result<void> placed = place_on_path(path_, *scene_, request.options); !placed.ok()) return placed;
    // Times of the first frame include loading, as those of a single render do.
    const double start_s = started_ == 0 ? 0.0 : seconds_since_process_start();
    request.start_s = start_s;
    if (makes_videos())
      request.frame_pixels = [this](const std::vector<uint8_t>& rgb, const V2i& size_px) {
        return add_to_videos(rgb, size_px);
      };
    run_.start_frame(frame, i + 1, numbers().size());
    const Result<ImageResult> result = render_image(request, *scene_, run_);
    ++started_;
    run_.end_frame();
    if (!result.ok()) return result.error();
    report_.exit_code = result.value().exit_code;
    if (!result.value().report) return {};
    const RenderReport& report = *result.value().report;
    if (!report.interrupted) report_.rendered.push_back(frame);
    if (one_stats_file_) report_.statistics.push_back(format_stats_json(report, false));
    report_.phases.build_s += report.times.build_s;
    report_.phases.render_s += report.times.render_s;
    report_.phases.write_s += report.times.write_s;
    if (!run_.console.settings().json) run_.console.line(format_frame_line(report, i + 1, numbers().size()));
    return {};
  }

  Result<void> add_to_videos(const std::vector<uint8_t>& rgb, const V2i& size_px) {
    for (const std::unique_ptr<VideoWriter>& video : videos_.writers)
      if (Result<void> added = video->add(rgb, size_px); !added.ok()) return added;
    return {};
  }

  // Completes the videos, unless frames are missing. Prints their names, or the commands that make
  // them.
  Result<void> finish_videos(bool complete) {
    std::string lines;
    for (const std::unique_ptr<VideoWriter>& video : videos_.writers) {
      if (!complete) {
        run_.console.note(fmt::format("{}: was not written: frames are missing", video->file().string()));
        continue;
      }
      if (Result<void> finished = video->finish(); !finished.ok()) return finished;
      lines += video->file().string() + "\n";
    }
    if (complete)
      for (const std::string& command : videos_.commands) lines += command + "\n";
    return print(lines);
  }

  Result<int> finish(Result<void> failed) {
    Result<void> videos = finish_videos(failed.ok() && report_.exit_code == kExitOk);
    if (failed.ok()) failed = videos;
    if (!failed.ok()) report_.exit_code = exit_code_of(failed.error().kind);
    report_.total_s = seconds_since_process_start();
    Result<void> stats;
    if (one_stats_file_ && started_ > 0)
      stats = write_text_file(options_.stats_file, format_frames_json(report_, false) + "\n");
    run_.console.line(run_.console.settings().json ? format_frames_json(report_, true)
                                                   : format_frames_summary(report_));
    if (!failed.ok()) return failed.error();
    if (!stats.ok()) return stats.error();
    return report_.exit_code;
  }

  RenderOptions options_; // without the names of videos
  FrameVideos videos_;
  RenderRun& run_;
  bool one_stats_file_ = false;
  std::vector<NamedFile> written_; // by all frames
  std::unique_ptr<RenderScene> scene_;
  std::optional<CameraPath> path_; // of --camera-path
  size_t started_ = 0;
  FramesReport report_;
};

} // namespace

Result<int> render_frames(const RenderOptions& options, const std::string& command_line, RenderRun& run) {
  return Frames(options, command_line, run).run();
}

} // namespace kindling::app
